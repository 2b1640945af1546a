//! Motions that others use, for comparison.
//!
//! ```text
//! minimum jerk   x = D (10 s^3 - 15 s^4 + 6 s^5),  s = t/T                                Flash and Hogan 1985
//! trapezoid      speed rises for T/3, holds for T/3, falls for T/3
//! input shaping  A1 x(t) + A2 x(t - t2),  A1 = 1/(1+K), A2 = K/(1+K),  K = exp(-zeta pi / sqrt(1 - zeta^2)),
//!                t2 = pi / (w sqrt(1 - zeta^2))                                           Singer and Seering 1990, ZV
//! pendulum       the program of this crate with one linear pendulum and no half-width      after Muchacho et al. 2022
//! ```

use crate::PlanError;
use crate::course::{Course, GlassState};
use crate::models::Pendulum;
use crate::request::Request;
use crate::search::smoothest;

/// A motion from rest to rest.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    /// Its name.
    pub name: &'static str,
    /// Duration, s.
    pub duration_s: f64,
    from_m: f64,
    distance_m: f64,
    kind: Kind,
}

#[derive(Clone, Debug, PartialEq)]
enum Kind {
    MinimumJerk,
    Trapezoid,
    Shaped { delay_s: f64, late: f64 },
    Planned(Course),
}

impl Motion {
    /// The glass at `time_s`. Speed and acceleration are differences of the position over 20 us and 0.2 ms.
    #[must_use]
    pub fn at(&self, time_s: f64) -> GlassState {
        if let Kind::Planned(course) = &self.kind {
            return course.at(time_s);
        }
        let place = |time_s: f64| self.from_m + self.distance_m * self.share(time_s);
        let slope = |h: f64| (place(time_s + h) - place(time_s - h)) / (2.0 * h);
        let h = 1e-4;
        let bend = (place(time_s + h) - 2.0 * place(time_s) + place(time_s - h)) / (h * h);
        GlassState { position_m: place(time_s), speed_m_s: slope(1e-5), acceleration_m_s2: bend }
    }

    /// Share of the distance at `time_s`.
    fn share(&self, time_s: f64) -> f64 {
        match &self.kind {
            Kind::MinimumJerk => {
                let s = (time_s / self.duration_s).clamp(0.0, 1.0);
                s * s * s * (10.0 + s * (6.0 * s - 15.0))
            }
            Kind::Trapezoid => trapezoid_share(time_s / self.duration_s),
            Kind::Shaped { delay_s, late } => {
                let duration_s = self.duration_s - delay_s;
                (1.0 - late) * trapezoid_share(time_s / duration_s)
                    + late * trapezoid_share((time_s - delay_s) / duration_s)
            }
            Kind::Planned(_) => 0.0,
        }
    }
}

/// Share of the distance of a trapezoid at share `s` of its duration.
fn trapezoid_share(s: f64) -> f64 {
    let s = s.clamp(0.0, 1.0);
    if s < 1.0 / 3.0 {
        2.25 * s * s
    } else if s < 2.0 / 3.0 {
        0.25 + 1.5 * (s - 1.0 / 3.0)
    } else {
        1.0 - 2.25 * (1.0 - s) * (1.0 - s)
    }
}

/// The motion of minimum jerk.
#[must_use]
pub fn minimum_jerk(from_m: f64, to_m: f64, duration_s: f64) -> Motion {
    Motion { name: "minimum jerk", duration_s, from_m, distance_m: to_m - from_m, kind: Kind::MinimumJerk }
}

/// The trapezoid of speed with three equal phases.
#[must_use]
pub fn trapezoid(from_m: f64, to_m: f64, duration_s: f64) -> Motion {
    Motion { name: "trapezoid", duration_s, from_m, distance_m: to_m - from_m, kind: Kind::Trapezoid }
}

/// A shorter trapezoid, shaped on `mode`; `None` where the shaper alone takes more
/// than two thirds of the duration.
#[must_use]
pub fn shaped(from_m: f64, to_m: f64, duration_s: f64, mode: &Pendulum) -> Option<Motion> {
    let (w, zeta) = (mode.frequency, mode.damping);
    let root = (1.0 - zeta * zeta).sqrt();
    let k = (-zeta * std::f64::consts::PI / root).exp();
    let delay_s = std::f64::consts::PI / (w * root);
    let kind = Kind::Shaped { delay_s, late: k / (1.0 + k) };
    let motion = Motion { name: "input shaping", duration_s, from_m, distance_m: to_m - from_m, kind };
    (delay_s < 2.0 / 3.0 * duration_s).then_some(motion)
}

/// The motion that is best for a linear pendulum.
///
/// # Errors
/// As for [`smoothest`].
pub fn pendulum(
    pendulum: &Pendulum,
    from_m: f64,
    request: &Request,
    duration_s: f64,
) -> Result<Motion, PlanError> {
    let plan = smoothest(pendulum, &[0.0; 2], from_m, request, duration_s)?;
    let (distance_m, kind) = (request.to_m - from_m, Kind::Planned(plan.course));
    Ok(Motion { name: "pendulum", duration_s, from_m, distance_m, kind })
}

#[cfg(test)]
mod tests {
    use super::*;

    const MODE: Pendulum = Pendulum { frequency: 22.0, damping: 0.05, radius_m: 0.035, room_m: 0.04 };

    #[test]
    fn every_rival_goes_from_rest_to_rest() {
        let shaped = shaped(0.1, 0.4, 0.9, &MODE).expect("0.14 s of 0.9");
        for motion in [minimum_jerk(0.1, 0.4, 0.9), trapezoid(0.1, 0.4, 0.9), shaped] {
            let (start, end) = (motion.at(0.0), motion.at(0.9));
            assert!((start.position_m - 0.1).abs() < 1e-12, "{motion:?}");
            assert!((end.position_m - 0.4).abs() < 1e-9, "{motion:?}");
            assert!(start.speed_m_s.abs() + end.speed_m_s.abs() < 1e-4, "{motion:?}");
        }
        assert!((minimum_jerk(0.0, 1.0, 1.0).at(0.5).speed_m_s - 1.875).abs() < 1e-6);
    }

    /// The shaper cancels what it was made for: a pendulum of that mode rests behind it.
    #[test]
    fn a_shaped_motion_leaves_its_mode_at_rest() {
        use crate::models::SurfaceModel;
        use crate::response::inputs_of;
        let residual = |motion: &Motion| {
            let inputs = inputs_of(Pendulum::INPUT, 0.0, 80, |t| motion.at(t));
            let frames = MODE.forecast(&[0.0; 2], &inputs);
            frames[55..].iter().map(|frame| frame.crest_m()).fold(0.0, f64::max)
        };
        let plain = residual(&trapezoid(0.0, 0.3, 0.75));
        let with = residual(&shaped(0.0, 0.3, 0.9, &MODE).expect("it fits"));
        assert!(with < 0.15 * plain, "{with} for {plain}");
    }
}
