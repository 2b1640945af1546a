//! The linear baseline: what the motion of the glass alone says of the surface, by the best linear
//! model there can be.
//!
//! ```text
//! z_i(n) = z_rest + sum_k w_ik a(n - k),   k = 0 .. TAPS - 1
//! ```
//! a finite impulse response for each profile point, fitted by least squares to the very recording on
//! which it is judged, with the true acceleration. It sees no surface and needs no camera; it is
//! flattered twice, by the true motion and by being fitted in place, so that beating it means something.

use meniscus::surface::POINTS;
use meniscus_data::recording::Recording;
use nalgebra::{Cholesky, DMatrix};

/// Frames that the response reaches back: 0.75 s, five times the decay time of glycerine.
const TAPS: usize = 45;

/// Ridge relative to the mean square of the acceleration, so that a still glass has a solution too.
const RIDGE: f64 = 1e-6;

/// The profiles of the baseline; frames x [`POINTS`], metres.
#[must_use]
pub fn linear_with_motion(recording: &Recording) -> Vec<f32> {
    let frames = recording.frames();
    let rest = recording.glass.fill_m;
    let a = &recording.acceleration_m_s2;
    let history = DMatrix::from_fn(frames, TAPS, |frame, tap| frame.checked_sub(tap).map_or(0.0, |n| a[n]));
    let target =
        DMatrix::from_fn(frames, POINTS, |frame, point| f64::from(recording.profile(frame)[point]) - rest);
    let mut normal = history.tr_mul(&history);
    let ridge = RIDGE * normal.trace() / TAPS as f64 + f64::MIN_POSITIVE;
    for tap in 0..TAPS {
        normal[(tap, tap)] += ridge;
    }
    let response = Cholesky::new(normal).map(|factor| factor.solve(&history.tr_mul(&target)));
    // Without a solution (a glass that never moves) the best linear model is the flat surface.
    let fitted = response.map_or_else(|| DMatrix::zeros(frames, POINTS), |response| history * response);
    let heights = (0..frames).flat_map(|frame| (0..POINTS).map(move |point| (frame, point)));
    heights.map(|at| (rest + fitted[at]) as f32).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus::blob::{FieldGroup, KnownGroups};
    use meniscus_data::glass::WallShape;
    use meniscus_data::recording::{EnergyBook, Glass, Provenance, States};

    /// A recording whose surface is exactly a linear response to its motion.
    fn recording(acceleration: Vec<f64>, answer: impl Fn(usize) -> f64) -> Recording {
        let frames = acceleration.len();
        let profile = (0..frames).flat_map(|n| [(0.07 + answer(n)) as f32; POINTS]).collect();
        Recording {
            glass: Glass { radius_m: 0.035, fill_m: 0.07, rim_m: 0.11, wall: WallShape::UPRIGHT },
            provenance: Provenance {
                liquid: "test".into(),
                density_kg_m3: 1000.0,
                motion: "test".into(),
                seed: 0,
                command: String::new(),
                spacing_m: 0.005,
                pivot_m: [0.0; 2],
                effects: vec![],
            },
            glass_x_m: vec![0.0; frames],
            glass_y_m: vec![0.0; frames],
            glass_z_m: vec![0.0; frames],
            tilt_rad: vec![0.0; frames],
            acceleration_m_s2: acceleration,
            column_m: vec![],
            wall_m: vec![],
            profile_m: profile,
            energy: vec![EnergyBook::default(); frames],
            spilled_m3: vec![0.0; frames],
            states: States::Full(vec![]),
            known: KnownGroups::NONE.with(FieldGroup::Surface),
        }
    }

    #[test]
    fn a_linear_answer_is_found() {
        let a: Vec<f64> = (0..300).map(|n| (0.7 * n as f64).sin() + (0.031 * (n * n) as f64).cos()).collect();
        let answer = |n: usize| {
            let past = |k: usize| n.checked_sub(k).map_or(0.0, |m| a[m]);
            1e-3 * (2.0 * past(1) - past(7) + 0.5 * past(30))
        };
        let recording = recording(a.clone(), answer);
        let fitted = linear_with_motion(&recording);
        let worst = fitted.iter().zip(&recording.profile_m).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(worst < 1e-6, "{worst} m");
    }

    #[test]
    fn a_still_glass_has_a_flat_baseline() {
        let fitted = linear_with_motion(&recording(vec![0.0; 100], |_| 0.0));
        assert!(fitted.iter().all(|z| (z - 0.07).abs() < 1e-9));
    }
}
