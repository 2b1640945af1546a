//! Spelling of effects: names, ranges, refusals, and what the simulator gets.

use super::*;

#[test]
fn every_parameter_has_a_value_of_its_own() {
    for kind in EffectKind::ALL {
        let mut effects = Effects::default();
        for (n, parameter) in kind.effect().parameters.iter().enumerate() {
            effects.set(parameter.spelling, parameter.admissible.0).expect("the least value is allowed");
            assert_eq!(effects.on().len(), n + 1, "{}", parameter.spelling);
            assert_eq!(effects.values(kind)[n], Some(parameter.admissible.0));
        }
        assert_eq!(Effects::default().over(effects), effects);
    }
}

#[test]
fn wrong_effects_are_refused_with_name_value_unit_and_range() {
    let refusal = |text: &str| format!("{}", Effects::default().parse(text).expect_err(text));
    assert!(refusal("viscosity=-1").contains("viscosity = -1 Pa s^n is out of range: 0 to 100"));
    assert!(refusal("surface_tension=nan").contains("NaN"));
    assert!(refusal("colour=3").contains("no effect is called 'colour': take one of viscosity"));
    assert!(refusal("colour=3,4").contains("no effect is called 'colour': take one of viscosity"));
    assert!(refusal("foam").contains("NAME=VALUE") && refusal("foam=much").contains("NAME=VALUE"));
    assert!(refusal("foam=1,2").contains("foam has 1 parameter(s), and 2 values are given"));
}

#[test]
fn one_parameter_and_both_are_spelled() {
    let parsed = |texts: &[&str]| {
        let mut effects = Effects::default();
        texts.iter().for_each(|text| effects.parse(text).expect("a known effect"));
        effects
    };
    let both = parsed(&["contact_line=0.02,0.0005"]);
    assert_eq!(both, parsed(&["contact_line=0.02", "contact_line_reach=0.0005"]));
    assert_eq!(format!("{both:?}"), "[(\"contact_line\", 0.02), (\"contact_line_reach\", 0.0005)]");
}

#[test]
fn a_contact_line_has_one_law() {
    let mut effects = Effects::default().with(EffectKind::PinnedLine, 10.0);
    let refused = effects.set("contact_line_reach", 1e-3).expect_err("it is pinned");
    assert_eq!(refused, EffectError::TwoLines(["pinned_line", "contact_line"]));
    let liquid = Effects::default().with(EffectKind::ContactLine, 0.01).with(EffectKind::Foam, 0.2);
    assert_eq!(effects.over(liquid), effects.with(EffectKind::Foam, 0.2));
}

#[test]
fn what_the_simulator_lacks_is_refused_with_the_reason() {
    let refusal = |text: &str| {
        let mut effects = Effects::default();
        effects.parse(text).expect("a known effect");
        effects.require_simulated().map_err(|error| format!("{error}"))
    };
    assert_eq!(refusal("yield_stress=3"), Ok(()));
    assert_eq!(refusal("pinned_line=10"), Ok(()));
    let camera = refusal("camera_pitch=0.03").expect_err("no liquid is pitched");
    assert!(camera.contains("camera_pitch is not simulated: it changes what the camera shows"), "{camera}");
    let share = refusal("container_tilt=0.1,0.5").expect_err("no share is simulated");
    assert!(share.contains("container_tilt_share is not simulated"), "{share}");
}

#[test]
fn the_simulator_gets_what_the_reduced_model_means() {
    let stated = Stated { consistency_pa_sn: 0.95, radius_m: 0.035, fill_m: 0.07 };
    let mut effects = Effects::default();
    effects.parse("viscosity=0.76").expect("a viscosity");
    effects.parse("fill=0.072").expect("a height");
    effects.parse("contact_line=0.02").expect("a line");
    let active = effects.active(&stated).expect("the reduced model admits them");
    let mut back = Effects::default();
    active.iter().for_each(|active| back.set_simulated(active, &stated).expect("it is carried"));
    for ((parameter, value), (_, wanted)) in back.on().into_iter().zip([
        ("viscosity", 0.76),
        ("contact_line", 0.02),
        ("contact_line_reach", 5e-4),
        ("fill", 0.072),
    ]) {
        assert!((value - wanted).abs() < 1e-15, "{} {value}", parameter.spelling);
    }
    assert_eq!(back.on().len(), 4);
}
