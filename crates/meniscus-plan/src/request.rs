//! A request: the distance, the limits and the confidence.

use crate::PlanError;
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, Normal};

/// One-sided confidence that the half-widths of a forecast have: they hold nine times out of ten on both sides.
const STATED: f64 = 0.95;

/// Limits of the robot; each is the same in both directions.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Limits {
    /// Speed, m/s.
    pub speed_m_s: f64,
    /// Acceleration, m/s2.
    pub acceleration_m_s2: f64,
    /// Jerk, m/s3.
    pub jerk_m_s3: f64,
}

impl Default for Limits {
    /// A table-top robot arm of moderate speed.
    fn default() -> Self {
        Self { speed_m_s: 1.5, acceleration_m_s2: 5.0, jerk_m_s3: 60.0 }
    }
}

impl Limits {
    /// Shortest time of a move over `distance_m` from rest to rest without a limit of the surface, s.
    ///
    /// ```text
    /// T = D/v + v/a + a/j          with v, a the largest that are reached: the seven phases of a jerk-limited move
    /// ```
    /// (Biagiotti and Melchiorri, Trajectory Planning for Automatic Machines and Robots, 2008, section 3.4.)
    ///
    /// ```
    /// use meniscus_plan::Limits;
    ///
    /// // So short that neither speed nor acceleration is reached: T = (32 D / j)^(1/3).
    /// let limits = Limits { speed_m_s: 1.0, acceleration_m_s2: 10.0, jerk_m_s3: 100.0 };
    /// assert!((limits.shortest_s(0.01) - (0.32_f64 / 100.0).cbrt()).abs() < 1e-9);
    /// ```
    #[must_use]
    pub fn shortest_s(&self, distance_m: f64) -> f64 {
        let Self { speed_m_s: v, acceleration_m_s2: a, jerk_m_s3: j } = *self;
        let distance = distance_m.abs();
        // Time and distance to reach a speed from rest, and the greatest speed on it.
        let rise = |speed: f64| if speed * j >= a * a { speed / a + a / j } else { 2.0 * (speed / j).sqrt() };
        if speed_distance(v, rise(v)) <= distance {
            return distance / v + rise(v);
        }
        let (mut low, mut high) = (0.0, v);
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            if speed_distance(middle, rise(middle)) < distance { low = middle } else { high = middle }
        }
        2.0 * rise(high)
    }
}

/// Distance of a move that reaches `speed` in `rise_s` and brakes at once, m.
fn speed_distance(speed: f64, rise_s: f64) -> f64 {
    speed * rise_s
}

/// A move from rest to rest along x, and what it must keep.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Request {
    /// Position of the glass at the end, m.
    pub to_m: f64,
    /// Limits of the robot.
    pub limits: Limits,
    /// Highest that the surface may stand over the liquid at rest, m.
    pub limit_m: f64,
    /// Chance that the crest stays below the limit.
    pub confidence: f64,
    /// Highest that the surface may stand after arrival, m; the limit itself where there is none.
    pub residual_m: Option<f64>,
}

impl Request {
    /// Refuses what cannot be meant, for a start at `from_m`.
    ///
    /// # Errors
    /// [`PlanError::Range`] with the first number that is out of its range.
    pub fn check(&self, from_m: f64) -> Result<(), PlanError> {
        let range = |name, value: f64, unit, [least, most]: [f64; 2]| {
            let allowed = format!("{least} to {most}");
            if (least..=most).contains(&value) {
                Ok(())
            } else {
                Err(PlanError::Range { name, value, unit, allowed })
            }
        };
        range("the start", from_m, "m", [-10.0, 10.0])?;
        range("the goal", self.to_m, "m", [-10.0, 10.0])?;
        range("the distance", (self.to_m - from_m).abs(), "m", [0.001, 5.0])?;
        range("the limit of the crest", 1e3 * self.limit_m, "mm", [0.1, 100.0])?;
        range("the confidence", self.confidence, "", [0.5, 0.999])?;
        range("the largest speed", self.limits.speed_m_s, "m/s", [0.01, 10.0])?;
        range("the largest acceleration", self.limits.acceleration_m_s2, "m/s2", [0.05, 30.0])?;
        range("the largest jerk", self.limits.jerk_m_s3, "m/s3", [0.5, 20_000.0])?;
        if let Some(residual_m) = self.residual_m {
            range("the limit after arrival", 1e3 * residual_m, "mm", [0.05, 1e3 * self.limit_m])?;
        }
        Ok(())
    }

    /// Factor on the half-widths of a forecast at the stated confidence: a ratio of normal quantiles, 1 at 0.95.
    #[must_use]
    pub fn widening(&self) -> f64 {
        let normal = Normal::standard();
        normal.inverse_cdf(self.confidence) / normal.inverse_cdf(STATED)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const REQUEST: Request = Request {
        to_m: 0.3,
        limits: Limits { speed_m_s: 1.0, acceleration_m_s2: 4.0, jerk_m_s3: 80.0 },
        limit_m: 0.006,
        confidence: 0.95,
        residual_m: None,
    };

    /// Seven phases summed by hand: with speed and acceleration reached, T = D/v + v/a + a/j.
    #[test]
    fn the_shortest_time_is_the_textbook_s() {
        let limits = REQUEST.limits;
        assert!((limits.shortest_s(1.0) - (1.0 + 0.25 + 0.05)).abs() < 1e-12);
        // Acceleration reached, speed not: D = v (v/a + a/j), T = 2 (v/a + a/j).
        let v: f64 = 0.5;
        let distance = v * (v / 4.0 + 0.05);
        assert!((limits.shortest_s(distance) - 2.0 * (v / 4.0 + 0.05)).abs() < 1e-9);
    }

    #[test]
    fn absurd_requests_are_refused_with_their_value() {
        let cases = [
            (Request { to_m: 0.0, ..REQUEST }, "distance = 0 m"),
            (Request { to_m: f64::NAN, ..REQUEST }, "goal = NaN m"),
            (Request { limit_m: -0.001, ..REQUEST }, "crest = -1 mm"),
            (Request { confidence: 1.0, ..REQUEST }, "confidence = 1"),
            (Request { residual_m: Some(0.02), ..REQUEST }, "arrival = 20 mm"),
        ];
        for (request, part) in cases {
            let why = request.check(0.0).expect_err(part).to_string();
            assert!(why.contains(part) && why.contains("out of range: "), "{why}");
        }
        let slow = Request { limits: Limits { speed_m_s: 0.0, ..REQUEST.limits }, ..REQUEST };
        assert!(slow.check(0.0).is_err());
        assert!(REQUEST.check(0.0).is_ok());
    }

    #[test]
    fn a_confidence_widens_by_quantiles() {
        assert!((REQUEST.widening() - 1.0).abs() < 1e-12);
        assert!(Request { confidence: 0.5, ..REQUEST }.widening().abs() < 1e-9);
        let sure = Request { confidence: 0.99, ..REQUEST }.widening();
        assert!((sure - 2.3263 / 1.6449).abs() < 1e-3, "{sure}");
    }
}
