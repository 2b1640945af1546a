//! Discovery on made-up recordings (the reduced model with noise, seconds) and on measured water
//! (`fixtures/antisloshing`). `meniscus discover study` holds it against another simulator.

#[path = "support/shaken.rs"]
mod shaken;

use meniscus::blob::Model;
use meniscus::reduced::effects::{Class, LIBRARY, find};
use meniscus_discover::baseline::calibrate::Calibration;
use meniscus_discover::baseline::group::Group;
use meniscus_discover::baseline::predict::NAMES;
use meniscus_discover::decision::settings::Settings;
use meniscus_discover::decision::thresholds::{Thresholds, thresholds};
use meniscus_discover::decision::verdict::Verdict;
use meniscus_discover::findings::Findings;
use meniscus_discover::fitting::fit::{fit, fit_beside};
use meniscus_discover::fitting::problem::Problem;
use meniscus_discover::fitting::search::search;
use meniscus_discover::insert::simulated::Resolution;
use meniscus_discover::recordings::load::RecordingSet;
use meniscus_discover::recordings::split::Split;
use meniscus_discover::recordings::stated::{CALLIPERS_M, Known};
use meniscus_discover::report::html::page;
use meniscus_discover::study::measured::judge_measured;
use meniscus_discover::workflow::inputs::Inputs;
use meniscus_discover::workflow::progress::{Silent, Stage};
use meniscus_discover::workflow::{Discovery, discover};
use meniscus_platform::files::AlignedBytes;
use shaken::{KNOWN, glass};
use std::cell::RefCell;
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

fn found(effects: &[(&str, f64)], seed: u64, settings: &Settings) -> Findings {
    let groups = references();
    let groups: Vec<&Group> = groups.iter().collect();
    let limits = Thresholds { gain: 15.0, chi2: 1.3, ..Thresholds::default() };
    let found =
        discover(&glass(&KNOWN, effects, seed), KNOWN, &groups, &limits, settings).expect("it is judged");
    println!("{effects:?}: {}", found.assessment.verdict.sentence());
    found
}

#[test]
fn nothing_hidden_is_none() {
    for seed in 1..4 {
        let verdict = found(&[], seed, &Settings::default()).assessment.verdict;
        assert!(matches!(verdict, Verdict::None { .. }), "{}", verdict.sentence());
    }
}

#[test]
fn what_is_hidden_is_named_and_its_interval_holds_it() {
    for (name, value) in [("yield_stress", 2.0), ("camera_pitch", 0.035), ("actuation_gain", 1.08)] {
        let found = found(&[(name, value)], 5, &Settings::default());
        let verdict = &found.assessment.verdict;
        assert!(matches!(verdict, Verdict::Identified(_)), "{name}: {}", verdict.sentence());
        assert_eq!(verdict.names(), [name]);
        let estimate = &found.estimates[0];
        let gap = found.gap.as_ref().expect("four recordings, one held out").gap;
        println!("{estimate:?}, gap {gap:?}");
        assert!(found.rivals.is_empty(), "a named verdict has no rivals: {:?}", found.rivals);
        assert!((estimate.value - value).abs() < 0.15 * value.abs().min(1.0), "{estimate:?}");
        assert!(gap.effect < 0.5 * gap.untouched, "{gap:?}");
        assert_eq!(found.split.held_out.as_ref().map(|record| record.name.as_str()), Some("d"));
    }
}

#[test]
fn twins_are_tied_within_their_class_and_two_effects_are_both_found() {
    let found_late = found(&[("camera_latency", 0.033)], 6, &Settings::default());
    let late = &found_late.assessment.verdict;
    assert!(matches!(late, Verdict::Ambiguous(_)), "{}", late.sentence());
    assert_eq!(late.class(), Some(Class::Timing));
    assert!(late.names().contains(&"camera_latency") && late.names().contains(&"actuation_delay"));
    // Whichever of them was chosen, both have a size, and an interval around the hidden one.
    let sizes = found_late.estimates.iter().chain(&found_late.rivals);
    let sizes: Vec<_> = sizes.filter(|size| late.names().contains(&size.effect)).collect();
    assert_eq!(sizes.len(), late.names().len(), "{sizes:?}");
    assert!(sizes.iter().all(|size| (size.interval.0..=size.interval.1).contains(&0.033)), "{sizes:?}");
    // Not asserted, because it does not hold: beside a yield stress a camera pitch of 0.035 is lost, because a
    // fifth of the larger correction is not held against the library.
    let two =
        found(&[("yield_stress", 2.0), ("actuation_gain", 1.08)], 7, &Settings::default()).assessment.verdict;
    let names = two.names();
    assert!(names.contains(&"yield_stress") && names.contains(&"actuation_gain"), "{names:?}");
}

#[test]
fn a_truth_that_the_library_lacks_is_no_name_of_another_class() {
    let lacking = |name: &str, value: f64| {
        let library = LIBRARY.iter().filter(|entry| entry.name != name).collect();
        found(&[(name, value)], 8, &Settings { library, ..Settings::default() }).assessment.verdict
    };
    for (name, value, class) in
        [("camera_pitch", 0.06, Class::View), ("yield_stress", 2.0, Class::AmplitudeDamping)]
    {
        let verdict = lacking(name, value);
        let other = matches!(verdict, Verdict::Identified(_)) && verdict.class() != Some(class);
        assert!(!other, "{name}: {}", verdict.sentence());
    }
    assert!(!matches!(lacking("yield_stress", 2.0), Verdict::None { .. }));
    // A gain and a fill do together what a scale of every length does: they are no name.
    for (name, value, others) in
        [("depth_scale", 1.05, ["actuation_gain", "fill"]), ("actuation_gain", 1.08, ["depth_scale", "fill"])]
    {
        let verdict = lacking(name, value);
        assert!(matches!(verdict, Verdict::Unknown(_)), "{name}: {}", verdict.sentence());
        assert!(verdict.names().iter().all(|said| others.contains(said)), "{:?}", verdict.names());
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
            .assessment
            .verdict
    };
    let plain = judged(&[]);
    assert!(matches!(plain, Verdict::None { .. }), "{}", plain.sentence());
    let bent = judged(&[("camera_pitch", 0.06)]);
    assert!(matches!(bent, Verdict::Unknown(_)), "{}", bent.sentence());
    let offset = bent.rest_offset().expect("it is said where");
    assert!(offset.m.abs() > 1e-5, "{offset:?}");
    assert!(bent.sentence().contains("At rest the"), "{}", bent.sentence());
}

#[test]
fn what_was_significant_before_a_formula_was_distrusted_is_never_called_nothing_after() {
    let groups = references();
    let groups: Vec<&Group> = groups.iter().collect();
    let settings = Settings::default();
    let records = glass(&KNOWN, &[("yield_stress", 2.0)], 5);
    let split = Split::of(&records);
    let calibration = Calibration::from(&groups, &KNOWN, &split.fitted, None);
    let problem = Problem::new(&split.fitted, KNOWN, &calibration, 1.0).expect("it is fitted");
    let plain = fit(&problem, &problem.mean, &[], &[]);
    let entry = find("yield_stress").expect("in the library");
    let (_, from, _) = search(&problem, &plain, entry);
    let before = plain.cost - fit_beside(&problem, &plain, entry, &from).cost;
    let free = Thresholds { gain: 15.0, chi2: 1.3, ..Thresholds::default() };
    let judged = |limits: &Thresholds| {
        discover(&records, KNOWN, &groups, limits, &settings).expect("it is judged").assessment
    };
    let after = judged(&free).search.ranking.iter().find(|c| c.last() == entry.name).map(|c| c.fall);
    let after = after.expect("it is ranked");
    println!("the cost falls by {before:.0} before the formula is distrusted, by {after:.0} after");
    assert!(after < 0.8 * before);
    // Every bound lies between the two falls: it was learnt under the first covariance and judges the fit under it.
    let bound = LIBRARY.iter().map(|effect| (effect.name, 0.5 * (before + after))).collect();
    let verdict = judged(&Thresholds { bound, ..free }).verdict;
    assert!(matches!(verdict, Verdict::Identified(_)), "{}", verdict.sentence());
    assert_eq!(verdict.names(), ["yield_stress"]);
}

#[test]
fn nothing_is_missing_only_where_the_map_agrees() {
    // No effect of this library acts while the liquid moves; of the mean square nothing is asked.
    let library = vec![find("camera_pitch").expect("in the library")];
    let settings = Settings { library, ..Settings::default() };
    let groups: Vec<Group> =
        (0..6).map(|i| Group::new(KNOWN, glass(&KNOWN, &[], 70 + i), None).expect("it is fitted")).collect();
    let groups: Vec<&Group> = groups.iter().collect();
    let mut limits = thresholds(&groups, &settings).expect("they are judged");
    limits.clean_chi2 = f64::INFINITY;
    let judged = |effects: &[(&str, f64)]| {
        discover(&glass(&KNOWN, effects, 80), KNOWN, &groups, &limits, &settings)
            .expect("it is judged")
            .assessment
            .verdict
    };
    let plain = judged(&[]);
    assert!(matches!(plain, Verdict::None { .. }), "{}", plain.sentence());
    let hidden = judged(&[("yield_stress", 2.0)]);
    assert!(matches!(hidden, Verdict::Unknown(_)), "{}", hidden.sentence());
    let cell = hidden.cell().expect("it is said where");
    assert!(cell.misfit > limits.cell && hidden.sentence().contains(cell.window), "{}", hidden.sentence());
}

#[test]
fn a_leaning_glass_and_a_rolled_camera_are_distinguished_by_the_waves() {
    for name in ["container_tilt", "camera_slope"] {
        let verdict = found(&[(name, 0.05)], 11, &Settings::default()).assessment.verdict;
        assert!(matches!(verdict, Verdict::Identified(_)), "{}", verdict.sentence());
        assert_eq!(verdict.names(), [name]);
    }
}

#[test]
fn what_a_viscosity_explains_of_the_references_is_no_scatter() {
    // The damping grows faster with the viscosity than the model says: by a line in ln mu that is no scatter.
    let groups: Vec<Group> = [0.15, 0.15, 0.2, 0.2, 0.27, 0.27]
        .into_iter()
        .zip(110..)
        .map(|(mu, seed)| {
            let made = Known { viscosity_pa_s: 0.2 * f64::powf(mu / 0.2, 1.5), ..KNOWN };
            let stated = Known { viscosity_pa_s: mu, ..KNOWN };
            Group::new(stated, glass(&made, &[], seed), None).expect("it is fitted")
        })
        .collect();
    let groups: Vec<&Group> = groups.iter().collect();
    let damping = NAMES.iter().position(|name| *name == "damping 1").expect("a number of the baseline");
    let at = |viscosity_pa_s: f64| {
        let known = Known { viscosity_pa_s, ..KNOWN };
        let calibration = Calibration::from(&groups, &known, &[], None);
        (calibration.mean[damping], calibration.deviation[damping])
    };
    let [(low, _), (middle, deviation), (high, _)] = [0.15, 0.2, 0.27].map(at);
    println!("damping {low:.3}, {middle:.3}, {high:.3}, deviation {deviation:.3}");
    // gamma grows as mu^0.65: a half more of ln(0.27/0.15) makes 0.19.
    assert!((high - low - 0.19).abs() < 0.05, "{low} {high}");
    assert!(deviation < 0.04, "{deviation}: as scatter it is 0.09");
}

#[test]
fn a_radius_that_is_wrong_is_found_unless_the_survey_allows_it() {
    let groups: Vec<Group> =
        (0..4).map(|i| Group::new(KNOWN, glass(&KNOWN, &[], 90 + i), None).expect("it is fitted")).collect();
    let groups: Vec<&Group> = groups.iter().collect();
    let records = glass(&KNOWN, &[("radius", 0.002)], 95);
    let limits = Thresholds { gain: 15.0, chi2: 1.3, ..Thresholds::default() };
    let judged = |radius_error_m: f64| {
        let known = Known { radius_error_m, ..KNOWN };
        discover(&records, known, &groups, &limits, &Settings::default()).expect("it is judged")
    };
    let found = judged(CALLIPERS_M);
    assert!(found.assessment.verdict.names().contains(&"radius"), "{}", found.assessment.verdict.sentence());
    let estimate = found.estimates.iter().find(|e| e.effect == "radius").expect("it leads");
    println!("{estimate:?}");
    assert!((estimate.value - 0.037).abs() < 3e-4, "{estimate:?}");
    // Stated to 2 mm, the same glass is as stated.
    let allowed = judged(0.002).assessment.verdict;
    assert!(matches!(allowed, Verdict::None { .. }), "{}", allowed.sentence());
}

#[test]
fn an_effect_at_the_end_of_its_range_is_no_name() {
    let library = vec![find("actuation_gain").expect("in the library")];
    let verdict =
        found(&[("actuation_gain", 2.0)], 9, &Settings { library, ..Settings::default() }).assessment.verdict;
    assert!(matches!(verdict, Verdict::Ambiguous(_) | Verdict::Unknown(_)), "{}", verdict.sentence());
    let said = verdict.sentence();
    assert!(
        said.contains("the factor of actuation_gain stands at the end of its range of 0.5 to 1.5"),
        "{said}"
    );
}

#[test]
fn the_whole_workflow_is_one_call_that_reports_its_stages() {
    let set = |known: Known, effects: &[(&str, f64)], seed: u64| RecordingSet {
        known,
        own_clocks: false,
        records: glass(&known, effects, seed),
        left_out: Vec::new(),
    };
    let mut inputs = Inputs::new(set(KNOWN, &[("yield_stress", 2.0)], 9));
    inputs.settings.library =
        ["yield_stress", "viscosity", "camera_pitch"].iter().filter_map(|n| find(n)).collect();
    let references = [0.17, 0.2, 0.235].into_iter().zip(20..);
    inputs.references =
        references.map(|(mu, seed)| set(Known { viscosity_pa_s: mu, ..KNOWN }, &[], seed)).collect();
    inputs.model = Some(AlignedBytes::copy(meniscus_shipped::MODEL));
    let stages = RefCell::new(Vec::new());
    let report = Discovery::run(&inputs, &|stage| stages.borrow_mut().push(stage)).expect("it is judged");
    let wanted = [Stage::FitReferences, Stage::SetThresholds, Stage::Decide, Stage::InsertIntoModel];
    assert_eq!(*stages.borrow(), wanted);
    let verdict = &report.findings.assessment.verdict;
    assert!(matches!(verdict, Verdict::Identified(_)), "{}", verdict.sentence());
    let blob = AlignedBytes::copy(report.insertion.blob.as_deref().expect("a model with the effect"));
    let model = Model::load(&blob).expect("a sound blob");
    assert_eq!(model.header.embedded.expect("it names the effect").effects[0].name, "yield_stress");
    let [closed] = report.insertion.closed.as_slice() else { panic!("one model: {:?}", report.insertion) };
    assert!(closed.untouched_m.is_finite() && closed.effect_m != closed.untouched_m, "{closed:?}");
    // The page draws what is left of the held-out recording, and the sizes with their intervals.
    let page = page(&report, "meniscus discover").expect("a page");
    for part in ["Residual: measured less predicted.", "Grey: 90 % interval.", "Seen, and not distinguished:"]
    {
        assert!(page.contains(part), "the page lacks '{part}'");
    }
    // A spacing that does not fit the glass is refused before anything is fitted.
    inputs.simulation = Some(Resolution { spacing_m: 0.02, seed: 1 });
    let refused = Discovery::run(&inputs, &Silent).expect_err("20 mm in a glass of 35 mm").to_string();
    assert!(refused.contains("a particle spacing of 20 mm is out of range"), "{refused}");
}

#[test]
fn the_inclination_of_measured_water_is_found() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/antisloshing");
    let cases = judge_measured(&folder, &Settings::default(), 14.0, 1).expect("it is judged");
    let [before, after] = cases[0].result.means_mm();
    println!(
        "{}: {} {before:.2} mm before, {after:.2} mm after",
        cases[0].result.title,
        cases[0].findings.assessment.verdict.sentence()
    );
    assert!(cases[0].findings.assessment.verdict.names().contains(&"container_tilt"));
    // Its thresholds are learnt from its references, as the program learns them.
    let limits = &cases[0].findings.limits;
    assert!(limits.references == 3 && limits.chi2.is_finite() && limits.cell.is_finite(), "{limits:?}");
    assert!(limits.of("container_tilt") > 0.0, "{limits:?}");
    assert!(after < 0.75 * before, "{before} mm before, {after} mm after");
}
