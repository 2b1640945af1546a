//! Discovery on made-up recordings (the reduced model with noise, seconds), on folders with faults, through
//! the command, and on measured water where its data are there. `meniscus discover study` holds it against
//! another simulator.
#![cfg(feature = "offline")]
#![allow(clippy::disallowed_methods, reason = "only storey 1 must compute the same bits on every platform")]

use meniscus::effects::{Active, Class, LIBRARY, find};
use meniscus::host::bag::profiles_to_csv;
use meniscus::offline::discover::calibrate::{Calibration, Group};
use meniscus::offline::discover::load::load;
use meniscus::offline::discover::predict::Known;
use meniscus::offline::discover::record::{Record, mean_bow};
use meniscus::offline::discover::study::courses::Course;
use meniscus::offline::discover::study::made_up_with;
use meniscus::offline::discover::study::measured::ask_measured;
use meniscus::offline::discover::verdict::{Decision, Thresholds};
use meniscus::offline::discover::workflow::{Discovery, Settings, discover};
use meniscus::surface::{POINTS, SurfaceProfile, profile_abscissa};
use meniscus::units::Micros;
use std::path::{Path, PathBuf};

const KNOWN: Known =
    Known { radius_m: 0.035, fill_m: 0.07, density_kg_m3: 1261.0, viscosity_pa_s: 0.2, told: [1.0; 2] };
const NOISE_M: f64 = 1e-4;

/// Four recordings of jolts of 2.2 s; the third strongest is sealed by the workflow.
fn glass(known: &Known, effects: &[(&str, f64)], seed: u64) -> Vec<Record> {
    let theta = Calibration::blind(&[], 0.0).mean;
    let active: Vec<Active> = effects
        .iter()
        .map(|(name, value)| {
            let entry = find(name).expect("in the library");
            let mut values = entry.neutral();
            values[0] = *value;
            Active { entry, values }
        })
        .collect();
    let strengths = [0.6, 1.25, 2.2, 1.7];
    strengths
        .iter()
        .zip(["a", "b", "c", "d"])
        .enumerate()
        .map(|(i, (strength, name))| {
            let course = Course::jolt(0.28, *strength, 2.2);
            made_up_with(name, known, &course, &theta, &active, NOISE_M, 100 * seed + i as u64)
                .expect("a motion")
        })
        .collect()
}

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
    let limits = Thresholds { gain: 15.0, chi2: 1.3 };
    let found =
        discover(&glass(&KNOWN, effects, seed), KNOWN, &groups, limits, settings).expect("it is judged");
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
        assert_eq!(found.sealed.as_deref(), Some("d"));
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
    // Of the pitch nothing is said at all: no other effect bends the surface, and the bow alone is too few
    // numbers for the misfit to show. That a damping is missing is said.
    assert_ne!(lacking("yield_stress", 2.0).decision, Decision::None);
}

/// A folder that is gone when the test ends.
struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("meniscus-discover-{}-{name}", std::process::id()));
        std::fs::create_dir_all(&path).expect("a folder");
        Self(path)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // What a failed test did not make cannot be removed.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Writes `records` as a stranger would.
fn write(folder: &Path, records: &[Record], viscosity: f64) {
    std::fs::create_dir_all(folder).expect("a folder");
    let setup =
        format!("radius_m = 0.035\nfill_m = 0.07\ndensity_kg_m3 = 1261.0\nviscosity_pa_s = {viscosity}\n");
    std::fs::write(folder.join("setup.toml"), setup).expect("written");
    for (record, strength) in records.iter().zip([0.6, 1.25, 2.2, 1.7]) {
        let at = |c: usize, f: usize| record.channels[c].value[f].expect("seen");
        let profile = |f: usize| {
            let height = |i: usize| {
                let s = profile_abscissa(i);
                0.07 + at(0, f) + at(1, f) * s + at(2, f) * (2.0 * s * s - 1.0 - mean_bow())
            };
            SurfaceProfile {
                height_m: std::array::from_fn(|i| height(i) as f32),
                variance_m2: [1e-8; POINTS],
                valid: [true; POINTS],
                glass_x_m: Some(at(3, f) as f32),
                sequence: f as u32,
                captured: Micros(1_000_000 + (f as f64 / 60.0 * 1e6).round() as u64),
            }
        };
        let profiles: Vec<_> = (0..record.frames()).map(profile).collect();
        std::fs::write(folder.join(format!("{}.profile.csv", record.name)), profiles_to_csv(&profiles))
            .expect("written");
        let motion = Course::jolt(0.28, strength, 2.2).csv();
        std::fs::write(folder.join(format!("{}.motion.csv", record.name)), motion).expect("written");
    }
}

#[test]
fn the_command_leaves_a_verdict_a_page_and_a_scene_that_the_simulator_reads() {
    let scratch = Scratch::new("command");
    write(&scratch.path("mine"), &glass(&KNOWN, &[("yield_stress", 2.0)], 9), 0.2);
    for (i, mu) in [0.17, 0.2, 0.235].into_iter().enumerate() {
        let known = Known { viscosity_pa_s: mu, ..KNOWN };
        write(&scratch.path("known").join(format!("{i}")), &glass(&known, &[], 20 + i as u64), mu);
    }
    let path = |name: &str| scratch.path(name).to_string_lossy().into_owned();
    let done = std::process::Command::new(env!("CARGO_BIN_EXE_meniscus"))
        .args([
            "discover",
            "--recordings",
            &path("mine"),
            "--reference",
            &path("known"),
            "--out",
            &path("out"),
            "--json",
        ])
        .output()
        .expect("the command starts");
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let said: serde_json::Value = serde_json::from_slice(&done.stdout).expect("one JSON object");
    println!("{}", said["sentence"]);
    assert_eq!((said["verdict"].as_str(), said["names"][0].as_str()), (Some("named"), Some("yield_stress")));
    let page = std::fs::read_to_string(scratch.path("out/report.html")).expect("a page");
    assert!(page.contains("<svg") && page.contains("yield_stress") && !page.contains("http"));
    let scene =
        meniscus::offline::experiment::Experiment::load(&scratch.path("out/scene.toml")).expect("a scene");
    assert!(scene.effects.yield_stress.is_some_and(|pa| (pa - 2.0).abs() < 0.3), "{:?}", scene.effects);
}

#[test]
fn bad_folders_are_refused_with_what_is_wrong_and_the_rest_is_kept() {
    let scratch = Scratch::new("bad");
    let refusal = |why: &str| {
        let said = load(&scratch.0).map(|folder| folder.left_out.join("; ")).unwrap_or_else(|why| why);
        assert!(said.contains(why), "'{why}' is not in: {said}");
    };
    refusal("setup.toml");
    let records = glass(&KNOWN, &[], 30);
    write(&scratch.0, &records, -1.0);
    refusal("viscosity_pa_s = -1 is out of range");
    write(&scratch.0, &records, 0.2);
    assert_eq!(load(&scratch.0).expect("a folder").records.len(), 4);
    // A motion that ends while the glass moves.
    let motion: String =
        Course::jolt(0.28, 0.6, 2.2).csv().lines().take(150).map(|line| format!("{line}\n")).collect();
    std::fs::write(scratch.path("a.motion.csv"), motion).expect("written");
    refusal("a: the motion ends at 0.59 s while the glass moves");
    // A glass that moves from the first frame.
    let early: String = (0..600)
        .map(|n| (0.004 * f64::from(n), (0.08 * f64::from(n)).sin()))
        .map(|(t, x)| format!("{t},{}\n", 0.01 * x))
        .collect();
    std::fs::write(scratch.path("b.motion.csv"), early).expect("written");
    refusal("b: the glass rests for only 0 frames");
    let text = std::fs::read_to_string(scratch.path("c.profile.csv")).expect("read");
    std::fs::write(scratch.path("c.profile.csv"), text.replacen(",0.07", ",nan", 1)).expect("written");
    refusal("c.profile.csv: line 2");
    assert_eq!(load(&scratch.0).expect("one is left").records.len(), 1);
    // Constant heights.
    let flat: String = (0..100).map(|n| format!("{:.4},1.5\n", f64::from(n) / 60.0)).collect();
    std::fs::write(scratch.path("e.peak.csv"), flat).expect("written");
    std::fs::write(scratch.path("e.motion.csv"), Course::jolt(0.28, 0.6, 2.2).csv()).expect("written");
    refusal("e: the peak never changes");
    let few = discover(&records[..1], KNOWN, &[], Thresholds::default(), &Settings::default());
    assert!(few.expect_err("one shake").contains("1 recording is too few"));
}

#[test]
fn the_inclination_of_measured_water_is_found() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/antisloshing");
    if !folder.join("heights").is_dir() {
        println!("skipped: {} is not there", folder.display());
        return;
    }
    let asked = ask_measured(&folder, &Settings::default(), 14.0, 1).expect("it is judged");
    let [before, after] = asked[0].means_mm();
    println!(
        "{}: {} {before:.2} mm before, {after:.2} mm after",
        asked[0].title,
        asked[0].discovery.verdict.sentence()
    );
    assert!(asked[0].discovery.verdict.names.contains(&"container_tilt"));
    assert!(after < 0.75 * before, "{before} mm before, {after} mm after");
}
