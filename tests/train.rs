//! Training end to end on an ideal slosh, and its networks against PyTorch.

mod slosh;
mod torch;
#[path = "slosh/watch.rs"]
mod watch;

use meniscus::blob::{Header, MAGIC};
use meniscus_learn::{Base, Hyperparameters, Options, Schedule, TrainError, train};
use meniscus_optim::progress::Checkpoints;
use std::sync::atomic::AtomicBool;

fn options(schedule: Schedule) -> Options {
    Options {
        seed: 1,
        hyperparameters: Hyperparameters::with_schedule(schedule),
        soft: true,
        sparse: true,
        quiet: true,
        command: String::from("cargo test"),
        checkpoints: None,
        base: Base::Scratch,
        flow_law: None,
    }
}

const SHORT: Schedule = Schedule { autoencoder: 800, encoder: 60, rollout: 300, seeds: 1 };

#[test]
fn an_ideal_slosh_is_learnt() {
    let training: Vec<_> = (0..4).map(|k| slosh::recording(300, 0.012 + 0.004 * k as f64, k)).collect();
    let validation = [slosh::recording(300, 0.018, 99)];
    let begun = std::time::Instant::now();
    let trained = train(&training, &validation, &options(SHORT), &AtomicBool::new(false)).expect("a model");
    println!("trained in {:.1} s", begun.elapsed().as_secs_f64());
    for check in &trained.checks {
        println!("{:60} {:8.2?} {}", check.name, check.value, check.unit);
    }
    let value = |name: &str| {
        let check = trained.checks.iter().find(|c| c.name == name).expect("a check of that name");
        check.value.expect("a measured value")
    };
    assert!(value("decoder alone: v") < 3.0);
    assert!(value("estimate, camera noise: surface slosh-rel") < 5.0);
    assert!(value("estimate, camera noise: v") < 8.0);
    assert!(value("GENERIC with motion, 2 s roll-out: surface slosh-rel") < 10.0);
    assert!(value("GENERIC with motion, 2 s roll-out: v") < 10.0);
    // Nine of ten, within what a recording of its own noise may be off.
    let held = value("interval, 0.00 s ahead: surface held");
    assert!((75.0..=99.0).contains(&held), "{held} % of the heights lie within their interval");
    // The soft net has to say what it costs: its laws hold nowhere exactly.
    assert!(value("soft_M_dE") > 0.0 && value("soft_energy_drift") > 1e-4);
    assert!(value("exact_M_dE") < 1e-6 && value("exact_L_dS") < 1e-6 && value("exact_energy_drift") < 1e-6);
    assert!(value("entropy_falls") == 0.0 && value("energy_drift_step") < 1e-6);
    assert!(value("steps_of_both") > 100.0 && value("soft_rollout").is_finite());
    assert!(value("exact_rollout") < 20.0);
    // The paper's five share the same thirteen latents, and what they decode is no better for it.
    let kept: f64 = [("q", 20), ("v", 20), ("e", 10), ("sigma", 20), ("tau", 20)]
        .map(|(group, of)| value(&format!("five sparse autoencoders: latents of {group} kept of {of}")))
        .iter()
        .sum();
    assert_eq!(kept, 13.0);
    let apart = value("five sparse autoencoders: v");
    assert!(apart < 60.0 && apart > value("decoder alone: v"), "{apart} %");
    for stage in ["autoencoder", "encoder", "soft"] {
        let curve = trained.curves.iter().find(|curve| curve.stage == stage).expect("a curve of each stage");
        let (first, last) = (curve.looks.first().expect("a look"), curve.looks.last().expect("a look"));
        assert!(last.0 > first.0 && last.2 < first.2, "{stage} has learnt: {first:?} to {last:?}");
    }
    // Not asserted, because it does not hold: the heat. This slosh keeps four of the thirteen latents
    // alive, and the soft tie of H to the books leaves work and heat about 113 % off; on simulated
    // glycerine, which uses all of them, they are some 10 % off (models/README.md).

    assert_eq!(trained.blob[..8], MAGIC);
    let (header, _): (Header, _) = postcard::take_from_bytes(&trained.blob[24..]).expect("a header");
    assert_eq!(header.particles, 2134);
    assert_eq!(header.sections.len(), 12 + 2 + 9 + 8 + 12 + 8);
    assert!(trained.blob.len() < 4 << 20, "{} bytes", trained.blob.len());

    // The same figures through the camera side, which shares no code with training but the equations.
    let watched = watch::watch(&trained.blob, &validation[0]);
    println!("camera side: slosh-rel {:.2} %, heat {:.3e} J", 100.0 * watched.slosh_rel, watched.heat_j);
    assert!(watched.at_rest_m < 1e-6, "rest decodes to rest, not {} m off", watched.at_rest_m);
    assert!(watched.slosh_rel < 0.25);
    assert_eq!(watched.unconverged, 0);
    assert!(watched.heat_j > 0.0);
}

/// A training that was broken off and resumed is the training that was not.
#[test]
fn a_resumed_training_is_the_same_training() {
    const BRIEF: Schedule = Schedule { autoencoder: 400, encoder: 10, rollout: 100, seeds: 1 };
    let training = [slosh::recording(200, 0.016, 1), slosh::recording(200, 0.02, 2)];
    let validation = [slosh::recording(200, 0.018, 3)];
    let whole = Options { soft: false, sparse: false, ..options(BRIEF) };
    let due = train(&training, &validation, &whole, &AtomicBool::new(false)).expect("a model").blob;

    let folder = std::env::temp_dir().join(format!("meniscus-resume-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let kept = |resume| Options {
        checkpoints: Some(Checkpoints { folder: folder.clone(), resume }),
        ..whole.clone()
    };
    // Stopped as soon as the first checkpoint lies there: in the middle of the autoencoder, or of a later part.
    let stop = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let broken = scope.spawn(|| train(&training, &validation, &kept(false), &stop));
        std::thread::sleep(std::time::Duration::from_millis(300));
        stop.store(true, std::sync::atomic::Ordering::Relaxed);
        // Whether there is a model yet depends on when; the checkpoints have to be there in any case.
        let _ = broken.join().expect("no panic");
    });
    assert!(std::fs::read_dir(&folder).expect("the folder").count() > 0, "a checkpoint was kept");
    let resumed = train(&training, &validation, &kept(true), &AtomicBool::new(false)).expect("a model");
    assert!(resumed.blob == due, "the same blob, byte for byte");

    // Another training takes nothing from there.
    let other = Options { seed: 2, ..kept(true) };
    let fresh = train(&training, &validation, &other, &AtomicBool::new(false)).expect("a model");
    assert!(fresh.blob != due, "another seed, another blob");
    std::fs::remove_dir_all(&folder).expect("removed");
}

#[test]
fn stopping_before_the_start_leaves_nothing() {
    let recordings = [slosh::recording(120, 0.02, 5)];
    let outcome = train(&recordings, &recordings, &options(SHORT), &AtomicBool::new(true));
    assert!(matches!(outcome, Err(TrainError::Interrupted)), "{outcome:?}");
}

#[test]
fn nothing_to_learn_from_is_said() {
    let one = [slosh::recording(60, 0.0, 1)];
    let outcome = train(&one, &one, &options(SHORT), &AtomicBool::new(false));
    assert!(matches!(outcome, Err(TrainError::NoMotion)), "{outcome:?}");
    let outcome = train(&[], &one, &options(SHORT), &AtomicBool::new(false));
    assert!(matches!(outcome, Err(TrainError::NoRecording)), "{outcome:?}");
}
