//! Training end to end on an ideal slosh, and its networks against PyTorch.
#![cfg(feature = "train")]
#![allow(clippy::disallowed_methods, reason = "only storey 1 must compute the same bits on every platform")]

mod slosh;
mod torch;
#[path = "slosh/watch.rs"]
mod watch;

use meniscus::model::{Header, MAGIC};
use meniscus::offline::train::{Options, Schedule, TrainError, train};
use std::sync::atomic::AtomicBool;

fn options(schedule: Schedule) -> Options {
    Options { seed: 1, schedule, quiet: true, command: String::from("cargo test") }
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
    assert!(value("filter, camera noise: surface slosh-rel") < 5.0);
    assert!(value("filter, camera noise: v") < 8.0);
    assert!(value("GENERIC with motion, 2 s roll-out: surface slosh-rel") < 10.0);
    assert!(value("GENERIC with motion, 2 s roll-out: v") < 10.0);
    // Not asserted, because it does not hold: the heat. This slosh keeps four of the thirteen latents
    // alive, and the soft tie of H to the books leaves work and heat about 113 % off; on simulated
    // glycerine, which uses all of them, they are some 10 % off (models/README.md).

    assert_eq!(trained.blob[..8], MAGIC);
    let (header, _): (Header, _) = postcard::take_from_bytes(&trained.blob[24..]).expect("a header");
    assert_eq!(header.particles, 2134);
    assert_eq!(header.sections.len(), 12 + 2 + 9 + 8 + 12);
    assert!(trained.blob.len() < 4 << 20, "{} bytes", trained.blob.len());

    // The same figures through the camera side, which shares no code with training but the equations.
    let watched = watch::watch(&trained.blob, &validation[0]);
    println!("camera side: slosh-rel {:.2} %, heat {:.3e} J", 100.0 * watched.slosh_rel, watched.heat_j);
    assert!(watched.at_rest_m < 1e-6, "rest decodes to rest, not {} m off", watched.at_rest_m);
    assert!(watched.slosh_rel < 0.25);
    assert_eq!(watched.unconverged, 0);
    assert!(watched.heat_j > 0.0);
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
