//! The shortest duration whose motion keeps the limits of the surface by the forecast of the whole model.
//!
//! ```text
//! r(T) = (highest bound of the forecast) / limit          of the motion of the lowest crest that takes T
//! T:   r(T) = 1,   bracketed, and found by interpolation in log r over log T
//! ```
//! r falls with the duration, r ~ 1/T^2 for a slow surface. Each program starts from what the forecast before it lacked. So the
//! second order settles while the bracket closes, and no duration is judged by another motion's forecast.

use crate::PlanError;
use crate::course::Course;
use crate::models::SurfaceModel;
use crate::search::{LONGEST_S, Plan, Search, frames_of};
use crate::verify::Used;

/// Relative width of the bracket at which the search ends.
const TOLERANCE: f64 = 0.004;

/// Part of the limit above which a bound counts as at the limit.
const NEAR: f64 = 0.985;

/// Durations that are tried.
const TRIES: usize = 24;

/// Durations between which the answer lies.
#[derive(Debug)]
struct Bracket {
    /// Longest duration that is too short, s, and its r where there is one: the robot alone may need longer.
    low_s: f64,
    above: Option<f64>,
    /// Shortest duration that keeps the limits, s, with its r.
    high: Option<(f64, f64)>,
}

impl Bracket {
    /// Takes a duration with its r; `None` where the robot cannot do it.
    fn take(&mut self, duration_s: f64, ratio: Option<f64>, keeps: bool) {
        match ratio {
            Some(ratio) if keeps => self.high = Some((duration_s, ratio)),
            _ => (self.low_s, self.above) = (duration_s, ratio.filter(|ratio| *ratio > 1.0)),
        }
    }

    /// The next duration to try; `None` where the answer is known.
    fn next_s(&self) -> Option<f64> {
        let Some((high_s, below)) = self.high else {
            // r falls with 1/T^2 where the surface is slow, and less where the present slosh is the crest.
            return Some(self.low_s * self.above.map_or(1.15, |ratio| ratio.sqrt().clamp(1.02, 1.6)));
        };
        if below > NEAR || high_s <= self.low_s * (1.0 + TOLERANCE) {
            return None;
        }
        let (low, top, below) = (self.low_s.ln(), high_s.ln(), below.max(1e-3).ln());
        let share = match self.above {
            Some(ratio) => (ratio.ln() / (ratio.ln() - below)).clamp(0.1, 0.95),
            // No crest is known at the lower end: by r ~ 1/T^2 from the upper one.
            None => ((top + 0.5 * below - low) / (top - low)).clamp(0.1, 0.9),
        };
        Some((low + share * (top - low)).exp())
    }
}

impl<M: SurfaceModel> Search<'_, M> {
    /// The shortest motion whose forecast keeps the limits.
    pub(crate) fn fastest_verified(&mut self) -> Result<Plan, PlanError> {
        let limit_m = self.request.limit_m;
        let distance_m = (self.request.to_m - self.departure.glass.position_m).abs();
        let least_s = self.request.limits.shortest_s(distance_m);
        let still_s = 2.0 * (distance_m * self.model.static_m() / limit_m).sqrt();
        let mut duration_s = f64::max(1.02 * least_s, 1.1 * still_s).min(0.8 * LONGEST_S);
        let mut correction = self.free(frames_of(duration_s));
        let mut bracket = Bracket { low_s: least_s, above: None, high: None };
        let mut best: Option<Plan> = None;
        let mut nearby: Option<Course> = None;
        let mut lowest_m = f64::NAN;
        for _ in 0..TRIES {
            let settled = self.settled(duration_s, &mut correction, nearby.as_ref())?;
            let used = settled.as_ref().map(|plan| self.used(plan));
            let keeps = used.is_some_and(Used::keeps);
            bracket.take(duration_s, used.map(Used::ratio), keeps);
            nearby = settled.as_ref().map(|plan| plan.course.clone()).or(nearby);
            lowest_m = settled.as_ref().map_or(lowest_m, |plan| plan.bound_m.min(lowest_m));
            if keeps {
                best = settled;
            }
            match bracket.next_s() {
                Some(next_s) if next_s <= LONGEST_S => duration_s = next_s,
                _ => break,
            }
        }
        let longest_s = duration_s.min(LONGEST_S);
        best.ok_or(PlanError::Infeasible { longest_s, crest_m: lowest_m, limit_m })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Searches r(T), and returns the duration with the number of tries.
    fn search(least_s: f64, first_s: f64, ratio: impl Fn(f64) -> Option<f64>) -> (f64, usize) {
        let mut bracket = Bracket { low_s: least_s, above: None, high: None };
        let mut duration_s = first_s;
        for tries in 1..=TRIES {
            let r = ratio(duration_s);
            bracket.take(duration_s, r, r.is_some_and(|r| r <= 1.0));
            match bracket.next_s() {
                Some(next_s) => duration_s = next_s,
                None => return (bracket.high.expect("a duration").0, tries),
            }
        }
        panic!("{bracket:?}")
    }

    /// Curves with a known root: a power of T, one that is flat at first, and one that steps down.
    #[test]
    fn the_root_of_a_known_curve_is_found_in_few_tries() {
        for first_s in [0.5, 1.0, 3.0] {
            for power in [0.7, 2.0, 6.0] {
                let (found_s, tries) = search(0.4, first_s, |t| Some((1.2_f64 / t).powf(power)));
                assert!((1.0..1.03).contains(&(found_s / 1.2)), "{found_s} s from {first_s}, power {power}");
                assert!(tries <= 12, "{tries} tries from {first_s}, power {power}");
            }
            let (found_s, _) = search(0.4, first_s, |t| Some(if t < 1.2 { 1.3 } else { 0.9 }));
            assert!((1.0..=1.0 + TOLERANCE).contains(&(found_s / 1.2)), "{found_s}");
        }
    }

    /// Where the surface is no limit, the shortest duration is that of the robot.
    #[test]
    fn a_robot_alone_sets_the_duration() {
        let (found_s, _) = search(0.8, 0.816, |t| (t >= 0.8).then_some(0.01));
        assert!((1.0..=1.0 + TOLERANCE).contains(&(found_s / 0.8)), "{found_s}");
        let (found_s, _) = search(0.8, 0.816, |t| (t >= 0.83).then_some(0.01));
        assert!((1.0..=1.0 + TOLERANCE).contains(&(found_s / 0.83)), "{found_s}");
    }
}
