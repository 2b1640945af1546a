//! Discovery on made-up recordings (the reduced model with noise, seconds) and on measured water where its data
//! are there. `meniscus discover study` holds it against another simulator.
#![allow(clippy::disallowed_methods, reason = "only storey 1 must compute the same bits on every platform")]

#[path = "support/shaken.rs"]
mod shaken;

use meniscus::reduced::effects::{Class, LIBRARY, find};
use meniscus_discover::calibrate::Group;
use meniscus_discover::predict::Known;
use meniscus_discover::settings::Settings;
use meniscus_discover::study::measured::ask_measured;
use meniscus_discover::thresholds::{Thresholds, thresholds};
use meniscus_discover::verdict::Decision;
use meniscus_discover::workflow::{Discovery, discover};
use shaken::{KNOWN, glass};
use std::path::Path;

fn references() -> Vec<Group> {
    [0.17, 0.2, 0.235]
        .iter()
        .enumerate()
        .map(|(i, mu)| {
            let known = Known { viscosity_pa_s: *mu, ..KNOWN };
            Group::new(known, glass(&known, &[], 10 + i as u64), None).expect("it is fitted")
        })
        .collect()
}

fn found(effects: &[(&str, f64)], seed: u64, settings: &Settings) -> Discovery {
    let groups = references();
    let groups: Vec<&Group> = groups.iter().collect();
    let limits = Thresholds { gain: 15.0, chi2: 1.3, ..Thresholds::default() };
    let found =
        discover(&glass(&KNOWN, effects, seed), KNOWN, &groups, &limits, settings).expect("it is judged");
    println!("{effects:?}: {}", found.verdict.sentence());
    found
}

#[test]
fn nothing_hidden_is_none() {
    for seed in 1..4 {
        let verdict = found(&[], seed, &Settings::default()).verdict;
        assert_eq!(verdict.decision, Decision::None, "{:?}", verdict.names);
    }
}

#[test]
fn what_is_hidden_is_named_and_its_interval_holds_it() {
    for (name, value) in [("yield_stress", 2.0), ("camera_pitch", 0.035), ("actuation_gain", 1.08)] {
        let found = found(&[(name, value)], 5, &Settings::default());
        assert_eq!(found.verdict.decision, Decision::Named, "{name}: {}", found.verdict.sentence());
        assert_eq!(found.verdict.names, [name]);
        let estimate = &found.estimates[0];
        println!("{estimate:?}, gap {:?}", found.gap);
        assert!((estimate.value - value).abs() < 0.15 * value.abs().min(1.0), "{estimate:?}");
        let gap = found.gap.expect("four recordings, one sealed");
        assert!(gap.effect < 0.4 * gap.untouched, "{gap:?}");
        assert_eq!(found.split.held_out.as_ref().map(|record| record.name.as_str()), Some("d"));
    }
}

#[test]
fn twins_are_tied_within_their_class_and_two_effects_are_both_found() {
    let late = found(&[("camera_latency", 0.033)], 6, &Settings::default()).verdict;
    assert_eq!((late.decision, late.class), (Decision::Tied, Some(Class::Timing)));
    assert!(late.names.contains(&"camera_latency") && late.names.contains(&"actuation_delay"));
    // Not asserted, because it does not hold: beside a yield stress a camera pitch of 0.035 is lost, because a
    // fifth of the larger correction is not held against the library.
    let two = found(&[("yield_stress", 2.0), ("actuation_gain", 1.08)], 7, &Settings::default()).verdict;
    assert!(two.names.contains(&"yield_stress") && two.names.contains(&"actuation_gain"), "{:?}", two.names);
}

#[test]
fn a_truth_that_the_library_lacks_is_no_name_of_another_class() {
    let lacking = |name: &str, value: f64| {
        let library = LIBRARY.iter().filter(|entry| entry.name != name).collect();
        found(&[(name, value)], 8, &Settings { library, ..Settings::default() }).verdict
    };
    for (name, value, class) in
        [("camera_pitch", 0.06, Class::View), ("yield_stress", 2.0, Class::AmplitudeDamping)]
    {
        let verdict = lacking(name, value);
        let other = verdict.decision == Decision::Named && verdict.class != Some(class);
        assert!(!other, "{name}: {}", verdict.sentence());
    }
    assert_ne!(lacking("yield_stress", 2.0).decision, Decision::None);
    // A gain and a fill do together what a scale of every length does: they are no name.
    for (name, value, others) in
        [("depth_scale", 1.05, ["actuation_gain", "fill"]), ("actuation_gain", 1.08, ["depth_scale", "fill"])]
    {
        let verdict = lacking(name, value);
        assert_eq!(verdict.decision, Decision::Unknown, "{name}: {}", verdict.sentence());
        assert!(verdict.names.iter().all(|said| others.contains(said)), "{:?}", verdict.names);
    }
}

#[test]
fn what_stands_off_at_rest_is_not_called_nothing() {
    // No effect of this library bends the surface at rest; of 1600 numbers too few are off for a mean square.
    let library: Vec<_> = ["viscosity", "wall_slip", "foam"].iter().filter_map(|name| find(name)).collect();
    let settings = Settings { library, ..Settings::default() };
    let groups: Vec<Group> =
        (0..6).map(|i| Group::new(KNOWN, glass(&KNOWN, &[], 40 + i), None).expect("it is fitted")).collect();
    let groups: Vec<&Group> = groups.iter().collect();
    let limits = thresholds(&groups, &settings).expect("they are judged");
    let judged = |effects: &[(&str, f64)]| {
        discover(&glass(&KNOWN, effects, 60), KNOWN, &groups, &limits, &settings)
            .expect("it is judged")
            .verdict
    };
    let plain = judged(&[]);
    assert_eq!(plain.decision, Decision::None, "{}", plain.sentence());
    let bent = judged(&[("camera_pitch", 0.06)]);
    assert_eq!(bent.decision, Decision::Unknown, "{}", bent.sentence());
    let (quantity, m) = bent.stands_off.expect("it is said where");
    assert!(m.abs() > 1e-5, "{quantity:?} {m}");
    assert!(bent.sentence().contains("At rest the"), "{}", bent.sentence());
}

#[test]
fn a_leaning_glass_and_a_rolled_camera_are_told_apart_by_the_waves() {
    for name in ["container_tilt", "camera_slope"] {
        let verdict = found(&[(name, 0.05)], 11, &Settings::default()).verdict;
        assert_eq!((verdict.decision, verdict.names), (Decision::Named, vec![name]));
    }
}

#[test]
fn an_effect_at_the_end_of_its_range_is_no_name() {
    let library = vec![find("actuation_gain").expect("in the library")];
    let verdict = found(&[("actuation_gain", 2.0)], 9, &Settings { library, ..Settings::default() }).verdict;
    assert!(matches!(verdict.decision, Decision::Tied | Decision::Unknown), "{}", verdict.sentence());
    let said = verdict.sentence();
    assert!(
        said.contains("the factor of actuation_gain stands at the end of its range of 0.5 to 1.5"),
        "{said}"
    );
}

#[test]
fn the_inclination_of_measured_water_is_found() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/antisloshing");
    if !folder.join("heights").is_dir() {
        println!("skipped: {} is not there", folder.display());
        return;
    }
    let asked = ask_measured(&folder, &Settings::default(), 14.0, 1).expect("it is judged");
    let [before, after] = asked[0].told.means_mm();
    println!(
        "{}: {} {before:.2} mm before, {after:.2} mm after",
        asked[0].told.title,
        asked[0].discovery.verdict.sentence()
    );
    assert!(asked[0].discovery.verdict.names.contains(&"container_tilt"));
    assert!(after < 0.75 * before, "{before} mm before, {after} mm after");
}
