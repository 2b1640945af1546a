//! Where in the glass the heat lies.
//!
//! Heat is made in the layers at the wall and stays with the liquid that it was made in; the tracers follow the surface
//! alone. What the liquid has been displaced by, which is linear in the latents for a small slosh, moves the pattern past them:
//! ```text
//! e - e_rest = s (p_0 + P x)           s the heat of the energy books, by least squares over the training frames
//! P x = sum_k p_k c_k,   c = A x       the first directions of P <s^2 x x^T>^(1/2): as few as leave out little
//! ```
//! Fitted alone, `p_0` misses 10 to 12 % of the change of e in glycerine, its true heat known; what this misses with the true
//! heat and latents is a row of the training's report. The pattern ages as the heat mixes, which nothing here follows.

use crate::data::snapshots::{fluctuation, rest_of};
use crate::hyperparameters::HeatParameters;
use crate::networks::encoded::EncodedRecordings;
use meniscus::latent::decoder::{ENERGY_GROUP, MAX_HEATED};
use meniscus::latent::generic::{LATENTS, Latent};
use meniscus_data::recording::{Recording, STATE, TRACERS, group_range};
use meniscus_optim::weights::Matrix;
use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// The pattern of the internal energy.
#[derive(Clone, Debug)]
pub(crate) struct Heat {
    /// `p_0` and `p_k`, `[TRACERS, 1 + rank]`, 1/kg.
    pub(crate) basis: Matrix,
    /// A, `[rank, LATENTS]`.
    pub(crate) coefficients: Matrix,
}

impl Heat {
    /// The pattern of `training`, whose latents are those of `seen`; zeros where no heat was made.
    pub(crate) fn fit(training: &[Recording], seen: &EncodedRecordings, parameters: &HeatParameters) -> Self {
        // With f = s (1, x): normal equations of e on f.
        let mut normal = DMatrix::<f64>::zeros(1 + LATENTS, 1 + LATENTS);
        let mut right = DMatrix::<f64>::zeros(1 + LATENTS, TRACERS);
        let mut field = vec![0.0; STATE];
        for ((recording, sequence), latents) in training.iter().zip(&seen.sequences).zip(&seen.latents) {
            let rest = rest_of(recording);
            for (frame, x) in latents.iter().enumerate().step_by(parameters.stride) {
                let s = sequence.heat_j[frame];
                let f = DMatrix::from_fn(1 + LATENTS, 1, |k, _| if k == 0 { s } else { s * x[k - 1] });
                fluctuation(recording, frame, &rest, &mut field);
                let e = field[group_range(ENERGY_GROUP)].iter().map(|&e| f64::from(e));
                normal.ger(1.0, &f.column(0), &f.column(0), 1.0);
                right.ger(1.0, &f.column(0), &DMatrix::from_iterator(TRACERS, 1, e).column(0), 1.0);
            }
        }
        Self::solve(&normal, &right, parameters)
    }

    /// From the normal equations `normal p = right`.
    fn solve(normal: &DMatrix<f64>, right: &DMatrix<f64>, parameters: &HeatParameters) -> Self {
        let mut damped = normal.clone();
        for k in 1..=LATENTS {
            damped[(k, k)] += parameters.ridge * normal[(0, 0)];
        }
        let Some(p) = damped.cholesky().map(|cholesky| cholesky.solve(right)) else {
            return Self { basis: Matrix::zeros(right.ncols(), 1), coefficients: Matrix::zeros(0, LATENTS) };
        };
        let (still, moving) = (p.row(0), p.rows(1, LATENTS));
        // <s^2 x x^T> = Q l Q^T, and its root.
        let spread = SymmetricEigen::new(normal.view((1, 1), (LATENTS, LATENTS)).into_owned());
        let root = spread.eigenvalues.map(|l| l.max(0.0).sqrt());
        let silent = 1e-6 * root.max();
        let inverse = root.map(|l| if l > silent { 1.0 / l } else { 0.0 });
        let turned = |d: &DVector<f64>| {
            &spread.eigenvectors * DMatrix::from_diagonal(d) * spread.eigenvectors.transpose()
        };
        let (root, inverse) = (turned(&root), turned(&inverse));
        let weighed = &root * moving;
        let along = SymmetricEigen::new(&weighed * weighed.transpose());
        let mut order: Vec<usize> = (0..LATENTS).collect();
        order.sort_by(|&a, &b| along.eigenvalues[b].total_cmp(&along.eigenvalues[a]));
        let left = |rank: usize| order[rank..].iter().map(|&k| along.eigenvalues[k].max(0.0)).sum::<f64>();
        let enough = |rank: &usize| left(*rank) <= parameters.left_out * left(0);
        let rank = (0..MAX_HEATED - 1).find(enough).unwrap_or(MAX_HEATED - 1);
        let u = DMatrix::from_fn(LATENTS, rank, |i, k| along.eigenvectors[(i, order[k])]);
        let mut basis = u.tr_mul(&weighed).insert_row(0, 0.0);
        basis.set_row(0, &still);
        let basis = basis.transpose();
        Self { basis: Matrix::from_f64(&basis), coefficients: Matrix::from_f64(&u.tr_mul(&inverse)) }
    }

    /// The change of the internal energy by `heat_j` joules at the latent `x`, J/kg.
    fn at(&self, heat_j: f64, x: &Latent) -> DVector<f64> {
        let c = self.coefficients.to_f64() * DVector::from_row_slice(x.as_slice());
        self.basis.to_f64() * c.insert_row(0, 1.0) * heat_j
    }

    /// Relative L2 error of the change of e over `recordings`, whose latents and heat are those of `held`.
    pub(crate) fn missed(&self, recordings: &[Recording], held: &EncodedRecordings) -> f64 {
        let (mut miss, mut size) = (0.0, 0.0);
        let mut field = vec![0.0; STATE];
        for ((recording, sequence), latents) in recordings.iter().zip(&held.sequences).zip(&held.latents) {
            let rest = rest_of(recording);
            for (frame, x) in latents.iter().enumerate() {
                fluctuation(recording, frame, &rest, &mut field);
                let said = self.at(sequence.heat_j[frame], x);
                for (said, e) in said.iter().zip(&field[group_range(ENERGY_GROUP)]) {
                    miss += (said - f64::from(*e)).powi(2);
                    size += f64::from(*e).powi(2);
                }
            }
        }
        (miss / size.max(f64::MIN_POSITIVE)).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two patterns that two latents move: both are found, with two directions and no more.
    #[test]
    fn a_pattern_that_moves_with_the_latents_is_found() {
        let wave = |k: usize, n: usize| (0.1 * (k + 1) as f64 * n as f64).sin();
        let truth = |s: f64, x: &Latent, n: usize| {
            s * (2.0 + wave(0, n) + 0.5 * x[0] * wave(1, n) + 0.3 * (x[2] - x[5]) * wave(2, n))
        };
        let (mut normal, mut right) =
            (DMatrix::<f64>::zeros(1 + LATENTS, 1 + LATENTS), DMatrix::zeros(1 + LATENTS, 40));
        let latent = |t: usize| {
            // The last latent is silent.
            let wave = |k: usize| (0.37 * (k + 1) as f64 * t as f64).cos();
            Latent::from_fn(|k, _| if k + 1 == LATENTS { 0.0 } else { wave(k) })
        };
        for t in 1..400 {
            let (s, x) = (0.01 * t as f64, latent(t));
            let f = DMatrix::from_fn(1 + LATENTS, 1, |k, _| if k == 0 { s } else { s * x[k - 1] });
            normal += &f * f.transpose();
            right += &f * DMatrix::from_fn(1, 40, |_, n| truth(s, &x, n));
        }
        let heat = Heat::solve(&normal, &right, &HeatParameters::default());
        assert_eq!((heat.basis.columns, heat.coefficients.rows), (3, 2));
        let (s, x) = (1.7, latent(777));
        let said = heat.at(s, &x);
        for (n, said) in said.iter().enumerate() {
            assert!((said - truth(s, &x, n)).abs() < 2e-3, "{n}: {said} for {}", truth(s, &x, n));
        }
        // What no frame had has no pattern.
        let mut other = x;
        other[LATENTS - 1] = 5.0;
        assert_eq!(heat.at(s, &other), said);
    }

    #[test]
    fn without_heat_there_is_no_pattern() {
        let (normal, right) = (DMatrix::zeros(1 + LATENTS, 1 + LATENTS), DMatrix::zeros(1 + LATENTS, 4));
        let heat = Heat::solve(&normal, &right, &HeatParameters::default());
        assert_eq!((heat.basis.columns, heat.coefficients.rows), (1, 0));
        assert!(heat.basis.values.iter().all(|p| *p == 0.0));
    }
}
