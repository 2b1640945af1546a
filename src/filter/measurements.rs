//! Updates of the filter by the position of the glass, by the 21 heights and by the encoder.
//!
//! Every measurement is scalar ([`LentCovariance::update`]), and the innovation of each counts what the ones before it
//! have moved already, z - h(y-) - c.dy: the expansion stays about the predicted state.

use super::covariance::{LentCovariance, Measurement};
use super::kalman::{Filter, travel_gain_mm};
use super::state::{StateIndex, StateVector};
use crate::blob::{FilterConfig, Model, ScaleBounds};
use crate::latent::generic::{LATENTS, Latent};
use crate::latent::linearisation::Linearisation;
use crate::math::pow;
use crate::real::{Real, narrow, widen};
use crate::surface::{POINTS, SurfaceProfile};
use crate::uncertainty::discrepancy::LEAST_M2;

/// Least variance of the encoder's reading in its own standard deviations, against a blob that claims to be exact.
const LEAST_READING_VARIANCE: f64 = 1e-6;

/// Whether the noise scales follow the innovations of a turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Adaptation {
    /// They follow: the filter has settled.
    Follow,
    /// They stay: after a start or a gap innovations say how wrong the prior was, not how wrong the model is.
    Hold,
}

/// Circumstances of an update.
#[derive(Clone, Copy, Debug)]
pub(crate) struct UpdateContext {
    /// Slosh energy of the predicted state, in units of H.
    pub(crate) latent_energy: f64,
    /// Whether the noise scales follow.
    pub(crate) adaptation: Adaptation,
}

/// Latents and input that the encoder reads off its window.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reading {
    /// x.
    pub(crate) latent: Latent,
    /// u.
    pub(crate) input: f64,
}

/// Result of an update.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use]
pub(crate) enum Update {
    /// The estimate has moved.
    Accepted,
    /// The correction was not finite: a hostile blob, or a height that is no number. The filter is back at its prior.
    Refused,
}

/// Corrections of several scalar measurements, added up.
struct Sum<R> {
    moved: StateVector<R>,
    normalised_innovations: R,
    count: f64,
}

impl<R: Real> Sum<R> {
    fn new() -> Self {
        Self { moved: StateVector::zeros(), normalised_innovations: R::default(), count: 0.0 }
    }

    /// Updates the covariance by one measurement with slopes `c`, and adds its correction.
    fn add(&mut self, p: &mut LentCovariance<'_, R>, c: &StateVector<R>, measurement: Measurement<R>) {
        let correction = p.update(c, measurement);
        self.moved += correction.moved;
        self.normalised_innovations += correction.normalised_innovation;
        self.count += 1.0;
    }
}

impl Filter {
    /// Takes the position `x_m` of the glass in the frame behind the step that is to come.
    pub(crate) fn update_position<R: Real>(&mut self, model: &Model<'_>, latent: &mut Latent, x_m: f64) {
        let FilterConfig { position_noise_mm: noise, position_gate: gate, .. } = model.header.filter;
        let (gain, [travel, position]) = (travel_gain_mm(model), self.glass_mm);
        // X- = X + W + dt^2 g u.
        let mut c = StateVector::zeros();
        for (index, slope) in
            [(StateIndex::Input, gain), (StateIndex::GlassTravel, 1.0), (StateIndex::GlassPosition, 1.0)]
        {
            if let Some(slot) = c.get_mut(index.index()) {
                *slot = R::of(slope);
            }
        }
        let innovation = 1e3 * x_m - (position + travel + gain * self.input());
        let measurement =
            Measurement { innovation: R::of(innovation), noise: R::of(noise * noise), gate: R::of(gate) };
        let correction = self.covariance.lend(|mut p| p.update(&c, measurement));
        self.shift(latent, &widen(&correction.moved));
    }

    /// Takes the seen heights of `profile`, whose prediction is `about`.
    pub(crate) fn update_heights<R: Real>(
        &mut self,
        model: &Model<'_>,
        latent: &mut Latent,
        profile: &SurfaceProfile,
        about: &Linearisation,
        context: UpdateContext,
    ) -> Update {
        let config = &model.header.filter;
        let w = model.error_model.weight(context.latent_energy);
        let [lateral_mm, _] = self.lateral_mm;
        let sum = self.covariance.lend(|mut p| {
            let mut sum = Sum::<R>::new();
            for point in 0..POINTS {
                let Some(height) = Height::seen(model, profile, about, point) else { continue };
                let residual = height.residual_m - height.lateral_slope * lateral_mm;
                let measurement = Measurement {
                    innovation: R::of(residual) - height.slopes.dot(&sum.moved),
                    noise: R::of(height.variance_m2 + (w * height.misfit_m2).max(0.0)),
                    gate: R::of(config.innovation_gate),
                };
                sum.add(&mut p, &height.slopes, measurement);
            }
            sum
        });
        if context.adaptation == Adaptation::Follow && sum.count > 0.0 {
            let mean = sum.normalised_innovations.wide() / sum.count;
            self.process_noise_scale =
                follow(self.process_noise_scale, mean, config.adaptation_rate, config.process_noise_scale);
        }
        self.accept(config, latent, &widen(&sum.moved))
    }

    /// Takes what the encoder read, after the heights.
    pub(crate) fn update_reading<R: Real>(
        &mut self,
        model: &Model<'_>,
        latent: &mut Latent,
        reading: &Reading,
        context: UpdateContext,
    ) -> Update {
        let config = &model.header.filter;
        let (whiten, gate) = (&model.error_model.reading, config.innovation_gate);
        let scale = config.encoder_noise_factor * self.measurement_noise_scale;
        let noise = (scale * model.error_model.weight(context.latent_energy)).max(LEAST_READING_VARIANCE);
        // In whitened coordinates the errors of the latents are independent, so that they may come one by one.
        let whiten = narrow::<R, _, _>(whiten);
        let residual = whiten * narrow::<R, _, _>(&(reading.latent - *latent));
        let (input, gate) = (reading.input - self.input(), R::of(gate));
        let input_noise = config.encoder_input_std * config.encoder_input_std;
        let mut sum = Sum::<R>::new();
        let latents = self.covariance.lend(|mut p| {
            for (row, residual) in whiten.row_iter().zip(residual.iter()) {
                let c = StateVector::from_fn(|i, _| row.get(i).copied().unwrap_or_default());
                let innovation = *residual - c.dot(&sum.moved);
                sum.add(&mut p, &c, Measurement { innovation, noise: R::of(noise), gate });
            }
            let latents = sum.normalised_innovations.wide() / LATENTS as f64;
            let c = StateVector::from_fn(|i, _| R::of(f64::from(u8::from(i == StateIndex::Input.index()))));
            let innovation = R::of(input) - c.dot(&sum.moved);
            sum.add(&mut p, &c, Measurement { innovation, noise: R::of(input_noise), gate });
            latents
        });
        if context.adaptation == Adaptation::Follow {
            let (rate, bounds) = (config.adaptation_rate, config.measurement_noise_scale);
            self.measurement_noise_scale = follow(self.measurement_noise_scale, latents, rate, bounds);
        }
        self.accept(config, latent, &widen(&sum.moved))
    }

    /// Moves the estimate, or returns to the prior where the correction is not finite.
    fn accept(&mut self, config: &FilterConfig, latent: &mut Latent, moved: &StateVector) -> Update {
        if moved.iter().all(|v| v.is_finite()) && self.covariance.is_finite() {
            self.shift(latent, moved);
            return Update::Accepted;
        }
        *self = Self::new(config);
        Update::Refused
    }
}

/// One seen height beside its prediction.
struct Height<R> {
    /// Measured minus decoded, without the cross-axis slosh, m.
    residual_m: f64,
    /// Variance of the measurement, m2.
    variance_m2: f64,
    /// d, m2.
    misfit_m2: f64,
    /// Slope in the cross-axis slosh, m per mm.
    lateral_slope: f64,
    /// Slopes in the state.
    slopes: StateVector<R>,
}

impl<R: Real> Height<R> {
    /// The height at `point`; `None` where it was not seen.
    fn seen(
        model: &Model<'_>,
        profile: &SurfaceProfile,
        about: &Linearisation,
        point: usize,
    ) -> Option<Self> {
        if !*profile.valid.get(point)? {
            return None;
        }
        let measured = f64::from(*profile.height_m.get(point)?);
        let decoded = f64::from(*about.heights_m.get(point)?);
        let input_slope = R::from(*about.input_slopes_m.get(point)?);
        let lateral_slope = 1e-3 * model.cross_axis.shape.get(point)?;
        let latent_slope = |latent: usize| about.latent_slopes_m.get(latent).and_then(|s| s.get(point));
        let (input, lateral) = (StateIndex::Input.index(), StateIndex::Lateral.index());
        let slopes = StateVector::from_fn(|i, _| match latent_slope(i) {
            Some(slope) => R::from(*slope),
            None if i == input => input_slope,
            None if i == lateral => R::of(lateral_slope),
            None => R::default(),
        });
        Some(Self {
            residual_m: measured - decoded,
            variance_m2: f64::from(*profile.variance_m2.get(point)?).max(LEAST_M2),
            misfit_m2: f64::from(*model.error_model.surface_misfit.get(point)?),
            lateral_slope,
            slopes,
        })
    }
}

/// A noise scale moved by the mean normalised innovation squared, which is one where the covariances are right.
fn follow(scale: f64, mean: f64, rate: f64, bounds: ScaleBounds) -> f64 {
    (scale * pow(mean.max(f64::MIN_POSITIVE), rate)).max(bounds.min).min(bounds.max)
}
