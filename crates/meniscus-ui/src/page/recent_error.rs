//! Error of the estimate beside the true surface, where the camera is simulated.

use meniscus::surface::POINTS;
use std::collections::VecDeque;

/// Turns over which the error is taken: 4 s.
const OVER: usize = 240;

/// Error of the surface over the last turns, relative to the slosh: |z - estimate| / |z - z_rest|, norms over points and
/// turns, as the report of a run has it. A flat surface scores 1.
#[derive(Debug, Default)]
pub(super) struct RecentError {
    /// Squares of error and of slosh, by turn.
    turns: VecDeque<[f64; 2]>,
}

impl RecentError {
    /// Takes a turn.
    pub(super) fn add(&mut self, truth: &[f32; POINTS], estimate: &[f32; POINTS], rest_m: f64) {
        let mut sums = [0.0; 2];
        for (&z, &estimate) in truth.iter().zip(estimate) {
            let z = f64::from(z);
            sums[0] += (z - f64::from(estimate)).powi(2);
            sums[1] += (z - rest_m).powi(2);
        }
        self.turns.truncate(OVER - 1);
        self.turns.push_front(sums);
    }

    /// Returns the error; not a number before the first turn.
    pub(super) fn get(&self) -> f64 {
        let [error, slosh] =
            self.turns.iter().fold([0.0; 2], |[error, slosh], turn| [error + turn[0], slosh + turn[1]]);
        (error / slosh).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flat_estimate_scores_one_and_old_turns_no_longer_count() {
        let (mut recent, leaning) =
            (RecentError::default(), std::array::from_fn(|k| 0.06 + 0.001 * k as f32));
        assert!(recent.get().is_nan());
        recent.add(&leaning, &[0.07; POINTS], 0.07);
        assert!((recent.get() - 1.0).abs() < 1e-6, "{}", recent.get());
        (0..OVER).for_each(|_| recent.add(&leaning, &leaning, 0.07));
        assert_eq!(recent.get(), 0.0);
    }
}
