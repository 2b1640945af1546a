//! One meaning of every value: SI value, coordinate and back.
#![allow(clippy::disallowed_methods, reason = "a test may take the platform's functions")]

extern crate std;

use super::*;
use std::{assert, assert_eq, format};

const STATED: Stated = Stated { consistency_pa_sn: 0.95, radius_m: 0.035, fill_m: 0.07 };

#[test]
fn kinds_list_and_spellings_agree() {
    for (kind, effect) in EffectKind::ALL.into_iter().zip(&LIBRARY) {
        assert_eq!((kind, kind.name()), (effect.kind, effect.name));
        for (n, parameter) in effect.parameters.iter().enumerate() {
            let wanted =
                if n == 0 { effect.name.into() } else { format!("{}_{}", effect.name, parameter.name) };
            assert_eq!(parameter.spelling, wanted);
            let found = find_parameter(parameter.spelling).map(|(effect, which)| (effect.kind, which));
            assert_eq!(found, Some((kind, n)), "{wanted} is spelled twice");
            assert!(effect.simulator.law().is_none_or(|law| law.parameters() <= effect.parameters.len()));
        }
    }
}

#[test]
fn what_the_reduced_model_admits_has_a_meaning_and_comes_back() {
    for effect in &LIBRARY {
        for parameter in effect.parameters {
            for coordinate in [parameter.range.0, parameter.neutral, parameter.range.1] {
                let value = parameter.to_value(coordinate, &STATED);
                assert_eq!(parameter.check(value), Ok(()), "{} at {coordinate}", parameter.spelling);
                let back = parameter.to_coordinate(value, &STATED);
                assert!((back - coordinate).abs() < 1e-12, "{}: {back} for {coordinate}", parameter.spelling);
            }
        }
    }
}

#[test]
fn viscosity_and_fill_are_what_a_person_measures() {
    let active = |kind: EffectKind, value: f64| kind.effect().active(&[Some(value), None], &STATED);
    let thinner = active(EffectKind::Viscosity, 0.76).expect("in range");
    assert!((thinner.values[0] - 0.8).abs() < 1e-12 && thinner.values[1] == 0.0, "{:?}", thinner.values);
    let higher = active(EffectKind::Fill, 0.072).expect("in range");
    assert!((higher.values[0] - 0.002).abs() < 1e-12, "{:?}", higher.values);
    assert!((higher.stated_values(&STATED)[0].expect("it has one") - 0.072).abs() < 1e-15);
    // The excess of old command lines has no meaning as a height.
    let refusal = format!("{}", active(EffectKind::Fill, 0.002).expect_err("is no height"));
    assert!(refusal.contains("fill = 0.002 m is out of range: 0.005 to 0.3 m (height"), "{refusal}");
    // 9 Pa s is a viscosity, but not one that is a perturbation of this liquid.
    let refusal = format!("{}", active(EffectKind::Viscosity, 9.0).expect_err("is too much"));
    assert!(refusal.contains("0.19 to 4.75 Pa s^n in the reduced model"), "{refusal}");
    assert!(
        active(EffectKind::WallSlip, f64::INFINITY).is_err() && active(EffectKind::Foam, f64::NAN).is_err()
    );
}

#[test]
fn trials_hide_effects_inside_of_their_range() {
    for effect in &LIBRARY {
        for size in [0.5, 1.0, 2.0] {
            let Some(trial) = effect.trial else { continue };
            let (coordinate, (least, largest)) = (trial(size), effect.parameters[0].range);
            assert!((least..=largest).contains(&coordinate), "{} {coordinate}", effect.name);
            assert!(coordinate != effect.parameters[0].neutral, "{}", effect.name);
        }
        assert!(effect.twin.is_none_or(|twin| twin.effect().twin == Some(effect.kind)), "{}", effect.name);
    }
}
