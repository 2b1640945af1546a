//! The feed-through of the port: the part of the pressure that follows the acceleration at once.
//!
//! In the frame of the glass p = -rho (d phi/dt + a x) + ...: the inertial part -rho a (x - its harmonic
//! extension) is no state of the liquid. Left among the inputs of the autoencoder it forces a latent to
//! equal u(t), which the GENERIC step can only imitate by a kick that is dissipated within a frame.

use crate::TrainError;
use crate::data::dataset::Sequence;
use crate::data::groups::{SIGMA, SURFACE};
use nalgebra::{Cholesky, DMatrix, DVector};
use std::ops::Range;

/// Ridge on the state's regressors, each scaled to unit mean square.
const RIDGE: f64 = 1e-3;

/// F `[coefficients]` by least squares of sigma's coefficients on those of q, v and the surface and on
/// u; zero for every other group, which cannot follow the acceleration at once.
///
/// # Errors
/// [`TrainError::Singular`] when the sequences do not determine it.
pub(crate) fn through(training: &[Sequence], ranges: &[Range<usize>]) -> Result<Vec<f32>, TrainError> {
    let width = ranges.iter().map(|r| r.end).max().unwrap_or(0);
    let state: Vec<usize> = [0, 1, SURFACE].iter().flat_map(|&group| ranges[group].clone()).collect();
    let sigma = ranges[SIGMA].clone();
    let rows = || training.iter().flat_map(|s| s.coefficients.chunks_exact(width).zip(&s.port));
    let scale: Vec<f64> = state
        .iter()
        .map(|&i| rows().map(|(row, _)| f64::from(row[i]).powi(2)).sum::<f64>().sqrt().max(f64::MIN_POSITIVE))
        .collect();
    let size = state.len() + 1;
    let mut normal = DMatrix::<f64>::zeros(size, size);
    let mut mixed = DMatrix::<f64>::zeros(size, sigma.len());
    for (row, &u) in rows() {
        let known = state.iter().zip(&scale).map(|(&i, s)| f64::from(row[i]) / s);
        let known = DVector::from_iterator(size, known.chain([u]));
        let due = DVector::from_iterator(sigma.len(), row[sigma.clone()].iter().map(|&c| f64::from(c)));
        normal.ger(1.0, &known, &known, 1.0);
        mixed.ger(1.0, &known, &due, 1.0);
    }
    (0..state.len()).for_each(|i| normal[(i, i)] += RIDGE);
    let solution =
        Cholesky::new(normal).ok_or(TrainError::Singular("the feed-through of the port"))?.solve(&mixed);
    let mut feed = vec![0.0; width];
    let found = solution.row(state.len());
    feed[sigma].iter_mut().zip(found.iter()).for_each(|(f, &c)| *f = c as f32);
    Ok(feed)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::networks::noise::normal;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    /// sigma = 2 q - 3 v + 7 u: F is found although q follows u too.
    #[test]
    fn feed_is_distinguished_from_what_the_state_owes() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let port: Vec<f64> = (0..300).map(|_| normal(&mut rng)).collect();
        let row = |&u: &f64| {
            let (q, v, tau) = (0.8 * u + 0.2 * normal(&mut rng), normal(&mut rng), u);
            let sigma = 2.0 * q - 3.0 * v + 7.0 * u;
            [q, v, sigma, tau, 0.5 * q].map(|c| c as f32)
        };
        let coefficients = port.iter().flat_map(row).collect();
        let sequence = Sequence {
            coefficients,
            norm2: Vec::new(),
            profile_m: Vec::new(),
            glass_x_m: Vec::new(),
            energy_j: Vec::new(),
            heat_j: Vec::new(),
            work_j: Vec::new(),
            port,
        };
        let feed = through(&[sequence], &[0..1, 1..2, 2..3, 3..4, 4..5]).expect("a determined fit");
        assert!((feed[SIGMA] - 7.0).abs() < 0.05, "{}", feed[SIGMA]);
        assert!([0, 1, 3, 4].iter().all(|&i| feed[i] == 0.0), "no other group has one: {feed:?}");
    }
}
