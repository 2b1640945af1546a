//! Motions of piecewise constant jerk.
//!
//! ```text
//! x(t) = x0 + v0 t + a0 t^2/2 + sum_i j_i b_i(t)
//! b_i(t) = [ (t - i d)_+^3 - (t - (i+1) d)_+^3 ] / 6            d: time between two knots, ()_+ zero below zero
//! ```

use serde::{Deserialize, Serialize};

/// Position, speed and acceleration of a glass along x.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GlassState {
    /// Position, m.
    pub position_m: f64,
    /// Speed, m/s.
    pub speed_m_s: f64,
    /// Acceleration, m/s2.
    pub acceleration_m_s2: f64,
}

impl GlassState {
    /// A glass that rests at `position_m`.
    #[must_use]
    pub fn resting(position_m: f64) -> Self {
        Self { position_m, ..Self::default() }
    }

    /// The glass `time_s` later without jerk.
    #[must_use]
    pub fn drifted(&self, time_s: f64) -> Self {
        self.jerked(0.0, time_s)
    }

    /// The glass `time_s` later under a constant jerk.
    fn jerked(&self, jerk_m_s3: f64, time_s: f64) -> Self {
        let Self { position_m: x, speed_m_s: v, acceleration_m_s2: a } = *self;
        let (t, j) = (time_s, jerk_m_s3);
        Self {
            position_m: x + t * (v + t * (a / 2.0 + t * j / 6.0)),
            speed_m_s: v + t * (a + t * j / 2.0),
            acceleration_m_s2: a + t * j,
        }
    }
}

/// Parts of position, speed and acceleration for one jerk of unity between two knots.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Basis {
    pub(crate) position: f64,
    pub(crate) speed: f64,
    pub(crate) acceleration: f64,
}

/// Returns the parts at `time_s` of the jerk behind knot `index`, for knots `knot_s` apart.
pub(crate) fn basis(index: usize, knot_s: f64, time_s: f64) -> Basis {
    let since = (time_s - index as f64 * knot_s).max(0.0);
    let after = (since - knot_s).max(0.0);
    Basis {
        position: (since.powi(3) - after.powi(3)) / 6.0,
        speed: 0.5 * (since * since - after * after),
        acceleration: since - after,
    }
}

/// A motion from a state of the glass by piecewise constant jerk.
///
/// ```
/// use meniscus_plan::{Course, GlassState};
///
/// // Up for 0.1 s, down for 0.1 s: the acceleration is back at zero and the speed is 1 m/s.
/// let course = Course { start: GlassState::default(), knot_s: 0.1, jerks_m_s3: vec![100.0, -100.0] };
/// let end = course.at(course.duration_s() - 1e-9);
/// assert!(end.acceleration_m_s2.abs() < 1e-6 && (end.speed_m_s - 1.0).abs() < 1e-6);
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Course {
    /// The glass at time zero.
    pub start: GlassState,
    /// Time between two knots, s.
    pub knot_s: f64,
    /// Jerk behind each knot, m/s3.
    pub jerks_m_s3: Vec<f64>,
}

impl Course {
    /// Time of the last knot, s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.knot_s * self.jerks_m_s3.len() as f64
    }

    /// The glass at `time_s`; at rest at its end behind the last knot, and at its start before the first.
    #[must_use]
    pub fn at(&self, time_s: f64) -> GlassState {
        let mut along = self.along();
        along.to(time_s)
    }

    /// The glass at times that rise, in one pass over the knots.
    pub(crate) fn along(&self) -> Along<'_> {
        Along { course: self, knot: 0, state: self.start }
    }
}

/// A pass over the knots of a course.
#[derive(Clone, Debug)]
pub(crate) struct Along<'c> {
    course: &'c Course,
    /// Knot that has been passed, and the glass there.
    knot: usize,
    state: GlassState,
}

impl Along<'_> {
    /// The glass at `time_s`, which is no earlier than the time before.
    pub(crate) fn to(&mut self, time_s: f64) -> GlassState {
        let Course { knot_s, jerks_m_s3, .. } = self.course;
        let ends = time_s >= self.course.duration_s();
        let passed = if ends { jerks_m_s3.len() } else { (time_s.max(0.0) / knot_s) as usize };
        for jerk in jerks_m_s3.get(self.knot..passed).into_iter().flatten() {
            self.state = self.state.jerked(*jerk, *knot_s);
        }
        self.knot = self.knot.max(passed);
        match jerks_m_s3.get(self.knot) {
            Some(jerk) if !ends => self.state.jerked(*jerk, time_s.max(0.0) - self.knot as f64 * knot_s),
            _ => GlassState::resting(self.state.position_m),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sum over the basis, of which a program has its rows.
    #[test]
    fn a_pass_over_the_knots_is_the_sum_over_the_basis() {
        let start = GlassState { position_m: 0.1, speed_m_s: 0.2, acceleration_m_s2: -0.3 };
        let course = Course { start, knot_s: 0.04, jerks_m_s3: vec![30.0, -50.0, 10.0, 5.0] };
        let mut along = course.along();
        for n in 0..159 {
            let time_s = 0.001 * f64::from(n);
            let mut sum = start.drifted(time_s);
            for (index, jerk) in course.jerks_m_s3.iter().enumerate() {
                let part = basis(index, course.knot_s, time_s);
                sum.position_m += jerk * part.position;
                sum.speed_m_s += jerk * part.speed;
                sum.acceleration_m_s2 += jerk * part.acceleration;
            }
            for is in [along.to(time_s), course.at(time_s)] {
                assert!((is.position_m - sum.position_m).abs() < 1e-12, "{time_s}: {is:?} {sum:?}");
                assert!((is.speed_m_s - sum.speed_m_s).abs() < 1e-12, "{time_s}: {is:?} {sum:?}");
                assert!(
                    (is.acceleration_m_s2 - sum.acceleration_m_s2).abs() < 1e-12,
                    "{time_s}: {is:?} {sum:?}"
                );
            }
        }
    }

    #[test]
    fn speed_and_acceleration_are_derivatives() {
        let start = GlassState { position_m: 0.1, speed_m_s: 0.2, acceleration_m_s2: -0.3 };
        let course = Course { start, knot_s: 0.04, jerks_m_s3: vec![30.0, -50.0, 10.0, 5.0] };
        let h = 1e-5;
        for time_s in [0.01, 0.05, 0.1, 0.15] {
            let [before, now, after] = [time_s - h, time_s, time_s + h].map(|t| course.at(t));
            let speed = (after.position_m - before.position_m) / (2.0 * h);
            let acceleration = (after.speed_m_s - before.speed_m_s) / (2.0 * h);
            assert!((speed - now.speed_m_s).abs() < 1e-6, "{speed} {now:?}");
            assert!((acceleration - now.acceleration_m_s2).abs() < 1e-6, "{acceleration} {now:?}");
        }
        assert_eq!(course.at(-1.0), course.at(0.0));
        assert_eq!(course.at(9.0).speed_m_s, 0.0);
    }
}
