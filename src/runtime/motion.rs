//! The acceleration of the glass from its tracked position.
//!
//! With positions X at frame numbers t0 < t1 < t2 (frames may be missing between them):
//!
//! ```text
//! a = 2 / (t2 - t0) [ (X2 - X1) / (t2 - t1) - (X1 - X0) / (t1 - t0) ]
//! ```
//! the second divided difference; for consecutive frames (X2 - 2 X1 + X0) / dt^2.

use crate::units::FRAME_INTERVAL_S;

/// Frames for which the last acceleration stands in for one that could not be measured; after that nothing is known
/// of it.
pub(super) const CARRY_FRAMES: u32 = 2;

/// The last two positions and the last acceleration.
#[derive(Clone, Copy, Debug, Default)]
pub struct Motion {
    /// Frames ago and position, newest first.
    last: [Option<(u32, f64)>; 2],
    acceleration: f64,
    carried: u32,
}

impl Motion {
    /// Takes this frame's glass position (if the glass was seen) and gives the acceleration, m/s2.
    pub fn update(&mut self, position_m: Option<f64>) -> f64 {
        for (age, _) in self.last.iter_mut().flatten() {
            *age = age.saturating_add(1);
        }
        match (position_m, self.last) {
            (Some(x2), [Some((age1, x1)), Some((age0, x0))]) => {
                let (late, early) = (frames_s(age1), frames_s(age0.saturating_sub(age1)));
                self.acceleration = 2.0 / (late + early) * ((x2 - x1) / late - (x1 - x0) / early);
                self.carried = 0;
            }
            _ => {
                self.carried = self.carried.saturating_add(1);
                if self.carried > CARRY_FRAMES {
                    self.acceleration = 0.0;
                }
            }
        }
        if let Some(x) = position_m {
            let [newest, _] = self.last;
            self.last = [Some((0, x)), newest];
        }
        self.acceleration
    }
}

/// Frames to seconds; never zero, as two positions never share a frame.
fn frames_s(frames: u32) -> f64 {
    f64::from(frames.max(1)) * FRAME_INTERVAL_S
}

#[cfg(test)]
mod tests {
    use super::*;

    /// X(t) = 0.1 + 0.2 t + 1.5 t^2 has the acceleration 3 at any spacing.
    fn position(frame: u32) -> f64 {
        let t = f64::from(frame) * FRAME_INTERVAL_S;
        0.1 + 0.2 * t + 1.5 * t * t
    }

    #[test]
    fn a_parabola_has_its_acceleration_even_across_a_gap() {
        let mut motion = Motion::default();
        assert_eq!(motion.update(Some(position(0))), 0.0);
        assert_eq!(motion.update(Some(position(1))), 0.0);
        assert!((motion.update(Some(position(2))) - 3.0).abs() < 1e-9);
        assert!((motion.update(None) - 3.0).abs() < 1e-9, "carried over");
        assert!((motion.update(Some(position(4))) - 3.0).abs() < 1e-9, "uneven spacing");
        assert!((motion.update(Some(position(5))) - 3.0).abs() < 1e-9);
    }

    #[test]
    fn an_unseen_glass_ends_as_evenly_moving() {
        let mut motion = Motion::default();
        for frame in 0..3 {
            motion.update(Some(position(frame)));
        }
        let after: [f64; 3] = core::array::from_fn(|_| motion.update(None));
        assert!(after[0] > 2.9 && after[1] > 2.9);
        assert_eq!(after[2], 0.0);
    }
}
