//! Settings of the Kalman filter, stored in the blob of the model that they were tuned for.

use super::LoadError;
use serde::{Deserialize, Serialize};

/// Smallest standard deviation, gate or scale that a blob may state: its square is still far above rounding.
const SMALLEST: f64 = 1e-9;

/// Largest number that a blob may state: its fourth power is still finite in double precision.
const LARGEST: f64 = 1e6;

/// Largest weight of a past input: the second-degree extrapolation u(n+1) = 3 u - 3 u' + u'' has none larger.
const LARGEST_WEIGHT: f64 = 3.0;

/// Range of an adaptive noise scale.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ScaleBounds {
    /// Smallest scale.
    pub min: f64,
    /// Largest scale.
    pub max: f64,
}

/// Noise, priors, gates and adaptation of the filter in `src/filter/kalman.rs`.
///
/// An input is in units of the port: acceleration of the glass over the header's `acceleration_scale`. Unless a field says
/// otherwise, its value in [`Self::REFERENCE`] was chosen on the two validation recordings of the shipped model and on
/// recordings of water, butter and blood that a correction learns from.
///
/// ```
/// use meniscus::blob::FilterConfig;
///
/// // A robot arm that moves more abruptly than the hands of the recordings.
/// let abrupt = FilterConfig { input_noise_std: 0.3, ..FilterConfig::REFERENCE };
/// assert!(abrupt.check().is_ok());
/// let broken = FilterConfig { input_noise_std: -0.3, ..FilterConfig::REFERENCE };
/// assert!(broken.check().is_err());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FilterConfig {
    /// Weights of u, u' and u'' in the predicted input u(n+1): an autoregression fitted to hand and robot motion.
    pub input_recursion: [f64; 3],
    /// Standard deviation of the input's prediction error in one turn, port units.
    pub input_noise_std: f64,
    /// Prior standard deviation of an input that nothing is known of, port units.
    pub input_prior_std: f64,
    /// Standard deviation of an input measured by an IMU or stated by a robot, port units.
    pub measured_input_std: f64,
    /// Standard deviation of the input that the encoder reads off its window, port units.
    pub encoder_input_std: f64,
    /// Standard deviation of the tracked position of the glass, mm: 0.007 behind the rendered camera, rounded up.
    pub position_noise_mm: f64,
    /// Prior standard deviation of the glass's travel in one turn, mm: 6 m/s at 60 Hz, faster than any hand.
    pub travel_prior_mm: f64,
    /// Prior standard deviation of the glass's position, mm: wider than the camera's view.
    pub position_prior_mm: f64,
    /// Standard deviation of new cross-axis slosh in one turn, port units. Chosen with the next field on glycerine moved
    /// along a line, moved as by a hand (seed 1401), and on butter.
    pub lateral_noise_std: f64,
    /// New cross-axis slosh in one turn as a share of the present one. A larger value missed the surface target of the
    /// unseen butter recording.
    pub lateral_noise_share: f64,
    /// Prior standard deviation of the cross-axis slosh, mm.
    pub lateral_prior_mm: f64,
    /// Factor on the covariance of the encoder's reading: 2, because the encoder has read the same heights.
    pub encoder_noise_factor: f64,
    /// Innovation gate of heights and encoder readings, in standard deviations.
    pub innovation_gate: f64,
    /// Innovation gate of the glass's position, in standard deviations: wide, because a hand may jerk.
    pub position_gate: f64,
    /// Exponent of the normalised innovation squared by which both noise scales follow it in a turn.
    pub adaptation_rate: f64,
    /// Range of the process noise scale.
    pub process_noise_scale: ScaleBounds,
    /// Range of the measurement noise scale of the encoder.
    pub measurement_noise_scale: ScaleBounds,
}

impl FilterConfig {
    /// The settings of the shipped models, and of every blob before format version 4.
    pub const REFERENCE: Self = Self {
        input_recursion: [1.4, -0.1, -0.45],
        input_noise_std: 0.12,
        input_prior_std: 0.7,
        measured_input_std: 0.05,
        encoder_input_std: 0.1,
        position_noise_mm: 0.01,
        travel_prior_mm: 100.0,
        position_prior_mm: 1000.0,
        lateral_noise_std: 0.003,
        lateral_noise_share: 0.05,
        lateral_prior_mm: 1.0,
        encoder_noise_factor: 2.0,
        innovation_gate: 5.0,
        position_gate: 30.0,
        adaptation_rate: 0.1,
        process_noise_scale: ScaleBounds { min: 0.3, max: 30.0 },
        measurement_noise_scale: ScaleBounds { min: 1.0, max: 1000.0 },
    };

    /// Refuses settings that no filter can work with.
    ///
    /// # Errors
    /// [`LoadError::HeaderValue`] with the field and its value: NaN, infinite, out of range, or bounds in the wrong order.
    pub fn check(&self) -> Result<(), LoadError> {
        let [first, second, third] = self.input_recursion;
        for (field, value) in [
            ("filter.input_recursion[0]", first),
            ("filter.input_recursion[1]", second),
            ("filter.input_recursion[2]", third),
        ] {
            require(field, value, value.abs() <= LARGEST_WEIGHT)?;
        }
        for (field, value) in self.positive() {
            require(field, value, (SMALLEST..=LARGEST).contains(&value))?;
        }
        for (field, value) in [
            ("filter.lateral_noise_std", self.lateral_noise_std),
            ("filter.lateral_noise_share", self.lateral_noise_share),
        ] {
            require(field, value, (0.0..=LARGEST).contains(&value))?;
        }
        let rate = self.adaptation_rate;
        require("filter.adaptation_rate", rate, (0.0..=1.0).contains(&rate))?;
        for (field, bounds) in [
            ("filter.process_noise_scale (max below min)", self.process_noise_scale),
            ("filter.measurement_noise_scale (max below min)", self.measurement_noise_scale),
        ] {
            require(field, bounds.max, bounds.min <= bounds.max)?;
        }
        Ok(())
    }

    /// Fields that have to be above zero, by name.
    fn positive(&self) -> [(&'static str, f64); 15] {
        let (process, measurement) = (self.process_noise_scale, self.measurement_noise_scale);
        [
            ("filter.input_noise_std", self.input_noise_std),
            ("filter.input_prior_std", self.input_prior_std),
            ("filter.measured_input_std", self.measured_input_std),
            ("filter.encoder_input_std", self.encoder_input_std),
            ("filter.position_noise_mm", self.position_noise_mm),
            ("filter.travel_prior_mm", self.travel_prior_mm),
            ("filter.position_prior_mm", self.position_prior_mm),
            ("filter.lateral_prior_mm", self.lateral_prior_mm),
            ("filter.encoder_noise_factor", self.encoder_noise_factor),
            ("filter.innovation_gate", self.innovation_gate),
            ("filter.position_gate", self.position_gate),
            ("filter.process_noise_scale.min", process.min),
            ("filter.process_noise_scale.max", process.max),
            ("filter.measurement_noise_scale.min", measurement.min),
            ("filter.measurement_noise_scale.max", measurement.max),
        ]
    }
}

/// Refuses `value` of `field` unless it is `sound`; NaN is never sound, as it compares with nothing.
fn require(field: &'static str, value: f64, sound: bool) -> Result<(), LoadError> {
    if sound { Ok(()) } else { Err(LoadError::HeaderValue { field, value }) }
}

impl Default for FilterConfig {
    fn default() -> Self {
        Self::REFERENCE
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Spoil = fn(&mut FilterConfig, f64);

    /// Every field is refused by its own name when it is NaN or negative where it may not be.
    #[test]
    fn hostile_values_are_refused_by_name() {
        let fields: [(&str, Spoil); 19] = [
            ("input_recursion[0]", |c, v| c.input_recursion[0] = 3.0 * v),
            ("input_recursion[1]", |c, v| c.input_recursion[1] = 3.0 * v),
            ("input_recursion[2]", |c, v| c.input_recursion[2] = 3.0 * v),
            ("input_noise_std", |c, v| c.input_noise_std = v),
            ("input_prior_std", |c, v| c.input_prior_std = v),
            ("measured_input_std", |c, v| c.measured_input_std = v),
            ("encoder_input_std", |c, v| c.encoder_input_std = v),
            ("position_noise_mm", |c, v| c.position_noise_mm = v),
            ("travel_prior_mm", |c, v| c.travel_prior_mm = v),
            ("position_prior_mm", |c, v| c.position_prior_mm = v),
            ("lateral_noise_std", |c, v| c.lateral_noise_std = v),
            ("lateral_noise_share", |c, v| c.lateral_noise_share = v),
            ("lateral_prior_mm", |c, v| c.lateral_prior_mm = v),
            ("encoder_noise_factor", |c, v| c.encoder_noise_factor = v),
            ("innovation_gate", |c, v| c.innovation_gate = v),
            ("position_gate", |c, v| c.position_gate = v),
            ("adaptation_rate", |c, v| c.adaptation_rate = v),
            ("process_noise_scale.min", |c, v| c.process_noise_scale.min = v),
            ("measurement_noise_scale.max", |c, v| c.measurement_noise_scale.max = v),
        ];
        for (name, spoil) in fields {
            for value in [f64::NAN, f64::INFINITY, -1.5, 1e9] {
                let mut config = FilterConfig::REFERENCE;
                spoil(&mut config, value);
                let Err(LoadError::HeaderValue { field, .. }) = config.check() else {
                    panic!("{name} = {value} is let through");
                };
                assert_eq!(field.strip_prefix("filter."), Some(name));
            }
        }
    }

    #[test]
    fn bounds_in_the_wrong_order_are_refused() {
        let swapped = ScaleBounds { min: 2.0, max: 1.0 };
        let config = FilterConfig { process_noise_scale: swapped, ..FilterConfig::REFERENCE };
        let refusal =
            LoadError::HeaderValue { field: "filter.process_noise_scale (max below min)", value: 1.0 };
        assert_eq!(config.check(), Err(refusal));
        assert_eq!(FilterConfig::REFERENCE.check(), Ok(()));
    }
}
