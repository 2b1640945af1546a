//! Interval of a size: curvature with noise and model error, scatter over packings, error of the spacing.
//!
//! ```text
//! curvature   H^-1 (V + P) H^-1     H = J^T J + P,  P the priors,  V the covariance of the scores J^T e
//! packings    (1 + 1/K) sum over recordings of the variance over K packings of H^-1 J^T e
//! spacing     what remains of an error of second order: d h1^2/(h2^2 - h1^2), d the change from spacing h2 to h1
//! ```
//! V is the larger of two estimates: scores summed with Bartlett's window over `WINDOW` frames (Newey and West 1987), which
//! holds noise and errors that last less than that, and sums by recording, which holds all that recordings disagree on.
//! The degrees of freedom are those of Welch and Satterthwaite.

use super::emulator::{Emulator, Fit};
use meniscus_numerics::statistics::student_t_exceeded;
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// Frames of Bartlett's window: longer than the first mode's period at 60 Hz.
const WINDOW: usize = 24;

/// Chance on either side of the interval.
const TAIL: f64 = 0.05;

/// Largest degrees of freedom: more change nothing.
const MANY: f64 = 1e3;

/// Part of the error of a size.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Component {
    /// Variance.
    pub variance: f64,
    /// Degrees of freedom that it was estimated with.
    pub freedom: f64,
}

/// Parts of the error of a size.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SizeVariance {
    /// Noise, model error and the priors of the other parameters.
    pub curvature: Component,
    /// Scatter over packings.
    pub packings: Component,
    /// Error of the spacing of the particles.
    pub spacing: Component,
}

impl SizeVariance {
    /// Returns the half-width of the interval with a nominal coverage of 90 %.
    #[must_use]
    pub fn half_width(&self) -> f64 {
        let all = [self.curvature, self.packings, self.spacing];
        let total: f64 = all.iter().map(|c| c.variance).sum();
        let spread: f64 =
            all.iter().filter(|c| c.variance > 0.0).map(|c| c.variance.powi(2) / c.freedom.max(1.0)).sum();
        if total <= 0.0 {
            return 0.0;
        }
        student_t_exceeded(TAIL, (total * total / spread).clamp(1.0, MANY)) * total.sqrt()
    }
}

/// Linearised fit: residual, derivatives and the inverse of the information.
#[derive(Clone, Debug)]
pub struct Linearised {
    /// Residual.
    pub residual: DVector<f64>,
    /// Derivatives by size and other parameters.
    pub jacobian: DMatrix<f64>,
    /// `H^-1`.
    pub inverse: DMatrix<f64>,
    /// Information of the priors.
    pub prior: DMatrix<f64>,
}

impl Linearised {
    /// Returns the linearised `fit`; none where the size changes nothing.
    #[must_use]
    pub fn of(emulator: &Emulator, fit: &Fit) -> Option<Self> {
        let (residual, jacobian) = emulator.linearised(fit);
        let count = jacobian.ncols();
        let mut prior = DMatrix::zeros(count, count);
        for (j, one) in emulator.priors.iter().enumerate() {
            prior[(1 + j, 1 + j)] = one.deviation.powi(-2);
        }
        let inverse = (jacobian.tr_mul(&jacobian) + &prior).try_inverse()?;
        inverse.iter().all(|x| x.is_finite()).then_some(Self { residual, jacobian, inverse, prior })
    }

    /// Returns the variances of all parameters by curvature, noise and model error; `channels` are the numbers of each
    /// channel of each recording.
    #[must_use]
    pub fn curvature(&self, recordings: &[Range<usize>], channels: &[Range<usize>]) -> Vec<Component> {
        let near = self.covariance(&self.windowed(channels));
        let count = recordings.len() as f64;
        let apart = self.covariance(&self.by_recording(recordings));
        let one = |i: usize| {
            let window = Component { variance: near[(i, i)], freedom: MANY };
            let recordings = Component { variance: apart[(i, i)], freedom: (count - 1.0).max(1.0) };
            if recordings.variance > window.variance { recordings } else { window }
        };
        (0..self.jacobian.ncols()).map(one).collect()
    }

    fn covariance(&self, scores: &DMatrix<f64>) -> DMatrix<f64> {
        &self.inverse * (scores + &self.prior) * &self.inverse
    }

    /// Returns the covariance of the scores within [`WINDOW`] frames of one another.
    fn windowed(&self, channels: &[Range<usize>]) -> DMatrix<f64> {
        let count = self.jacobian.ncols();
        let mut out = DMatrix::zeros(count, count);
        for range in channels {
            let score = |i: usize| self.jacobian.row(i).transpose() * self.residual[i];
            let scores: Vec<DVector<f64>> = range.clone().map(score).collect();
            for apart in 0..WINDOW.min(scores.len()) {
                let weight = 1.0 - apart as f64 / WINDOW as f64;
                for (one, other) in scores.iter().zip(&scores[apart..]) {
                    let product = one * other.transpose() * weight;
                    out += &product;
                    if apart > 0 {
                        out += product.transpose();
                    }
                }
            }
        }
        out
    }

    /// Returns the covariance of the scores summed by recording.
    fn by_recording(&self, recordings: &[Range<usize>]) -> DMatrix<f64> {
        let count = self.jacobian.ncols();
        let mut out = DMatrix::zeros(count, count);
        if recordings.len() < 2 {
            return out;
        }
        for range in recordings {
            let score = self.score(range, &self.residual);
            out += &score * score.transpose();
        }
        out * (recordings.len() as f64 / (recordings.len() as f64 - 1.0))
    }

    fn score(&self, range: &Range<usize>, residual: &DVector<f64>) -> DVector<f64> {
        let (first, length) = (range.start, range.len());
        self.jacobian.rows(first, length).tr_mul(&residual.rows(first, length))
    }

    /// Returns the mean step of the parameters over `residuals`, one for each packing at the same parameters, counted from
    /// the first packing, and the variances by their scatter.
    #[must_use]
    pub fn packings(
        &self,
        recordings: &[Range<usize>],
        residuals: &[DVector<f64>],
    ) -> (DVector<f64>, Vec<Component>) {
        let parameters = self.jacobian.ncols();
        let count = residuals.len() as f64;
        // Steps by packing, then by recording.
        let step = |residual: &DVector<f64>| -> Vec<DVector<f64>> {
            recordings.iter().map(|range| &self.inverse * self.score(range, residual)).collect()
        };
        let steps: Vec<Vec<DVector<f64>>> = residuals.iter().map(step).collect();
        let total = |steps: &Vec<DVector<f64>>| steps.iter().sum::<DVector<f64>>();
        let totals: Vec<DVector<f64>> = steps.iter().map(total).collect();
        let mean = totals.iter().sum::<DVector<f64>>() / count;
        let shift = &mean - &totals[0];
        if residuals.len() < 2 {
            return (shift, vec![Component::default(); parameters]);
        }
        let freedom = count - 1.0;
        let mut apart = DVector::<f64>::zeros(parameters);
        for recording in 0..recordings.len() {
            let mean = steps.iter().map(|s| &s[recording]).sum::<DVector<f64>>() / count;
            for step in &steps {
                apart += (&step[recording] - &mean).map(|x| x * x) / freedom;
            }
        }
        let together = totals.iter().map(|t| (t - &mean).map(|x| x * x)).sum::<DVector<f64>>() / freedom;
        // Where the recordings of a packing err together, each packing tells of its error once.
        let one = |i: usize| Component {
            variance: (1.0 + 1.0 / count) * apart[i].max(together[i]),
            freedom: if together[i] > apart[i] { freedom } else { freedom * recordings.len() as f64 },
        };
        (shift, (0..parameters).map(one).collect())
    }
}

/// Returns the error of the spacing, from the sizes found at two spacings: what an error of second order leaves.
#[must_use]
pub fn spacing_error(coarse: (f64, f64), fine: (f64, f64)) -> Component {
    let ((coarse_m, coarse_size), (fine_m, fine_size)) = (coarse, fine);
    let left = (fine_size - coarse_size) * fine_m.powi(2) / (coarse_m.powi(2) - fine_m.powi(2));
    // As likely anywhere up to that, on either side.
    Component { variance: left * left / 3.0, freedom: MANY }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_half_width_is_student_t_of_the_leading_part() {
        let component = |variance: f64, freedom: f64| Component { variance, freedom };
        let wide = SizeVariance { packings: component(4.0, 2.0), ..SizeVariance::default() };
        assert!((wide.half_width() - 2.0 * 2.920).abs() < 1e-3, "{}", wide.half_width());
        let known = SizeVariance { curvature: component(4.0, MANY), ..SizeVariance::default() };
        assert!((known.half_width() - 2.0 * 1.646).abs() < 1e-3, "{}", known.half_width());
        let both = SizeVariance { curvature: component(2.0, MANY), packings: component(2.0, 2.0), ..known };
        assert!(both.half_width() > known.half_width() && both.half_width() < wide.half_width());
        assert_eq!(SizeVariance::default().half_width(), 0.0);
    }

    #[test]
    fn a_second_order_error_is_extrapolated_to_no_spacing() {
        // size(h) = 5 + 0.01 h^2: at 7 mm 5.49, at 5 mm 5.25; 0.25 is left.
        let left = spacing_error((7.0, 5.49), (5.0, 5.25)).variance.sqrt() * 3.0_f64.sqrt();
        assert!((left - 0.25).abs() < 1e-9, "{left}");
    }
}
