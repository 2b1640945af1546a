//! Prediction of a recording by the reduced model.

use crate::recordings::record::{Quantity, Record, mean_bow, parts};
use crate::recordings::stated::Known;
use meniscus::reduced::effects::Active;
use meniscus::reduced::{
    Baseline, Cylinder, DrawnLaw, Forcing, ReducedModel, ReducedState, Rheology, step, wall_harmonics,
};
use meniscus::surface::{POINTS, profile_abscissa};

/// Steps in a frame; the discrete oscillators keep their frequency at any number.
const STEPS: usize = 2;

/// Calibrated numbers of the baseline, shared by all recordings; a lag for each recording follows them.
pub const SHARED: usize = 13;

/// Height of a wave in radii beyond which the model has lost it.
const HIGHEST: f64 = 10.0;

/// Index of the relative offset of the first frequency.
pub const FREQUENCY: usize = 0;

/// Index of the logarithm of the factor on the first damping.
pub const DAMPING: usize = 2;

/// Index of the excess of the radius over the stated one, m.
pub const RADIUS: usize = 11;

/// Index of the share of the contact line that a sticking wall holds.
pub const HELD_LINE: usize = 12;

/// Names of the shared numbers.
pub const NAMES: [&str; SHARED] = [
    "frequency 1",
    "frequency 2",
    "damping 1",
    "damping 2",
    "forcing 1",
    "forcing 2",
    "softening",
    "p of (0,1)",
    "q of (0,1)",
    "p of (2,1)",
    "q of (2,1)",
    "radius",
    "held line",
];

/// Returns the baseline whose numbers are the first of `theta`.
#[must_use]
pub fn baseline(theta: &[f64]) -> Baseline {
    let [f1, f2, d1, d2, l1, l2, softening, p0, q0, p2, q2] = std::array::from_fn(|i| theta[i]);
    Baseline {
        frequency: [f1, f2, f2],
        damping: [d1.clamp(-3.0, 3.0).exp(), d2.clamp(-3.0, 3.0).exp(), d2.clamp(-3.0, 3.0).exp()],
        lever: [1.0 + l1, 1.0 + l2, 1.0 + l2],
        detuning: softening,
        drive: Some([[p0, q0], [p2, q2]]),
        held_line: theta[HELD_LINE],
    }
}

/// Returns the reduced model of the liquid `known` with the numbers `theta` and the effects `active`, for frames every
/// `interval_s`.
#[must_use]
pub fn reduced_model(known: &Known, theta: &[f64], active: &[Active], interval_s: f64) -> ReducedModel {
    let radius_m = known.radius_m + theta[RADIUS].clamp(-0.5 * known.radius_m, known.radius_m);
    let glass = Cylinder { radius_m, depth_m: known.fill_m, density_kg_m3: known.density_kg_m3 };
    let liquid = Rheology::newtonian(known.viscosity_pa_s);
    ReducedModel::new(glass, liquid, &baseline(theta), active, interval_s / STEPS as f64)
}

/// Difference from the plain liquid: effects of the library, and an unnamed force.
#[derive(Clone, Copy, Debug, Default)]
pub struct Difference<'a> {
    /// Effects.
    pub active: &'a [Active],
    /// Unnamed force on the first mode.
    pub law: Option<&'a DrawnLaw>,
}

/// Returns the expected channels of `record`, m; `lag_s` is the delay of its frames against their time stamps.
#[must_use]
pub fn predict(
    record: &Record,
    known: &Known,
    theta: &[f64],
    lag_s: f64,
    active: &[Active],
) -> Vec<Vec<f64>> {
    predict_with(record, known, theta, lag_s, Difference { active, law: None })
}

/// Returns the same with any difference from the plain liquid.
#[must_use]
pub fn predict_with(
    record: &Record,
    known: &Known,
    theta: &[f64],
    lag_s: f64,
    difference: Difference<'_>,
) -> Vec<Vec<f64>> {
    predict_by(&model_with(record, known, theta, difference), record, known, lag_s)
}

/// Returns the reduced model of the liquid `known` with the numbers `theta` and any `difference`, for the frames of `record`.
#[must_use]
pub fn model_with(record: &Record, known: &Known, theta: &[f64], difference: Difference<'_>) -> ReducedModel {
    let model = reduced_model(known, theta, difference.active, record.interval_s);
    match difference.law {
        Some(law) => model.with_law(*law),
        None => model,
    }
}

/// Returns the expected channels of `record` by `model`, m; `lag_s` is the delay of its frames against their time stamps.
#[must_use]
pub fn predict_by(model: &ReducedModel, record: &Record, known: &Known, lag_s: f64) -> Vec<Vec<f64>> {
    let dt = record.interval_s / STEPS as f64;
    let (port, view) = (model.port, model.view);
    let shift = port.delay_s + view.latency_s + lag_s;
    let push_at = |time: f64| {
        let (along, tilted, lift, _) = record.drive.at(time - shift);
        let share = known.motion_share[0] + port.tilt_share;
        Forcing {
            along_m_s2: [0, 1].map(|d| port.gain * along[d] + share * tilted[d]),
            lift_m_s2: (known.motion_share[1] + port.lift_share) * lift + port.lift_m_s2,
        }
    };
    let mut state = model.rest(&push_at(0.0));
    let mut out: Vec<Vec<f64>> =
        record.channels.iter().map(|_| Vec::with_capacity(record.frames())).collect();
    let (bowed, pitched) = (mean_bow(), pitch_parts());
    let radius = model.glass.radius_m;
    for frame in 0..record.frames() {
        let time = frame as f64 * record.interval_s;
        let push = push_at(time);
        let wall = wall_harmonics(model, &state, &push.along_m_s2);
        for (series, channel) in out.iter_mut().zip(&record.channels) {
            series.push(match channel.quantity {
                Quantity::Level => {
                    view.scale * (model.glass.depth_m + wall[0] + bowed * wall[3])
                        + view.pitch_rad * radius * pitched[0]
                        - known.fill_m
                }
                Quantity::Slope => {
                    // A constant inclination: level in the room, so inclined in the glass.
                    view.scale * (wall[1] + radius * port.tilt_rad.tan()) + radius * view.slope_rad.tan()
                }
                Quantity::Bow => view.scale * wall[3] + view.pitch_rad * radius * pitched[1],
                Quantity::Place => view.scale * port.gain * record.drive.at(time - shift).3,
                Quantity::Peak => highest(&wall),
            });
        }
        for half in 0..STEPS {
            step(model, &mut state, &push_at(time + (half as f64 + 0.5) * dt));
        }
        let waves = state.height.iter().chain(&state.bound_waves.height).flatten();
        if waves.copied().any(|height| height.is_nan() || height.abs() >= HIGHEST * radius) {
            // Parameters far out of range, along x or y: what follows would be infinite.
            state = ReducedState::default();
        }
    }
    out
}

/// Returns mean and bow of `1 - sqrt(1 - s^2)` over the points of a profile.
fn pitch_parts() -> [f64; 2] {
    let shape = |i: usize| (i, 1.0 - (1.0 - profile_abscissa(i).powi(2)).sqrt());
    parts((0..POINTS).map(shape)).map_or([0.0; 2], |[mean, _, bow, _]| [mean, bow])
}

/// Returns the highest point along the wall of a surface with these harmonics, m.
fn highest(wall: &[f64; 5]) -> f64 {
    let at = |angle: f64| {
        let (sin, cos) = angle.sin_cos();
        wall[0]
            + wall[1] * cos
            + wall[2] * sin
            + wall[3] * (cos * cos - sin * sin)
            + wall[4] * 2.0 * sin * cos
    };
    // The first harmonic's crest, then uphill by halving steps.
    let mut best = wall[2].atan2(wall[1]);
    let mut height = at(best);
    let mut reach = 0.6;
    while reach > 1e-3 {
        let (left, right) = (at(best - reach), at(best + reach));
        if left > height && left >= right {
            (best, height) = (best - reach, left);
        } else if right > height {
            (best, height) = (best + reach, right);
        } else {
            reach *= 0.5;
        }
    }
    height
}
