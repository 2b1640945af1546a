//! Parameters of the node: facts of the run, which cannot be changed, and two settings, which can.

use meniscus::blob::{FieldGroup, Header};
use ros2_client::{NodeOptions, ParameterValue};
use std::ops::RangeInclusive;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Rate of `/liquid/tracers`, Hz.
const TRACERS_HZ: &str = "tracers_hz";
/// Probability of spilling above which the node warns.
const SPILL_LIMIT: &str = "spill_limit";

/// Range of the rate, Hz.
pub(crate) const TRACERS_HZ_RANGE: RangeInclusive<f64> = 0.0..=60.0;
/// Range of the limit.
pub(crate) const SPILL_LIMIT_RANGE: RangeInclusive<f64> = 0.0..=1.0;

/// Settings that may be changed while the run goes; each is one number, read without a lock.
#[derive(Debug)]
pub struct LiveSettings {
    tracers_hz: AtomicU64,
    spill_limit: AtomicU64,
}

impl LiveSettings {
    /// Returns settings with these values.
    #[must_use]
    pub fn new(tracers_hz: f64, spill_limit: f64) -> Self {
        let of = |value: f64| AtomicU64::new(value.to_bits());
        Self { tracers_hz: of(tracers_hz), spill_limit: of(spill_limit) }
    }

    /// Returns the rate of the tracers' cloud, Hz; 0 for none.
    #[must_use]
    pub fn tracers_hz(&self) -> f64 {
        f64::from_bits(self.tracers_hz.load(Ordering::Relaxed))
    }

    /// Returns the probability of spilling above which the node warns.
    #[must_use]
    pub fn spill_limit(&self) -> f64 {
        f64::from_bits(self.spill_limit.load(Ordering::Relaxed))
    }

    /// Sets the setting `name`; another name changes nothing.
    fn set(&self, name: &str, value: f64) {
        match name {
            TRACERS_HZ => self.tracers_hz.store(value.to_bits(), Ordering::Relaxed),
            SPILL_LIMIT => self.spill_limit.store(value.to_bits(), Ordering::Relaxed),
            _ => {}
        }
    }
}

/// Facts of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Facts {
    /// The model, as the user named it.
    pub model: String,
    /// The camera, as a person reads it.
    pub camera: String,
}

/// Returns the parameters that cannot be changed.
fn fixed(facts: &Facts, header: &Header) -> Vec<(&'static str, ParameterValue)> {
    let names = ["q", "v", "e", "sigma", "tau", "surface"];
    let known = FieldGroup::ALL.into_iter().zip(names).filter(|(group, _)| header.known().contains(*group));
    let number = |number: u64| ParameterValue::Integer(i64::try_from(number).unwrap_or(i64::MAX));
    vec![
        ("camera", ParameterValue::String(facts.camera.clone())),
        ("fill_height", ParameterValue::Double(header.fill_m)),
        ("known_groups", ParameterValue::StringArray(known.map(|(_, name)| name.to_owned()).collect())),
        ("liquid", ParameterValue::String(header.liquid.as_str().to_owned())),
        ("model", ParameterValue::String(facts.model.clone())),
        ("model_version", number(header.model_version)),
        ("radius", ParameterValue::Double(header.radius_m)),
        ("rim_height", ParameterValue::Double(header.rim_m)),
        ("tracers", number(u64::from(header.particles))),
    ]
}

/// Returns the range of a setting with its unit; `None` for what is none.
fn range(name: &str) -> Option<(RangeInclusive<f64>, &'static str)> {
    match name {
        TRACERS_HZ => Some((TRACERS_HZ_RANGE, " Hz")),
        SPILL_LIMIT => Some((SPILL_LIMIT_RANGE, "")),
        _ => None,
    }
}

/// Refuses a change, with the reason.
fn check(fixed: &[(&str, ParameterValue)], name: &str, value: &ParameterValue) -> Result<(), String> {
    if let Some((_, is)) = fixed.iter().find(|(fixed, _)| *fixed == name) {
        let why = "is a fact of the run: start it with another model or camera to change it";
        return if is == value { Ok(()) } else { Err(format!("{name} {why}")) };
    }
    let Some((range, unit)) = range(name) else { return Err(format!("there is no parameter {name}")) };
    match value {
        ParameterValue::Double(value) if range.contains(value) => Ok(()),
        ParameterValue::Double(value) => {
            Err(format!("{name} {value} is out of range: {} to {}{unit}", range.start(), range.end()))
        }
        ParameterValue::NotSet => Err(format!("{name} cannot be removed: set it")),
        _ => Err(format!("{name} is a number with a decimal point, such as {:.1}", range.end())),
    }
}

/// Returns the options of the node with all parameters; changes go to `live`.
pub(crate) fn options(facts: &Facts, header: &Header, live: &Arc<LiveSettings>) -> NodeOptions {
    let fixed = fixed(facts, header);
    let settings = [(TRACERS_HZ, live.tracers_hz()), (SPILL_LIMIT, live.spill_limit())];
    let settings = settings.map(|(name, value)| (name, ParameterValue::Double(value)));
    let mut options = NodeOptions::new().enable_rosout(false);
    for (name, value) in fixed.iter().chain(&settings) {
        options = options.declare_parameter(name, value.clone());
    }
    let live = Arc::clone(live);
    options.parameter_validator(Box::new(move |name, value| check(&fixed, name, value))).parameter_set_action(
        Box::new(move |name, value| {
            if let ParameterValue::Double(value) = value {
                live.set(name, *value);
            }
            Ok(())
        }),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_change_and_everything_else_is_refused_with_the_reason() {
        let fixed = [("liquid", ParameterValue::String("glycerine".into()))];
        let refusal = |name, value| check(&fixed, name, &value).expect_err("refused");
        assert_eq!(check(&fixed, TRACERS_HZ, &ParameterValue::Double(10.0)), Ok(()));
        assert_eq!(check(&fixed, "liquid", &fixed[0].1), Ok(()), "the value that it has");
        for (name, value, why) in [
            (TRACERS_HZ, ParameterValue::Double(61.0), "tracers_hz 61 is out of range: 0 to 60 Hz"),
            (TRACERS_HZ, ParameterValue::Double(f64::NAN), "tracers_hz NaN is out of range"),
            (SPILL_LIMIT, ParameterValue::Double(-0.1), "out of range: 0 to 1"),
            (SPILL_LIMIT, ParameterValue::NotSet, "cannot be removed"),
            (SPILL_LIMIT, ParameterValue::Integer(1), "with a decimal point"),
            ("liquid", ParameterValue::String("water".into()), "is a fact of the run"),
            ("liquid", ParameterValue::NotSet, "is a fact of the run"),
            ("colour", ParameterValue::Double(1.0), "there is no parameter colour"),
        ] {
            let is = refusal(name, value);
            assert!(is.contains(why), "{is}");
        }
        let live = LiveSettings::new(60.0, 0.05);
        live.set(TRACERS_HZ, 7.5);
        live.set(SPILL_LIMIT, 0.5);
        assert_eq!((live.tracers_hz(), live.spill_limit()), (7.5, 0.5));
    }
}
