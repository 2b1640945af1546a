//! Plans against closed forms, a dense search and their own limits.

use meniscus::blob::Model;
use meniscus_data::liquids::Liquid;
use meniscus_data::scene_file::GLASS;
use meniscus_plan::{
    GlassState, LearnedModel, Limits, Pendulum, Plan, PlanError, ReducedLiquid, Request, SurfaceModel, plan,
    smoothest,
};
use meniscus_platform::files::AlignedBytes;

const REQUEST: Request = Request {
    to_m: 0.3,
    limits: Limits { speed_m_s: 1.5, acceleration_m_s2: 5.0, jerk_m_s3: 200.0 },
    limit_m: 0.006,
    confidence: 0.95,
    residual_m: None,
};

/// A liquid that follows every acceleration at once by next to nothing: the surface limits no motion of it.
const STIFF: Pendulum = Pendulum { frequency: 60.0, damping: 0.7, radius_m: 1e-4, room_m: 0.04 };

fn water() -> ReducedLiquid {
    ReducedLiquid::new(&GLASS, &Liquid::load("water").expect("water")).expect("a cylinder")
}

/// Looks at `plan` at a thousand instants, whatever its knots.
fn keeps_the_limits(plan: &Plan, request: &Request, from_m: f64) {
    let limits = request.limits;
    let duration_s = plan.course.duration_s();
    let h = duration_s / 1000.0;
    let mut last = GlassState::resting(from_m);
    for k in 0..=1000 {
        let state = plan.course.at(f64::from(k) * h);
        assert!(state.speed_m_s.abs() <= limits.speed_m_s * (1.0 + 1e-6), "{state:?}");
        assert!(state.acceleration_m_s2.abs() <= limits.acceleration_m_s2 * (1.0 + 1e-6), "{state:?}");
        let jerk = (state.acceleration_m_s2 - last.acceleration_m_s2) / h;
        assert!(k == 0 || jerk.abs() <= limits.jerk_m_s3 * (1.0 + 1e-6) || k == 1000, "{jerk} in {k}");
        last = state;
    }
    let end = plan.course.at(duration_s);
    assert!((end.position_m - request.to_m).abs() < 1e-6, "{end:?}");
    let just_before = plan.course.at(duration_s - 1e-9);
    assert!(
        just_before.speed_m_s.abs() < 1e-5 && just_before.acceleration_m_s2.abs() < 1e-3,
        "{just_before:?}"
    );
}

/// Without a surface that matters the fastest motion is the jerk-limited one of seven phases.
#[test]
fn without_a_surface_the_fastest_time_is_the_closed_form() {
    for (distance_m, limits) in [
        (0.02, REQUEST.limits),
        (0.3, REQUEST.limits),
        (1.2, REQUEST.limits),
        (0.3, Limits { speed_m_s: 0.5, acceleration_m_s2: 3.0, jerk_m_s3: 30.0 }),
        (-0.4, Limits { speed_m_s: 2.0, acceleration_m_s2: 2.0, jerk_m_s3: 500.0 }),
    ] {
        let request = Request { to_m: distance_m, limits, limit_m: 0.03, ..REQUEST };
        let found = plan(&STIFF, &STIFF.rest(), 0.0, &request).expect("a motion");
        let (duration_s, due_s) = (found.course.duration_s(), limits.shortest_s(distance_m));
        assert!(duration_s >= due_s * (1.0 - 1e-6), "{duration_s} below {due_s}");
        assert!(duration_s <= due_s + found.course.knot_s, "{duration_s} for {due_s}, {distance_m} m");
        keeps_the_limits(&found, &request, 0.0);
    }
}

/// Every bang-bang acceleration of a few switches is tried: none has a lower crest in the same time.
#[test]
fn no_motion_of_a_dense_search_has_a_lower_crest() {
    let mode = Pendulum { frequency: 22.0, damping: 0.1, radius_m: 0.035, room_m: 0.04 };
    let request = Request { to_m: 0.1, limit_m: 0.03, ..REQUEST };
    let duration_s = 0.5;
    let best = smoothest(&mode, &mode.rest(), 0.0, &request, duration_s).expect("a motion");
    // Accelerations a1, a2, a1', a2' over quarters of the two halves, mirrored: at rest at the end by symmetry.
    let frames = 30 + 30;
    let mut lowest_m = f64::INFINITY;
    for share in 0..=200 {
        for early in 0..=60 {
            let (ratio, quarter) = (0.05 + f64::from(share) / 100.0, f64::from(early) / 120.0);
            let shape = |s: f64| match s {
                s if s < quarter => ratio,
                s if s < 0.5 => 1.0,
                s if s < 1.0 - quarter => -1.0,
                s if s < 1.0 => -ratio,
                _ => 0.0,
            };
            let step_s = duration_s / 600.0;
            let (mut v, mut x) = (0.0, 0.0);
            let mut speeds = vec![0.0];
            for k in 0..frames * 20 {
                x += step_s * (v + 0.5 * step_s * shape((f64::from(k) + 0.5) / 600.0));
                v += step_s * shape((f64::from(k) + 0.5) / 600.0);
                if (k + 1) % 20 == 0 {
                    speeds.push(v);
                }
            }
            let inputs: Vec<f64> = speeds.windows(2).map(|w| (w[1] - w[0]) * 60.0 * 0.1 / x).collect();
            let crest = mode.forecast(&[0.0; 2], &inputs).iter().map(|f| f.crest_m()).fold(0.0, f64::max);
            lowest_m = lowest_m.min(crest);
        }
    }
    println!("program {:.3} mm, search {:.3} mm", 1e3 * best.crest_m, 1e3 * lowest_m);
    assert!(best.crest_m <= lowest_m * 1.002, "{} above {lowest_m}", best.crest_m);
    assert!(best.crest_m > 0.5 * lowest_m, "a crest that low would be a mistake of the program");
}

/// Of all slow motions the one of a constant acceleration and an equal braking has the lowest crest: 4 D/T^2 R/g.
#[test]
fn a_slow_surface_has_the_closed_form_of_a_constant_acceleration() {
    let mode = Pendulum { frequency: 60.0, damping: 0.7, radius_m: 0.035, room_m: 0.04 };
    let limits = Limits { jerk_m_s3: 2000.0, ..REQUEST.limits };
    let request = Request { to_m: 0.4, limits, limit_m: 0.03, ..REQUEST };
    let best = smoothest(&mode, &mode.rest(), 0.0, &request, 2.0).expect("a motion");
    let due_m = 4.0 * 0.4 / 4.0 * 0.035 / 9.806_65;
    assert!((1.0..1.1).contains(&(best.crest_m / due_m)), "{} for {due_m}", best.crest_m);
}

/// Glycerine by the learned model: the forecast keeps the limit, and a lower limit or a higher confidence takes longer.
#[test]
fn the_learned_model_plans_below_the_limit() {
    let bytes = AlignedBytes::copy(meniscus_shipped::MODEL);
    let model = Model::load(&bytes).expect("the shipped model");
    let learned = LearnedModel::new(&model);
    let time = |request: &Request| {
        let start = std::time::Instant::now();
        let found = plan(&learned, &learned.rest(), 0.0, request).expect("a motion");
        println!(
            "{:.3} s, crest {:.2} +- {:.2} mm, {} programs, {:.0} ms",
            found.course.duration_s(),
            1e3 * found.crest_m,
            1e3 * found.half_width_m,
            found.programs,
            1e3 * start.elapsed().as_secs_f64()
        );
        assert!(found.bound_m <= 1.0021 * request.limit_m);
        let used = found.bound_m / request.limit_m;
        // With a limit after arrival the crest may be below the other one.
        let least = if request.residual_m.is_some() { 0.85 } else { 0.93 };
        assert!(used > least, "the limit is used: {used}");
        keeps_the_limits(&found, request, 0.0);
        found.course.duration_s()
    };
    let plain = time(&REQUEST);
    assert!(time(&Request { limit_m: 0.004, ..REQUEST }) > 1.1 * plain);
    assert!(time(&Request { confidence: 0.995, ..REQUEST }) > plain);
    assert!(time(&Request { residual_m: Some(0.001), ..REQUEST }) >= 0.99 * plain);
}

/// Plans at finely spaced confidences, from which the search has to come back with the same answer but for a little.
fn at_every_confidence<M: SurfaceModel>(model: &M, to_m: f64) {
    let steps = 12;
    let mut last_s = 0.0;
    for step in 0..=steps {
        let confidence = 0.8 + 0.19 * f64::from(step) / f64::from(steps);
        let request = Request { to_m, confidence, limits: Limits::default(), ..REQUEST };
        let found = plan(model, &model.rest(), 0.0, &request).expect("a motion");
        let (duration_s, used) = (found.course.duration_s(), found.bound_m / request.limit_m);
        assert!((0.93..1.0021).contains(&used), "{used} of the limit at {confidence}, {to_m} m");
        // One search may end a little beside the next: the lowest crest of a duration is that of a local search.
        assert!(duration_s > 0.98 * last_s, "{duration_s} s after {last_s} s at {confidence}, {to_m} m");
        last_s = duration_s;
    }
}

/// The limit is used whatever the numbers are, and more confidence never takes less time.
#[test]
fn the_limit_is_used_at_every_confidence() {
    let bytes = AlignedBytes::copy(meniscus_shipped::MODEL);
    let model = Model::load(&bytes).expect("the shipped model");
    let learned = LearnedModel::new(&model);
    at_every_confidence(&learned, 0.3);
    for to_m in [0.12, 0.3, 0.48] {
        at_every_confidence(&water(), to_m);
    }
}

/// Water by the reduced model.
#[test]
fn the_reduced_model_plans_below_the_limit() {
    let water = water();
    let start = std::time::Instant::now();
    let found = plan(&water, &water.rest(), 0.1, &Request { to_m: -0.1, ..REQUEST }).expect("a motion");
    println!(
        "{:.3} s, crest {:.2} mm, {} programs, {:.0} ms",
        found.course.duration_s(),
        1e3 * found.crest_m,
        found.programs,
        1e3 * start.elapsed().as_secs_f64()
    );
    assert!(found.bound_m <= 1.0021 * REQUEST.limit_m);
    keeps_the_limits(&found, &Request { to_m: -0.1, ..REQUEST }, 0.1);
}

#[test]
fn what_cannot_be_kept_is_refused() {
    let water = water();
    let refused = |request: &Request| plan(&water, &water.rest(), 0.0, request).expect_err("refused");
    assert!(matches!(refused(&Request { limit_m: 0.05, ..REQUEST }), PlanError::Rim { .. }));
    let fine = refused(&Request { limit_m: 0.00012, ..REQUEST });
    assert!(fine.to_string().contains("cannot be promised"), "{fine}");
    let slow = Limits { speed_m_s: 0.02, ..REQUEST.limits };
    let far = refused(&Request { to_m: 2.0, limits: slow, ..REQUEST });
    assert!(far.to_string().contains("at this speed"), "{far}");
    // A slosh that is there already is above the limit, whatever the motion is.
    let mut sloshing = water.rest();
    sloshing.modes.height[0][0] = 0.01;
    let wild = plan(&water, &sloshing, 0.0, &REQUEST).expect_err("refused");
    assert!(wild.to_string().contains("wait until the liquid is calm"), "{wild}");
}
