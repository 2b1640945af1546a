//! TOML from outside as trees of values: scenes, liquids, setups. Keys stay mostly right, and values are hostile.

use crate::mutation::cases;
use crate::recordings;
use meniscus_data::liquids::Liquid;
use meniscus_data::motion::Motion;
use meniscus_data::scene_file::Experiment;
use meniscus_service::setup::Setup;
use proptest::prelude::*;
use std::path::Path;
use toml::Value;

/// A sound scene with every key.
pub(crate) const SCENE: &str = "liquid = 'honey'\nmotion = 'strokes:1001'\nspacing_mm = 2.5\nstep_us = 100.0\n[glass]\nradius_m = 0.035\n\
    fill_m = 0.07\nrim_m = 0.11\ntaper = 0.05\n[effects]\nfoam = 0.1\nwall_slip = { value = 1.0, source = 'x' }\n";

/// A sound scene of a glass that is given by its profile.
pub(crate) const CURVED: &str =
    "[glass]\nfill_m = 0.07\nprofile_m = [[0.02, 0.0], [0.03, 0.03], [0.035, 0.07], [0.036, 0.11]]\n";

/// A sound liquid.
pub(crate) const LIQUID: &str = include_str!("../../liquids/glycerine.toml");

/// A sound setup.
pub(crate) const SETUP: &str = "made_by = 'x'\n[glass]\nradius_mm = 35.0\nfill_mm = 70.0\nrim_mm = 110.0\n[liquid]\n\
    tone = 'dark'\nleast_contrast = 25.0\n[view]\ncamera = 'x'\ndistance_mm = 300.0\nheight_mm = 90.0\npitch_deg = 1.0\n";

/// Values that a field may get.
fn hostile(which: usize) -> Value {
    let numbers = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0, -0.0, -1.0, 1e-300, 1e300, 1e9, 0.04];
    let texts =
        ["", "honey", "strokes:18446744073709551615", "sine:nan,inf", "/dev/zero", "\u{1b}[2J", "hold"];
    match which % 22 {
        at @ 0..10 => Value::Float(numbers[at]),
        at @ 10..17 => Value::String(texts[at - 10].into()),
        17 => Value::Integer(i64::MIN),
        18 => Value::Boolean(true),
        19 => Value::Array(vec![Value::Float(f64::NAN); 3]),
        20 => Value::Array(vec![Value::Array(vec![Value::Float(0.03), Value::Float(0.01)]); 400]),
        _ => Value::Table(toml::Table::new()),
    }
}

/// Leaves and branches below `value`, itself left out.
fn count(value: &Value) -> usize {
    match value {
        Value::Table(all) => all.values().map(|inner| 1 + count(inner)).sum(),
        Value::Array(all) => all.iter().map(|inner| 1 + count(inner)).sum(),
        _ => 0,
    }
}

/// Sets the `at`-th value below `value`.
fn set(value: &mut Value, at: &mut usize, new: &Value) {
    let mut one = |inner: &mut Value| {
        if *at == 0 {
            *inner = new.clone();
        }
        *at = at.wrapping_sub(1);
        set(inner, at, new);
    };
    match value {
        Value::Table(all) => all.iter_mut().for_each(|(_, inner)| one(inner)),
        Value::Array(all) => all.iter_mut().for_each(one),
        _ => {}
    }
}

/// Returns `sound` with some of its values replaced.
pub(crate) fn altered(sound: &str, changes: &[(usize, usize)]) -> String {
    let mut tree = Value::Table(toml::from_str(sound).expect("sound TOML"));
    for (at, value) in changes {
        let mut left = at % count(&tree).max(1);
        set(&mut tree, &mut left, &hostile(*value));
    }
    toml::to_string(&tree).unwrap_or_default()
}

fn changes() -> impl Strategy<Value = Vec<(usize, usize)>> {
    prop::collection::vec((any::<usize>(), any::<usize>()), 1..4)
}

proptest! {
    #![proptest_config(cases(2_000))]

    #[test]
    fn scenes(changes in changes(), curved: bool) {
        let text = altered(if curved { CURVED } else { SCENE }, &changes);
        if let Ok(scene) = Experiment::parse(Path::new("a.toml"), &text)
            && let Some(spelling) = &scene.motion
            && let Ok(motion) = Motion::parse(spelling, 2.0)
        {
            prop_assert!(motion.position(1.0).is_finite() && motion.acceleration(1.0).is_finite(), "{spelling}");
        }
    }

    #[test]
    fn liquids(changes in changes()) {
        if let Ok(liquid) = Liquid::parse("a.toml", &altered(LIQUID, &changes)) {
            prop_assert!(liquid.density_kg_m3.is_finite() && liquid.density_kg_m3 > 0.0);
            let thick = liquid.rheology.viscosity(1.0);
            prop_assert!((0.0..=1000.0).contains(&thick), "{thick} Pa s");
        }
    }

    #[test]
    fn setups(changes in changes()) {
        let folder = recordings::scratch("fuzz-setup");
        let path = folder.0.join("glass.toml");
        std::fs::write(&path, altered(SETUP, &changes)).expect("written");
        if let Ok(setup) = Setup::read(&path) {
            prop_assert!(setup.view.distance_mm.is_finite() && setup.view.height_mm.is_finite());
        }
    }
}
