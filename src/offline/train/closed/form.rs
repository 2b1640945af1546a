//! What is known of a system before anything is learnt: its dimension, its L, which variables have friction.
//!
//! In scaled coordinates x = T (z - mean) and a step for the unit of time, L becomes dt T L T^T.

use super::dataset::{Dataset, Frame};
use crate::offline::prelude::*;
use crate::offline::train::weights::Matrix;
use nalgebra::DMatrix;

/// The known part.
#[derive(Clone, Debug)]
pub(super) struct Form {
    /// Variables.
    pub(super) n: usize,
    /// L where it is known, else zero.
    pub(super) skew: DMatrix<f64>,
    /// Whether L is known.
    pub(super) knows_skew: bool,
    /// dt T M T^T where M is known.
    pub(super) friction: Option<DMatrix<f64>>,
    /// Variables that move.
    moving: Vec<bool>,
    /// Variables that have friction.
    rubbing: Vec<bool>,
}

impl Form {
    pub(super) fn new(data: &Dataset, frame: &Frame) -> Self {
        let n = data.variables();
        let scaled = |m: &DMatrix<f64>| {
            DMatrix::from_fn(n, n, |i, j| data.dt_s * m[(i, j)] / (frame.scale[i] * frame.scale[j]))
        };
        let rubs = |i: usize| data.friction.as_ref().is_none_or(|m| m.row(i).amax() > 0.0);
        Self {
            n,
            skew: data.skew.as_ref().map_or_else(|| DMatrix::zeros(n, n), scaled),
            knows_skew: data.skew.is_some(),
            friction: data.friction.as_ref().map(scaled),
            moving: frame.moving.clone(),
            rubbing: (0..n).map(|i| frame.moving[i] && rubs(i)).collect(),
        }
    }

    /// Entries below the diagonal, and with it.
    pub(super) fn triangles(&self) -> (usize, usize) {
        (self.n * (self.n - 1) / 2, self.n * (self.n + 1) / 2)
    }

    /// Spreads a strict lower triangle over a skew matrix, row-major; entries of what does not move are dropped, and
    /// all where L is known.
    pub(super) fn spread_skew(&self) -> Matrix {
        let (n, mut at) = (self.n, 0);
        let mut spread = Matrix::zeros(self.triangles().0, n * n);
        for i in 0..n {
            for j in 0..i {
                if !self.knows_skew && self.moving[i] && self.moving[j] {
                    spread.values[at * n * n + i * n + j] = 1.0;
                    spread.values[at * n * n + j * n + i] = -1.0;
                }
                at += 1;
            }
        }
        spread
    }

    /// Spreads a lower triangle over C, row-major; rows of what has no friction are dropped.
    pub(super) fn spread_factor(&self) -> Matrix {
        let (n, mut at) = (self.n, 0);
        let mut spread = Matrix::zeros(self.triangles().1, n * n);
        for i in 0..n {
            for j in 0..=i {
                if self.rubbing[i] {
                    spread.values[at * n * n + i * n + j] = 1.0;
                }
                at += 1;
            }
        }
        spread
    }
}
