//! One planned move in the particle simulator, with the estimator in the loop.

use meniscus::blob::Model;
use meniscus_data::effects::Effects;
use meniscus_data::scene_file::GLASS;
use meniscus_plan::study::{Bench, Camera, StudyLiquid, carry_planned, carry_rival};
use meniscus_plan::{LearnedModel, LearnedWatcher, Limits, Request, SurfaceModel, minimum_jerk, plan};
use meniscus_platform::files::AlignedBytes;
use meniscus_sph::{Setup, WatchedGlass};
use std::sync::atomic::AtomicBool;

/// The crest of the simulator is the predicted one within its interval, below the limit, and below that of minimum jerk.
#[test]
fn the_predicted_crest_comes_true_in_the_simulator() {
    let stop = AtomicBool::new(false);
    let setup = Setup {
        glass: GLASS,
        liquid: StudyLiquid::Glycerine.load().expect("glycerine"),
        spacing_m: 0.005,
        seed: 3,
        no_slip: true,
        effects: Effects::default(),
        step_s: None,
    };
    let glass = WatchedGlass::new(&setup, &stop).expect("it settles");
    let bench = Bench { glass: &glass, fill_m: GLASS.fill_m, stop: &stop };
    let bytes = AlignedBytes::copy(meniscus_shipped::MODEL);
    let model = Model::load(&bytes).expect("the shipped model");
    let learned = LearnedModel::new(&model);
    let request =
        Request { to_m: 0.15, limits: Limits::default(), limit_m: 0.007, confidence: 0.95, residual_m: None };
    let predicted = plan(&learned, &learned.rest(), 0.0, &request).expect("a plan");
    let carried = carry_planned(bench, &learned, LearnedWatcher::default(), Camera::new(9), &request)
        .expect("a move in the simulator");
    let plain = carry_rival(bench, &minimum_jerk(0.0, 0.15, carried.arrival_s)).expect("a move");
    println!(
        "predicted {:.2} ± {:.2} mm in {:.3} s, came {:.2} mm in {:.3} s; minimum jerk {:.2} mm",
        1e3 * predicted.crest_m,
        1e3 * predicted.half_width_m,
        predicted.course.duration_s(),
        1e3 * carried.crest_m,
        carried.arrival_s,
        1e3 * plain.crest_m
    );
    assert_eq!(carried.unsolved, 0);
    assert!(carried.solve_ms.len() >= 3, "planned anew at 10 Hz: {:?}", carried.solve_ms);
    assert!(carried.crest_m <= request.limit_m);
    assert!((carried.crest_m - predicted.crest_m).abs() <= 1.5 * predicted.half_width_m);
    assert!(carried.crest_m < 0.85 * plain.crest_m);
    let end_m = carried.trace.position_m.last().expect("a position");
    assert!((end_m - 0.15).abs() < 1e-5);
}
