//! Share of the contact line that a sticking wall holds, from references.
//!
//! A wall that holds the line damps the first mode more and lowers its frequency less than one on which the line slides. A factor d
//! on the damping and an offset f of the frequency can stand for either. But the factor also scales the damping of every effect,
//! so that a slip, a yield stress or a shear thinning gets a wrong size. So the share h is the one with which the references need
//! the least factors,
//! ```text
//! sum over references of (ln d)^2/sd^2 + f^2/sf^2,    plus (1 - h)^2/sh^2,    0 <= h <= 1
//! ```
//! d and f at another h are those that keep damping and frequency; both are nearly straight lines in h.

use super::group::Group;
use super::predict::{DAMPING, FREQUENCY, HELD_LINE, SHARED, reduced_model};
use meniscus::units::FRAME_INTERVAL_S;

/// Errors sd and sf that the theory of a sticking wall leaves: a tenth of the damping, and a hundredth of the frequency.
const DAMPING_ERROR: f64 = 0.1;
const FREQUENCY_ERROR: f64 = 0.01;

/// Standard deviation sh of the share about 1. In a thin layer references show nothing of it.
const SHARE_DEVIATION: f64 = 1.0;

/// Repetitions by which the numbers at another share are found.
const REPEATS: usize = 4;

/// Share of the contact line that is held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct HeldLine {
    /// The share.
    share: f64,
}

impl HeldLine {
    /// Returns the share with which `groups` need the least factors on damping and frequency.
    pub(super) fn of(groups: &[&Group]) -> Self {
        let (mut square, mut product) = (SHARE_DEVIATION.powi(-2), 0.0);
        for group in groups {
            let held = in_errors(&group.theta);
            let free = in_errors(&Self { share: 0.0 }.numbers(group));
            for (held, free) in held.into_iter().zip(free) {
                square += (free - held).powi(2);
                product -= held * (free - held);
            }
        }
        Self { share: 1.0 - (product / square).clamp(0.0, 1.0) }
    }

    /// Returns the shared numbers of `group` at this share: its recordings are predicted as before.
    pub(super) fn numbers(self, group: &Group) -> Vec<f64> {
        let mut theta = group.theta[..SHARED].to_vec();
        let first = |theta: &[f64]| {
            reduced_model(&group.known, theta, &[], FRAME_INTERVAL_S).frequency_and_damping(0)
        };
        let Some((frequency, damping)) = first(&theta) else { return theta };
        theta[HELD_LINE] = self.share;
        for _ in 0..REPEATS {
            let Some((now, damped)) = first(&theta) else { break };
            theta[FREQUENCY] += (frequency - now) / frequency;
            theta[DAMPING] += (damping / damped).ln();
        }
        theta
    }
}

/// Returns factor and offset of `theta` in their errors.
fn in_errors(theta: &[f64]) -> [f64; 2] {
    [theta[DAMPING] / DAMPING_ERROR, theta[FREQUENCY] / FREQUENCY_ERROR]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::baseline::calibrate::Calibration;
    use crate::recordings::stated::{CALLIPERS_M, Known};

    /// A reference that was fitted with a held line, although a `share` of it is held and all is damped by a factor of `damped` more.
    fn reference(viscosity_pa_s: f64, share: f64, damped: f64) -> Group {
        let known = Known {
            radius_m: 0.04,
            radius_error_m: CALLIPERS_M,
            fill_m: 0.08,
            density_kg_m3: 1200.0,
            viscosity_pa_s,
            motion_share: [1.0; 2],
        };
        let mut theta = Calibration::blind(&[], 0.0).mean.to_vec();
        theta[DAMPING] = f64::ln(damped);
        theta[HELD_LINE] = share;
        let truth = Group {
            known,
            records: Vec::new(),
            split: crate::recordings::split::Split::of(&[]),
            theta,
            residual_m: Vec::new(),
        };
        let theta = HeldLine { share: 1.0 }.numbers(&truth);
        Group { theta, ..truth }
    }

    #[test]
    fn references_show_how_much_of_the_line_is_held() {
        for (share, damped) in [(1.0, 1.0), (0.4, 1.0), (0.0, 1.0), (0.4, 1.03)] {
            let groups = [0.05, 0.1, 0.2].map(|mu| reference(mu, share, damped));
            let found = HeldLine::of(&groups.iter().collect::<Vec<_>>());
            assert!((found.share - share).abs() < 0.15, "{found:?} for {share}");
            // The factors that stood for the line are gone.
            let numbers = HeldLine { share }.numbers(&groups[0]);
            assert!(
                (numbers[DAMPING] - damped.ln()).abs() < 2e-3 && numbers[FREQUENCY].abs() < 2e-4,
                "{numbers:?}"
            );
        }
    }

    #[test]
    fn a_thin_layer_and_no_reference_leave_the_line_held() {
        assert_eq!(HeldLine::of(&[]), HeldLine { share: 1.0 });
        // Water whose film doubles the damping.
        let water = reference(1e-3, 1.0, 2.0);
        assert_eq!(HeldLine::of(&[&water]), HeldLine { share: 1.0 });
    }
}
