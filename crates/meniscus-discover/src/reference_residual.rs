//! What references leave in one motion: mean and scatter.
//!
//! What the reduced model is off by belongs to what the glass truly did, and that is what the camera saw it do. So
//! a recording is held against the references whose glass went the same way, be it later or by a factor: the
//! stated motion may be wrong, and that it is must not cost the references.

use super::record::{Quantity, Record};

/// Most by which a glass may be seen later or earlier than that of the references, s, and larger or smaller.
const MOST_LATE_S: f64 = 0.12;
const MOST_SCALE: f64 = 1.18;

/// What is left of the way of the glass where it is the same way, as a part of the way.
const SAME_WAY: f64 = 0.02;

/// A delay and a factor that are not told from none, s and 1: what a shorter shift changes is in the covariance.
const NO_DELAY_S: f64 = 0.003;
const NO_FACTOR: f64 = 0.01;

/// How the way of a glass lies to that of the references.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Way {
    /// How much later it is seen, frames.
    pub(super) late: f64,
    /// By what factor it is larger.
    pub(super) scale: f64,
}

/// What the references leave in one motion.
#[derive(Clone, Debug)]
pub struct Left {
    pub(super) like: Record,
    /// Mean, by channel and frame, m.
    pub mean: Vec<Vec<f64>>,
    /// Scatter about it, one for each reference, m.
    pub scatter: Vec<Vec<Vec<f64>>>,
}

impl Left {
    /// How the way of the glass that `record` shows lies to the one that these references were taken; none where
    /// the glass was not seen, hardly moved, or went another way.
    pub(super) fn seen_in(&self, record: &Record) -> Option<Way> {
        let seen = &record.channels.iter().find(|c| c.quantity == Quantity::Place)?.value;
        let dt = record.interval_s;
        // Least squares of one factor at a delay, and what is left as a part of the way.
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
            (Way { late, scale }, left.sqrt())
        };
        let most = (MOST_LATE_S / dt).ceil() as i32;
        let quarters = (-4 * most..=4 * most).map(|q| at(0.25 * f64::from(q)));
        let (coarse, _) = quarters.min_by(|a, b| a.1.total_cmp(&b.1))?;
        let fine = (-25..=25).map(|h| at(coarse.late + 0.01 * f64::from(h)));
        let (mut way, left) = fine.min_by(|a, b| a.1.total_cmp(&b.1))?;
        if way.late.abs() * dt < NO_DELAY_S {
            way.late = 0.0;
        }
        if way.scale.ln().abs() < NO_FACTOR {
            way.scale = 1.0;
        }
        (left < SAME_WAY && way.scale > 0.0 && way.scale.ln().abs() < MOST_SCALE.ln()).then_some(way)
    }

    /// What they leave of a glass that goes their way later and larger; before it begins, what they leave at rest.
    pub(super) fn moved(&self, way: Way) -> Self {
        let mut out = self.clone();
        if way == (Way { late: 0.0, scale: 1.0 }) {
            return out;
        }
        let shift = |series: &mut Vec<f64>| {
            let old = series.clone();
            let last = old.len().saturating_sub(1);
            for (frame, value) in series.iter_mut().enumerate() {
                let place = (frame as f64 - way.late).clamp(0.0, last as f64);
                let (low, part) = (place as usize, place.fract());
                *value = way.scale * (old[low] + part * (old[(low + 1).min(last)] - old[low]));
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

    /// Splits what the references leave into mean and scatter.
    pub(super) fn centred(mut self) -> Self {
        let frames = self.scatter.iter().map(|s| s[0].len()).min().unwrap_or(0);
        let groups = self.scatter.len() as f64;
        let channels = self.scatter[0].len();
        self.mean = (0..channels)
            .map(|c| {
                (0..frames).map(|f| self.scatter.iter().map(|s| s[c][f]).sum::<f64>() / groups).collect()
            })
            .collect();
        for scatter in &mut self.scatter {
            for (series, mean) in scatter.iter_mut().zip(&self.mean) {
                series.truncate(frames);
                series.iter_mut().zip(mean).for_each(|(x, m)| *x -= m);
            }
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::super::record::{Channel, Record};
    use super::*;
    use crate::motion_table::drive_of;
    use crate::study::motion_plans::Course;
    use meniscus::units::FRAME_INTERVAL_S;
    use meniscus_data::motion::Motion;

    /// A recording of a jolt of `strength` whose glass is seen `late_s` later and `scale` larger.
    fn record(strength: f64, late_s: f64, scale: f64) -> Record {
        let course = Course::jolt(0.28, strength, 2.2);
        let drive = drive_of(&Motion::sampled(&course.samples()).expect("a motion"), course.seconds);
        let frames = course.frames();
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
    fn a_glass_that_went_the_same_way_is_found_later_and_larger_and_another_way_is_not() {
        let series: Vec<f64> = (0..132).map(|f| (0.1 * f as f64).sin()).collect();
        let left =
            Left { like: record(1.25, 0.0, 1.0), mean: vec![series.clone()], scatter: vec![vec![series]] };
        for (late_s, scale) in [(0.0, 1.0), (0.033, 1.0), (-0.033, 1.0), (0.0, 1.08), (0.05, 0.93)] {
            let way = left.seen_in(&record(1.25, late_s, scale)).expect("the same way");
            assert!((way.late * FRAME_INTERVAL_S - late_s).abs() < 5e-4, "{way:?} for {late_s} s");
            assert!((way.scale - scale).abs() < 2e-3, "{way:?} for {scale}");
            let moved = left.moved(way);
            let wanted = way.scale * (0.1 * (60.0 - way.late)).sin();
            assert!((moved.mean[0][60] - wanted).abs() < 2e-3, "{} for {wanted}", moved.mean[0][60]);
        }
        assert_eq!(left.seen_in(&record(1.7, 0.0, 1.0)), None, "the next stronger jolt");
        let mut slow = record(1.25, 0.0, 1.0);
        let other = Course::jolt(0.40, 1.25, 2.2);
        let place = |n: usize| Some(other.position(n as f64 * FRAME_INTERVAL_S));
        slow.channels[0].value = (0..132).map(place).collect();
        assert_eq!(left.seen_in(&slow), None, "a slower jolt");
        let mut still = record(1.25, 0.0, 1.0);
        still.channels[0].value = vec![Some(0.0); 132];
        assert_eq!(left.seen_in(&still), None, "a glass that does not move");
    }
}
