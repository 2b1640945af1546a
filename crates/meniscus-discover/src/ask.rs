//! Which recording would tell the leading candidates apart: what each foretells of motions that were not
//! made, in units of the noise, after the baseline has done its best to hide the difference.

use super::calibrate::Calibration;
use super::fit::Fitted;
use super::predict::SHARED;
use super::problem::Problem;
use super::record::{Channel, Record};
use super::verdict::Verdict;
use crate::motion_table::drive_of;
use crate::study::motion_plans::{Kind, courses};
use meniscus_data::motion::Motion;
use nalgebra::{DMatrix, DVector};

/// What to record.
#[derive(Clone, Debug)]
pub struct Question {
    /// In words.
    pub motion: String,
    /// Which of the motions that may be asked for.
    pub course: usize,
    /// The two candidates that it should part.
    pub between: [String; 2],
    /// How far it would part them, signal over noise.
    pub separation: f64,
    /// The same for every motion that was looked at.
    pub all: Vec<(String, f64)>,
    /// Length of the recording, s.
    pub seconds: f64,
}

impl Question {
    /// Whether its record could part them at all: exact twins are parted by nothing.
    #[must_use]
    pub fn hopeful(&self) -> bool {
        self.separation >= 1.0
    }
}

/// The motion that parts the best two candidates most, where there are two that were fitted.
#[must_use]
pub fn ask(problem: &Problem, calibration: &Calibration, verdict: &Verdict) -> Option<Question> {
    let rivals = if verdict.chosen.active.len() > 1 { &verdict.pairs } else { &verdict.ranking };
    let fitted: Vec<_> = rivals.iter().filter_map(|r| r.fitted.as_ref().map(|f| (r, f))).take(2).collect();
    let [(one, a), (two, b)] = fitted.as_slice() else { return None };
    let mut all = Vec::new();
    for (number, course) in courses(Kind::Asked).iter().enumerate() {
        let jolt = course.jolts[0];
        let motion = format!(
            "a jolt of {:.2} s and {:.1} m/s2, {:.0} s in all",
            jolt.period_s, jolt.strength_m_s2, course.seconds
        );
        let record = foretold(problem.records().next()?, course)?;
        let parted = separation(&record, problem, calibration, a, b)?;
        all.push((number, motion, parted, course.seconds));
    }
    let best = all.iter().max_by(|x, y| x.2.total_cmp(&y.2))?;
    Some(Question {
        motion: best.1.clone(),
        course: best.0,
        between: [one.names.join(" + "), two.names.join(" + ")],
        separation: best.2,
        seconds: best.3,
        all: all.iter().map(|(_, motion, parted, _)| (motion.clone(), *parted)).collect(),
    })
}

/// A recording like `like` of a motion that was not made: every number seen, none known.
fn foretold(like: &Record, course: &crate::study::motion_plans::Course) -> Option<Record> {
    let motion = Motion::sampled(&course.samples())?;
    let frames = (course.seconds / like.interval_s) as usize;
    let channels = like.channels.iter();
    Some(Record {
        name: "foretold".into(),
        interval_s: like.interval_s,
        channels: channels
            .map(|c| Channel { quantity: c.quantity, value: vec![Some(0.0); frames] })
            .collect(),
        drive: drive_of(&motion, course.seconds),
        rest_frames: (course.jolts[0].start_s / like.interval_s) as usize,
    })
}

/// `|(1 - Q Q^T) W (f_a - f_b)|` with the basis Q of what the baseline can do.
fn separation(
    record: &Record,
    problem: &Problem,
    calibration: &Calibration,
    a: &Fitted,
    b: &Fitted,
) -> Option<f64> {
    let one = Problem::new(std::slice::from_ref(record), problem.known, calibration, 1.0).ok()?;
    let theta = |fitted: &Fitted| {
        let mut theta = fitted.theta[..SHARED].to_vec();
        theta.push(calibration.lag_s);
        theta
    };
    let data = one.count();
    let of = |theta: &[f64], fitted: &Fitted| one.residual(theta, &fitted.active).rows(0, data).clone_owned();
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
