//! Limits on surface and speed: rows with an entry for every knot, of which a program takes those that matter.

use super::stated::Program;
use crate::response::{ENDS, inputs_of, unit_inputs};
use meniscus::units::FRAME_INTERVAL_S;

/// Distance of a limit from its bound within which a program takes it at first, in units of the bound.
const CLOSE: f64 = 0.3;

/// Frames of which one is taken where no motion nearby is known.
const EVERY: usize = 3;

/// Excess over a bound, in its units, that breaks it.
const BROKEN: f64 = 1e-5;

/// Distance from its bound within which a limit is taken beside one that is broken: the next solution would break it.
const BESIDE: f64 = 0.02;

/// One limit on the accelerations a_k: known + sum_k b_k a_k <= c, or <= 0; heights in units of L, speeds in units of V.
#[derive(Clone, Debug)]
pub(super) struct Limit {
    /// b_k of the inner knots, for accelerations in units of A.
    pub(super) by_knot: Vec<f64>,
    /// Part that no unknown changes.
    pub(super) known: f64,
    /// Whether the crest c is the bound.
    pub(super) under_crest: bool,
    /// Frame of a height; none of a speed.
    frame: Option<usize>,
}

impl Limit {
    /// Excess over the bound at `solution`: accelerations, then the crest.
    fn excess(&self, solution: &[f64]) -> f64 {
        let sum: f64 = self.by_knot.iter().zip(solution).map(|(b, a)| b * a).sum();
        let crest = if self.under_crest { solution[self.by_knot.len()] } else { 0.0 };
        self.known + sum - crest
    }
}

/// All limits of a program.
pub(super) struct Limits {
    pub(super) all: Vec<Limit>,
}

impl Limits {
    pub(super) fn of(program: &Program<'_>) -> Self {
        let mut all = surface(program);
        all.extend(speed(program));
        Self { all }
    }

    /// Returns which limits a program takes at first.
    pub(super) fn first(&self, program: &Program<'_>) -> Vec<bool> {
        let Some(mut nearby) = program.nearby() else {
            return self
                .all
                .iter()
                .map(|limit| limit.frame.is_some_and(|frame| frame % EVERY == 0))
                .collect();
        };
        // Its own crest; a renewed plan is not to be lower than the limit.
        nearby.push(0.0);
        let under_crest = self.all.iter().filter(|limit| limit.under_crest);
        let crest = under_crest.map(|limit| limit.excess(&nearby)).fold(f64::NEG_INFINITY, f64::max);
        nearby[program.knots - 1] = program.preferred.enough().map_or(crest, |enough| crest.min(enough));
        self.all.iter().map(|limit| limit.excess(&nearby) > -CLOSE).collect()
    }

    /// Adds the limits that `solution` breaks to the `chosen` ones; returns whether there are any.
    pub(super) fn add_broken(&self, solution: &[f64], chosen: &mut [bool]) -> bool {
        let excess: Vec<f64> = self.all.iter().map(|limit| limit.excess(solution)).collect();
        let broken = excess.iter().zip(chosen.iter()).any(|(excess, chosen)| *excess > BROKEN && !chosen);
        if broken {
            for (excess, chosen) in excess.iter().zip(chosen) {
                *chosen |= *excess > -BESIDE;
            }
        }
        broken
    }
}

/// The surface below the crest, and below the residual after arrival.
fn surface(program: &Program<'_>) -> Vec<Limit> {
    let (scales, start, inner) = (program.scales(), program.departure.glass, program.knots - 1);
    let limit_m = program.request.limit_m;
    let free = inputs_of(program.input, program.departure.before_m, program.frames, |t| start.drifted(t));
    let free = program.response.heights(&free);
    // For a jerk of unity behind each knot.
    let by_jerk: Vec<Vec<[f64; ENDS]>> = (0..program.knots)
        .map(|i| program.response.heights(&unit_inputs(program.input, i, scales.knot_s, program.frames)))
        .collect();
    let unit = scales.acceleration_m_s2 / scales.knot_s / limit_m;
    let mut out = Vec::new();
    for frame in 0..program.frames {
        let arrived = (frame + 1) as f64 * FRAME_INTERVAL_S > program.duration_s;
        for end in 0..ENDS {
            let height = |i: usize| unit * by_jerk[i][frame][end];
            let by_knot: Vec<f64> = (1..=inner).map(|k| height(k - 1) - height(k)).collect();
            let known =
                (free[frame][end] + program.correction.at(frame, end)) / limit_m - height(0) * scales.first;
            let limit = Limit { by_knot, known, under_crest: true, frame: Some(frame) };
            if let Some(residual_m) = program.request.residual_m.filter(|_| arrived) {
                out.push(Limit { known: known - residual_m / limit_m, under_crest: false, ..limit.clone() });
            }
            out.push(limit);
        }
    }
    out
}

/// The speed towards the goal; none where the robot cannot become so fast.
fn speed(program: &Program<'_>) -> Vec<Limit> {
    let (scales, start, limits) = (program.scales(), program.departure.glass, program.request.limits);
    let fastest = start.speed_m_s.abs() + 0.5 * limits.acceleration_m_s2 * program.duration_s;
    if fastest <= limits.speed_m_s {
        return Vec::new();
    }
    let forward = (program.request.to_m - start.position_m).signum();
    let unit = forward * scales.knot_s / limits.speed_m_s;
    let mut out = Vec::new();
    for k in 0..program.knots {
        // Half of the first and of the last acceleration counts at a knot, and all of the last half an interval ahead.
        for ahead in [0.0, 0.5] {
            let share = |i: usize| match i {
                i if i < k => scales.acceleration_m_s2,
                i if i == k => (0.5 + ahead) * scales.acceleration_m_s2,
                _ => 0.0,
            };
            let first = if k == 0 { ahead } else { 0.5 };
            let known = forward * start.speed_m_s / limits.speed_m_s - 1.0
                + unit * first * scales.acceleration_m_s2 * scales.first;
            let by_knot = (1..program.knots).map(|i| unit * share(i)).collect();
            if k > 0 || ahead > 0.0 {
                out.push(Limit { by_knot, known, under_crest: false, frame: None });
            }
        }
    }
    out
}
