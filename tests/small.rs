//! The small variant of the estimator beside the full one: the same recording, the same profiles, and the errors of both against
//! the truth.

use meniscus::blob::{FieldGroup, KnownGroups, Model, Variant};
use meniscus::runtime::{Forecast, InputSource, Mode};
use meniscus_data::recording::Recording;
use meniscus_learn::evaluate::{Trial, trial};
use meniscus_numerics::statistics::median;
use meniscus_platform::files::AlignedBytes;
use meniscus_virtual::observe_recording::{DISPARITY_RMS_PX, perfect, sightings, turns, turns_with};
use meniscus_virtual::render::SceneSettings;
use nalgebra::SymmetricEigen;
use serde_json::Value;
use std::path::Path;
use std::process::Command;

/// The shipped recording, which the shipped model has never seen.
fn shipped() -> Recording {
    Recording::from_bytes(Path::new("shipped"), meniscus_shipped::RECORDING).expect("the recording")
}

/// The shipped model for a variant.
fn model(bytes: &AlignedBytes, variant: Variant) -> Model<'_> {
    let mut model = Model::load(bytes).expect("the shipped model");
    model.header.variant = variant;
    model
}

/// One figure of both variants.
struct Row {
    name: &'static str,
    of: fn(&Trial) -> f64,
    /// Largest size of small less full, in the unit of the figure.
    most: f64,
}

/// Per cent, millimetres and milliseconds.
const ROWS: [Row; 10] = [
    Row { name: "surface, slosh-relative, %", of: |t| 100.0 * t.score.estimate.slosh_rel(), most: 0.002 },
    Row { name: "largest error of a height, %", of: |t| 100.0 * t.score.estimate.max, most: 0.002 },
    Row { name: "coverage of the surface, %", of: |t| 100.0 * t.score.held.share(), most: 0.05 },
    Row { name: "forecast, 250 ms, %", of: |t| 100.0 * t.forecast[0][0], most: 0.01 },
    Row { name: "its coverage, %", of: |t| 100.0 * t.forecast_held[0].share(), most: 0.05 },
    Row { name: "forecast, 250 ms, motion planned, %", of: |t| 100.0 * t.planned.forecast[0], most: 0.002 },
    Row { name: "its coverage, motion planned, %", of: |t| 100.0 * t.planned.held[0].share(), most: 0.05 },
    Row { name: "next crest, height, mm", of: |t| 1e3 * size(&t.planned.crests.height_m), most: 0.001 },
    Row { name: "next crest, time, ms", of: |t| 1e3 * size(&t.planned.crests.time_s), most: 0.001 },
    Row { name: "its coverage, %", of: |t| 100.0 * t.planned.crests.held.share(), most: 0.5 },
];

/// Median of the sizes of errors.
fn size(errors: &[f64]) -> f64 {
    median(errors.iter().map(|error| error.abs())).expect("there are crests")
}

#[test]
fn the_small_variant_errs_as_the_full_one() {
    let (recording, bytes) = (shipped(), AlignedBytes::copy(meniscus_shipped::MODEL));
    let scene =
        SceneSettings { disparity_rms_px: DISPARITY_RMS_PX, seed: 3, ..SceneSettings::of(&recording.glass) };
    let seen = sightings(&recording, scene).expect("the glass can be seen");
    let [full, small] = Variant::ALL.map(|variant| trial(&model(&bytes, variant), &recording, &seen));
    println!("{:38} {:>9} {:>9}", "", "full", "small");
    let mut off = Vec::new();
    for Row { name, of, most } in ROWS {
        let [full, small] = [of(&full), of(&small)];
        println!("{name:38} {full:9.4} {small:9.4}");
        if (small - full).abs() > most {
            off.push(format!("{name}: {small} where the full one has {full}"));
        }
    }
    assert!(off.is_empty(), "{off:?}");
    assert_ne!(full.score.estimate.slosh_rel(), small.score.estimate.slosh_rel(), "two variants, not one");
    assert_eq!((full.score.known, small.score.known), (KnownGroups::ALL, Variant::Small.groups()));
    assert_eq!((small.entropy_falls, small.unknown_shown.len()), (0, 0));
    assert!(small.energy_drift < 1e-9, "{}", small.energy_drift);
}

#[test]
fn latents_and_covariance_stay_beside_those_of_the_full_variant() {
    let (recording, bytes) = (shipped(), AlignedBytes::copy(meniscus_shipped::MODEL));
    let seen = perfect(&recording);
    let of = |variant| {
        let mut states = Vec::new();
        let model = model(&bytes, variant);
        let logged = turns_with(
            &model,
            &seen,
            |_| InputSource::Tracked,
            |_, memory, estimate| {
                states.push((*estimate, Forecast::new(&model, memory, 15, &[])));
            },
        );
        assert!(logged.iter().skip(20).all(|logged| logged.turn.estimate.mode == Mode::Tracking));
        states
    };
    let [full, small] = Variant::ALL.map(of);
    let (mut difference, mut square) = (0.0, 0.0);
    for ((full, ahead), (small, ahead_small)) in full.iter().zip(&small).skip(20) {
        for (a, b) in full.latent.iter().zip(small.latent) {
            difference += (a - b) * (a - b);
            square += a * a;
        }
        let covariance =
            nalgebra::SMatrix::<f64, 13, 13>::from_fn(|i, j| f64::from(small.covariance.at(i, j)));
        let values = SymmetricEigen::new(covariance).eigenvalues;
        assert!(values.min() > -1e-5 * values.max(), "a variance below zero: {values}");
        let widths = ahead.half_width_m.iter().zip(&ahead_small.half_width_m);
        assert!(widths.clone().all(|(a, b)| (b / a - 1.0).abs() < 0.05), "{:?}", widths.collect::<Vec<_>>());
    }
    let relative = (difference / square).sqrt();
    println!("latents of the small variant: {relative:.2e} from the full one's");
    assert!(relative > 0.0 && relative < 1e-4, "{relative}");
}

#[test]
fn what_the_small_variant_leaves_out_counts_as_not_known() {
    let (recording, bytes) = (shipped(), AlignedBytes::copy(meniscus_shipped::MODEL));
    let model = model(&bytes, Variant::Small);
    let logged = turns(&model, &perfect(&recording));
    assert_eq!(meniscus_score::unknown_groups::in_outputs(&model, &recording, &logged), []);
    assert!(logged.iter().all(|logged| !logged.turn.estimate.field_fresh));
    for group in FieldGroup::ALL {
        assert_eq!(model.header.known().contains(group), group == FieldGroup::Surface, "{group:?}");
    }
}

#[test]
fn a_person_chooses_the_variant_and_sees_what_is_missing() {
    let out = Path::new(env!("CARGO_TARGET_TMPDIR")).join("small");
    let run = |variant: &str| {
        let done = Command::new(env!("CARGO_BIN_EXE_meniscus-under-test"))
            .args(["run", "--patient", "--json", "--seconds", "4", "--variant", variant, "--out"])
            .arg(&out)
            .output()
            .expect("it starts");
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        let report: Value = serde_json::from_slice(&done.stdout).expect("one JSON object");
        (report, String::from_utf8_lossy(&done.stderr).into_owned())
    };
    let names = |report: &Value| -> Vec<String> {
        let checks = report["checks"].as_array().expect("checks");
        checks.iter().map(|check| check["name"].as_str().expect("a name").to_owned()).collect()
    };
    let ((full, _), (small, said)) = (run("full"), run("small"));
    assert!(names(&full).iter().any(|name| name.starts_with("field_error_")));
    assert!(!names(&small).iter().any(|name| name.starts_with("field_error_")), "{:?}", names(&small));
    assert!(names(&small).contains(&"surface_slosh_rel".to_owned()));
    assert!(said.contains("--variant full"), "{said}");
}
