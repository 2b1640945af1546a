//! Suggested recording: the motion whose predictions by the leading candidates differ most, in units of the noise, after
//! the baseline is fitted to the difference.

use crate::baseline::calibrate::Calibration;
use crate::baseline::predict::{Difference, SHARED};
use crate::decision::assessment::Assessment;
use crate::fitting::problem::Problem;
use crate::recordings::motion_plan::MotionPlan;
use crate::recordings::record::{Channel, Record};
use crate::recordings::tables::drive_of;
use meniscus_data::motion::Motion;
use nalgebra::{DMatrix, DVector};

/// Separation of two candidates by one motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Separation {
    /// Index of the motion among those that may be suggested.
    pub plan: usize,
    /// Motion, in words.
    pub motion: String,
    /// Separation, signal over noise.
    pub separation: f64,
    /// Length of the recording, s.
    pub seconds: f64,
}

/// Suggested recording.
#[derive(Clone, Debug)]
pub struct Suggestion {
    /// Motion, in words.
    pub motion: String,
    /// Index of the motion among those that may be suggested.
    pub plan: usize,
    /// The two candidates that it distinguishes.
    pub between: [String; 2],
    /// Separation of the candidates, signal over noise.
    pub separation: f64,
    /// Every motion that was considered.
    pub considered: Vec<Separation>,
    /// Length of the recording, s.
    pub seconds: f64,
}

impl Suggestion {
    /// Returns whether the recording could distinguish the candidates at all; nothing distinguishes exact twins.
    #[must_use]
    pub fn hopeful(&self) -> bool {
        self.separation >= 1.0
    }
}

/// Returns the motions that may be suggested.
#[must_use]
pub fn suggestable() -> Vec<MotionPlan> {
    [(0.28, 2.0, 4.4), (0.16, 3.0, 2.2), (0.28, 0.3, 2.2)]
        .map(|(period, strength, seconds)| MotionPlan::jolt(period, strength, seconds))
        .to_vec()
}

/// Returns the motion that separates the best two fitted candidates most; none where fewer than two were fitted.
#[must_use]
pub fn suggest(problem: &Problem, calibration: &Calibration, assessment: &Assessment) -> Option<Suggestion> {
    let search = &assessment.search;
    let rivals = if assessment.chosen().active.len() > 1 { &search.pairs } else { &search.ranking };
    let fitted: Vec<_> = rivals.iter().filter_map(|r| r.fitted.as_ref().map(|f| (r, f))).take(2).collect();
    let [(one, a), (two, b)] = fitted.as_slice() else { return None };
    let names = [one, two].map(|rival| rival.names.join(" + "));
    let rival = |name, theta, active| Rival { name, theta, difference: Difference { active, law: None } };
    let one = rival(names[0].as_str(), &a.theta, &a.active);
    let two = rival(names[1].as_str(), &b.theta, &b.active);
    suggest_between(problem, calibration, &one, &two)
}

/// Explanation that a suggested recording shall distinguish from another one.
#[derive(Clone, Copy, Debug)]
pub struct Rival<'a> {
    /// Name.
    pub name: &'a str,
    /// The baseline's numbers that were fitted beside it.
    pub theta: &'a [f64],
    /// Difference from the plain liquid.
    pub difference: Difference<'a>,
}

/// Returns the motion that separates two explanations most; none where no motion can be made of the recordings.
#[must_use]
pub fn suggest_between(
    problem: &Problem,
    calibration: &Calibration,
    one: &Rival<'_>,
    two: &Rival<'_>,
) -> Option<Suggestion> {
    let mut considered = Vec::new();
    for (number, plan) in suggestable().iter().enumerate() {
        let jolt = plan.jolts[0];
        let motion = format!(
            "a jolt of {:.2} s and {:.1} m/s2, {:.0} s in all",
            jolt.period_s, jolt.strength_m_s2, plan.seconds
        );
        let record = planned(problem.records().next()?, plan)?;
        let separation = separation(&record, problem, calibration, [one, two])?;
        considered.push(Separation { plan: number, motion, separation, seconds: plan.seconds });
    }
    let best = considered.iter().max_by(|x, y| x.separation.total_cmp(&y.separation))?.clone();
    Some(Suggestion {
        motion: best.motion,
        plan: best.plan,
        between: [one, two].map(|rival| String::from(rival.name)),
        separation: best.separation,
        seconds: best.seconds,
        considered,
    })
}

/// Returns a recording like `like` of a motion that was not made: every number is measured, none is known.
fn planned(like: &Record, plan: &MotionPlan) -> Option<Record> {
    let motion = Motion::sampled(&plan.samples())?;
    let frames = (plan.seconds / like.interval_s) as usize;
    let channels = like.channels.iter();
    Some(Record {
        name: "planned".into(),
        interval_s: like.interval_s,
        channels: channels
            .map(|c| Channel { quantity: c.quantity, value: vec![Some(0.0); frames] })
            .collect(),
        drive: drive_of(&motion, plan.seconds),
        rest_frames: (plan.jolts[0].start_s / like.interval_s) as usize,
    })
}

/// Returns `|(1 - Q Q^T) W (f_a - f_b)|` with the basis Q of what the baseline can reproduce.
fn separation(
    record: &Record,
    problem: &Problem,
    calibration: &Calibration,
    rivals: [&Rival<'_>; 2],
) -> Option<f64> {
    let [a, b] = rivals;
    let one = Problem::new(std::slice::from_ref(record), problem.known, calibration, 1.0).ok()?;
    let theta = |rival: &Rival<'_>| {
        let mut theta = rival.theta[..SHARED].to_vec();
        theta.push(calibration.lag_s);
        theta
    };
    let data = one.count();
    let of = |theta: &[f64], rival: &Rival<'_>| {
        one.residual_with(theta, rival.difference).rows(0, data).clone_owned()
    };
    let mut change: DVector<f64> = of(&theta(a), a) - of(&theta(b), b);
    let base = theta(a);
    let start = of(&base, a);
    let mut basis = DMatrix::zeros(data + base.len(), base.len());
    for i in 0..base.len() {
        let h = 0.05 * one.deviation[i];
        let mut shifted = base.clone();
        shifted[i] += h;
        basis.view_mut((0, i), (data, 1)).copy_from(&((of(&shifted, a) - &start) / h));
        basis[(data + i, i)] = 1.0 / one.deviation[i];
    }
    change = change.resize_vertically(data + base.len(), 0.0);
    let q = basis.qr().q();
    let part = q.tr_mul(&change);
    Some((change - q * part).norm())
}
