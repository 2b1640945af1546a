//! A motion in progress: kept where the estimate is off by its error, changed where the liquid sloshes, and whole at every change.

use meniscus_data::liquids::Liquid;
use meniscus_data::scene_file::GLASS;
use meniscus_plan::{
    GlassState, LEAD_FRAMES, Limits, Receding, ReducedLiquid, ReducedLiquidState, Request, SurfaceModel,
};

/// Frame of the look.
const FRAME: usize = 12;

const REQUEST: Request = Request {
    to_m: 0.4,
    limits: Limits { speed_m_s: 1.5, acceleration_m_s2: 5.0, jerk_m_s3: 60.0 },
    limit_m: 0.007,
    confidence: 0.95,
    residual_m: None,
};

fn water() -> ReducedLiquid {
    ReducedLiquid::new(&GLASS, &Liquid::load("water").expect("water")).expect("a cylinder")
}

/// The liquid in the frame of the look, as the motion of `receding` makes it, with `extra_m` more of the first mode.
fn liquid(model: &ReducedLiquid, receding: &Receding<'_, ReducedLiquid>, extra_m: f64) -> ReducedLiquidState {
    let mut state = model.rest();
    for frame in 1..=FRAME {
        model.advance(&mut state, receding.input(frame));
    }
    // It has been watched: what the forecast did not know of it is gone.
    state.covariance = model.rest().covariance;
    state.modes.height[0][0] += extra_m;
    state
}

/// Highest crest from the look on under the motion of `receding`, m.
fn crest_m(model: &ReducedLiquid, receding: &Receding<'_, ReducedLiquid>, from: &ReducedLiquidState) -> f64 {
    let mut state = from.clone();
    let last = (receding.arrival_s() * 60.0) as usize + 30;
    let mut crest_m = 0.0;
    for frame in FRAME + 1..last {
        let input = receding.input(frame);
        model.advance(&mut state, input);
        crest_m = f64::max(crest_m, model.look(&state, input).crest_m());
    }
    crest_m
}

/// The motion under way and the one after a look at a liquid with `extra_m` more slosh.
fn look(model: &ReducedLiquid, extra_m: f64) -> [Receding<'_, ReducedLiquid>; 2] {
    let start = || Receding::new(model, &model.rest(), 0.0, &REQUEST).expect("a plan");
    let (kept, mut renewed) = (start(), start());
    let measured = liquid(model, &kept, extra_m);
    renewed.renew(FRAME, &measured).expect("solved").expect("far from the goal");
    [kept, renewed]
}

#[test]
fn an_error_of_the_estimate_changes_nothing() {
    let water = water();
    for extra_m in [0.0, 2e-4, -2e-4] {
        let [kept, renewed] = look(&water, extra_m);
        assert_eq!(renewed.arrival_s(), kept.arrival_s(), "{extra_m} m");
        assert!((0..200).all(|k| kept.at(f64::from(k) * 0.01) == renewed.at(f64::from(k) * 0.01)));
    }
}

/// A slosh of 2 mm would break the limit: the rest of the move gets gentler, and stays smooth and within the limits of the robot.
#[test]
fn a_slosh_changes_the_motion_for_a_lower_crest() {
    let water = water();
    let mut changed = 0;
    for extra_m in [2e-3, -2e-3, 3e-3, -3e-3] {
        let [kept, renewed] = look(&water, extra_m);
        let measured = liquid(&water, &kept, extra_m);
        let [before_m, after_m] = [&kept, &renewed].map(|motion| crest_m(&water, motion, &measured));
        println!("{:.1} mm more: crest {:.2} to {:.2} mm", 1e3 * extra_m, 1e3 * before_m, 1e3 * after_m);
        if before_m > REQUEST.limit_m {
            changed += 1;
            assert!(after_m < before_m - 2e-4, "{after_m} m for {before_m} m");
        }
        smooth(&renewed);
    }
    assert!(changed >= 2, "a slosh of this size is no challenge");
}

/// Speed and acceleration have no steps, and the goal is reached at rest.
fn smooth(motion: &Receding<'_, ReducedLiquid>) {
    let h = 1e-3;
    let steps = (motion.arrival_s() / h) as usize;
    let Limits { speed_m_s, acceleration_m_s2, jerk_m_s3 } = REQUEST.limits;
    let mut last = motion.at(0.0);
    for k in 1..steps {
        let now = motion.at(k as f64 * h);
        let jerk = (now.acceleration_m_s2 - last.acceleration_m_s2) / h;
        assert!(now.speed_m_s.abs() <= speed_m_s * (1.0 + 1e-6));
        assert!(now.acceleration_m_s2.abs() <= acceleration_m_s2 * (1.0 + 1e-6));
        assert!(jerk.abs() <= jerk_m_s3 * (1.0 + 1e-3), "{jerk} at frame {}", k as f64 * h * 60.0);
        assert!((now.speed_m_s - last.speed_m_s).abs() <= 1.01 * h * acceleration_m_s2);
        last = now;
    }
    let GlassState { position_m, speed_m_s, .. } = motion.at(motion.arrival_s() + 0.1);
    assert!((position_m - REQUEST.to_m).abs() < 1e-6 && speed_m_s == 0.0);
    let switch_s = (FRAME + LEAD_FRAMES) as f64 / 60.0;
    let [before, behind] = [-1e-6, 1e-6].map(|offset| motion.at(switch_s + offset));
    assert!((before.speed_m_s - behind.speed_m_s).abs() < 1e-4);
}
