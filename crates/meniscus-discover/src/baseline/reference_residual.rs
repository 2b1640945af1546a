//! Residual of the reduced model in one motion, learnt from references: mean and scatter.
//!
//! The model error belongs to the true motion of the glass, which the camera tracked. So a recording is compared with
//! the references whose glass travelled the same path, possibly later or scaled: the stated motion may be wrong, and a
//! wrong one must not lose the references.

use super::trend::ViscosityTrend;
use crate::recordings::record::{Quantity, Record};

/// Largest time shift against the references, s, and largest factor on their path.
const MAX_SHIFT_S: f64 = 0.12;
const MAX_SCALE: f64 = 1.18;

/// Largest residual of an aligned path, as a share of the path.
const MAX_PATH_RESIDUAL: f64 = 0.02;

/// Time shift, s, and logarithm of a factor below which none is applied: the covariance covers them.
const MIN_SHIFT_S: f64 = 0.003;
const MIN_LN_SCALE: f64 = 0.01;

/// Time shift and scale of a path against the one of the references.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MotionAlignment {
    /// Time by which it is later, frames.
    pub(super) late: f64,
    /// Factor by which it is larger.
    pub(super) scale: f64,
}

/// Residual of the references in one motion.
#[derive(Clone, Debug)]
pub struct ReferenceResidual {
    /// A reference that made the motion.
    pub(super) like: Record,
    /// Mean, by channel and frame, m.
    pub mean: Vec<Vec<f64>>,
    /// Scatter about it, one for each reference, m.
    pub scatter: Vec<Vec<Vec<f64>>>,
    /// Viscosity of each reference, Pa s.
    pub(super) viscosities_pa_s: Vec<f64>,
    /// Variance of the mean over that of one reference.
    pub leverage: f64,
}

impl ReferenceResidual {
    /// Returns the alignment of the tracked path in `record` with the path of these references; none where the glass was
    /// not tracked, hardly moved, or travelled another path.
    pub(super) fn alignment(&self, record: &Record) -> Option<MotionAlignment> {
        let seen = &record.channels.iter().find(|c| c.quantity == Quantity::Place)?.value;
        let dt = record.interval_s;
        // Least squares of one factor at a delay, and the residual as a share of the path.
        let at = |late: f64| {
            let (mut cross, mut square, mut whole) = (0.0, 0.0, 0.0);
            for (frame, place) in seen.iter().enumerate().filter_map(|(f, p)| Some((f, (*p)?))) {
                let was = self.like.drive.at((frame as f64 - late) * dt).3;
                cross += was * place;
                square += was * was;
                whole += place * place;
            }
            let scale = cross / square;
            let left = (whole - scale * cross).max(0.0) / whole;
            (MotionAlignment { late, scale }, left.sqrt())
        };
        let most = (MAX_SHIFT_S / dt).ceil() as i32;
        let quarters = (-4 * most..=4 * most).map(|q| at(0.25 * f64::from(q)));
        let (coarse, _) = quarters.min_by(|a, b| a.1.total_cmp(&b.1))?;
        let fine = (-25..=25).map(|h| at(coarse.late + 0.01 * f64::from(h)));
        let (mut best, left) = fine.min_by(|a, b| a.1.total_cmp(&b.1))?;
        if best.late.abs() * dt < MIN_SHIFT_S {
            best.late = 0.0;
        }
        if best.scale.ln().abs() < MIN_LN_SCALE {
            best.scale = 1.0;
        }
        (left < MAX_PATH_RESIDUAL && best.scale > 0.0 && best.scale.ln().abs() < MAX_SCALE.ln())
            .then_some(best)
    }

    /// Returns the residual of a glass whose path is aligned by `by`; before the motion it is the residual at rest.
    pub(super) fn aligned(&self, by: MotionAlignment) -> Self {
        let mut out = self.clone();
        if by == (MotionAlignment { late: 0.0, scale: 1.0 }) {
            return out;
        }
        let shift = |series: &mut Vec<f64>| {
            let old = series.clone();
            let last = old.len().saturating_sub(1);
            for (frame, value) in series.iter_mut().enumerate() {
                let place = (frame as f64 - by.late).clamp(0.0, last as f64);
                let (low, part) = (place as usize, place.fract());
                *value = by.scale * (old[low] + part * (old[(low + 1).min(last)] - old[low]));
            }
        };
        out.mean.iter_mut().for_each(shift);
        out.scatter.iter_mut().flatten().for_each(shift);
        out
    }

    /// Smooths the scatter over five frames: its noise is in the noise already.
    pub(super) fn smooth(&mut self) {
        for series in self.scatter.iter_mut().flatten() {
            let rough = series.clone();
            for (f, x) in series.iter_mut().enumerate() {
                let near = &rough[f.saturating_sub(2)..(f + 3).min(rough.len())];
                *x = near.iter().sum::<f64>() / near.len() as f64;
            }
        }
    }

    /// Splits the residuals into their value at the viscosity `judged_pa_s` and the scatter about their line in ln mu.
    ///
    /// The scatter is scaled so that its sum of squares over one less than the references is the variance, whatever the
    /// slope has spent.
    pub(super) fn centred(mut self, judged_pa_s: f64) -> Self {
        let trend = ViscosityTrend::new(&self.viscosities_pa_s, judged_pa_s);
        self.leverage = trend.leverage();
        let frames = self.scatter.iter().map(|s| s[0].len()).min().unwrap_or(0);
        let scale = ((self.scatter.len() as f64 - 1.0) / trend.freedom()).max(1.0).sqrt();
        let channels = self.scatter[0].len();
        self.mean = vec![vec![0.0; frames]; channels];
        for channel in 0..channels {
            for frame in 0..frames {
                let numbers: Vec<f64> = self.scatter.iter().map(|s| s[channel][frame]).collect();
                let line = trend.split(&numbers);
                self.mean[channel][frame] = line.value;
                for (scatter, left) in self.scatter.iter_mut().zip(line.left) {
                    scatter[channel][frame] = scale * left;
                }
            }
            self.scatter.iter_mut().for_each(|scatter| scatter[channel].truncate(frames));
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recordings::motion_plan::MotionPlan;
    use crate::recordings::record::{Channel, Record};
    use crate::recordings::tables::drive_of;
    use meniscus::units::FRAME_INTERVAL_S;
    use meniscus_data::motion::Motion;

    /// A recording of a jolt of `strength` whose tracked glass moves `late_s` later and `scale` larger.
    fn record(strength: f64, late_s: f64, scale: f64) -> Record {
        let plan = MotionPlan::jolt(0.28, strength, 2.2);
        let drive = drive_of(&Motion::sampled(&plan.samples()).expect("a motion"), plan.seconds);
        let frames = plan.frames();
        let at = |n: usize| n as f64 * FRAME_INTERVAL_S;
        let place = (0..frames).map(|n| Some(scale * drive.at(at(n) - late_s).3)).collect();
        Record {
            name: "made up".into(),
            interval_s: FRAME_INTERVAL_S,
            channels: vec![Channel { quantity: Quantity::Place, value: place }],
            drive,
            rest_frames: 20,
        }
    }

    #[test]
    fn a_glass_on_the_same_path_is_found_later_and_larger_and_one_on_another_path_is_not() {
        let series: Vec<f64> = (0..132).map(|f| (0.1 * f as f64).sin()).collect();
        let residual = ReferenceResidual {
            like: record(1.25, 0.0, 1.0),
            mean: vec![series.clone()],
            scatter: vec![vec![series]],
            viscosities_pa_s: vec![0.2],
            leverage: 1.0,
        };
        for (late_s, scale) in [(0.0, 1.0), (0.033, 1.0), (-0.033, 1.0), (0.0, 1.08), (0.05, 0.93)] {
            let found = residual.alignment(&record(1.25, late_s, scale)).expect("the same path");
            assert!((found.late * FRAME_INTERVAL_S - late_s).abs() < 5e-4, "{found:?} for {late_s} s");
            assert!((found.scale - scale).abs() < 2e-3, "{found:?} for {scale}");
            let moved = residual.aligned(found);
            let wanted = found.scale * (0.1 * (60.0 - found.late)).sin();
            assert!((moved.mean[0][60] - wanted).abs() < 2e-3, "{} for {wanted}", moved.mean[0][60]);
        }
        assert_eq!(residual.alignment(&record(1.7, 0.0, 1.0)), None, "the next stronger jolt");
        let mut slow = record(1.25, 0.0, 1.0);
        let other = MotionPlan::jolt(0.40, 1.25, 2.2);
        let place = |n: usize| Some(other.position(n as f64 * FRAME_INTERVAL_S));
        slow.channels[0].value = (0..132).map(place).collect();
        assert_eq!(residual.alignment(&slow), None, "a slower jolt");
        let mut still = record(1.25, 0.0, 1.0);
        still.channels[0].value = vec![Some(0.0); 132];
        assert_eq!(residual.alignment(&still), None, "a glass that does not move");
    }
}
