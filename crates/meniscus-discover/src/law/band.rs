//! Bands of a drawn law: what noise, model error and prior leave open.
//!
//! ```text
//! A p_k = A p - J^T r + s L z_k,   d_k >= 0,     A = J^T J = L L^T,   z_k normal,   s^2 = misfit, at least 1
//! half-width(x) = q s(x) factor,   s(x)^2 = mean over k of (curve_k(x) - curve(x))^2
//! ```
//! `q` is such that nine of ten draws stay inside over the whole curve. The draws know nothing of what a formula of the
//! truth would add; `factor` was measured on hidden laws that are not judged ([`CALIBRATION`]).

use super::fit::LawFit;
use super::shape::least;
use meniscus_numerics::least_squares::bounded;
use meniscus_numerics::random::normal;
use nalgebra::DVector;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Draws.
const DRAWS: usize = 300;

/// Share of draws that lie inside a band over its whole curve.
pub const CONFIDENCE: f64 = 0.9;

/// Factors on the half-widths of both bands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibrated {
    /// Of the conservative force.
    pub force: f64,
    /// Of the drag.
    pub drag: f64,
}

/// Factors that `meniscus discover study --laws-only` measures on its calibration trials: each is the quantile of
/// [`CONFIDENCE`] of the largest error over half-width. A band is not made narrower than its draws.
pub const CALIBRATION: Calibrated = Calibrated { force: 1.08, drag: 1.94 };

/// A curve with its band.
#[derive(Clone, Debug, PartialEq)]
pub struct Band {
    /// Heights, m, or amplitudes of the rate, m/s.
    pub at: Vec<f64>,
    /// Curve, N.
    pub value: Vec<f64>,
    /// Half-width of the band, N.
    pub half: Vec<f64>,
}

impl Band {
    /// Returns the largest distance of `curve` from the middle, in half-widths.
    #[must_use]
    pub fn largest_distance(&self, curve: &[f64]) -> f64 {
        let each = self.value.iter().zip(&self.half).zip(curve);
        each.map(|((value, half), other)| (other - value).abs() / half).fold(0.0, f64::max)
    }

    /// Returns the root mean square of that distance.
    #[must_use]
    pub fn distance(&self, curve: &[f64]) -> f64 {
        let each = self.value.iter().zip(&self.half).zip(curve);
        let sum: f64 = each.map(|((value, half), other)| ((other - value) / half).powi(2)).sum();
        (sum / self.at.len() as f64).sqrt()
    }
}

/// Bands of both curves.
#[derive(Clone, Debug, PartialEq)]
pub struct Bands {
    /// Conservative force by the height.
    pub force: Band,
    /// Drag by the amplitude of the rate.
    pub drag: Band,
}

/// Returns the bands of `fit`, whose data are `count` numbers, by draws from `seed` on, with the factors `calibrated`.
#[must_use]
pub fn bands(fit: &LawFit, count: usize, seed: u64, calibrated: Calibrated) -> Option<Bands> {
    let thetas = fit.theta.len();
    let a = fit.jacobian.tr_mul(&fit.jacobian);
    let point = DVector::from_iterator(a.nrows(), fit.theta.iter().chain(&fit.numbers).copied());
    let right = &a * &point - fit.jacobian.tr_mul(&fit.residual);
    let root = a.clone().cholesky()?.l();
    let widen = fit.chi2(count).max(1.0).sqrt();
    let bounds: Vec<f64> = vec![f64::NEG_INFINITY; thetas].into_iter().chain(least()).collect();
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut forces = Vec::new();
    let mut drags = Vec::new();
    for _ in 0..DRAWS {
        let z = DVector::from_fn(a.nrows(), |_, _| normal(&mut random));
        let drawn = bounded(&a, &(&right + &root * z * widen), &bounds)?;
        let tables = fit.extent.tables(&drawn.as_slice()[thetas..]);
        // Both curves vanish at rest.
        let middle = tables.force_n.len() / 2;
        forces.push(without(&tables.force_n, middle));
        drags.push(without(&tables.drag_n, 0));
    }
    let tables = fit.law.tables();
    let (heights, rates) = (fit.extent.heights_m(), fit.extent.rates_m_s());
    let middle = heights.len() / 2;
    let force =
        banded(without(&heights, middle), without(&tables.force_n, middle), &forces, calibrated.force);
    let drag = banded(without(&rates, 0), without(&tables.drag_n, 0), &drags, calibrated.drag);
    Some(Bands { force, drag })
}

/// Returns `all` without the number at `place`.
fn without(all: &[f64], place: usize) -> Vec<f64> {
    all.iter().enumerate().filter(|(i, _)| *i != place).map(|(_, x)| *x).collect()
}

/// Returns the band of `draws` around `value`.
fn banded(at: Vec<f64>, value: Vec<f64>, draws: &[Vec<f64>], factor: f64) -> Band {
    let count = draws.len() as f64;
    let deviation = |i: usize| {
        let square: f64 = draws.iter().map(|curve| (curve[i] - value[i]).powi(2)).sum();
        (square / count).sqrt().max(f64::MIN_POSITIVE)
    };
    let deviations: Vec<f64> = (0..value.len()).map(deviation).collect();
    let reach = |curve: &Vec<f64>| {
        let each = curve.iter().zip(&value).zip(&deviations);
        each.map(|((c, v), s)| (c - v).abs() / s).fold(0.0, f64::max)
    };
    let mut reaches: Vec<f64> = draws.iter().map(reach).collect();
    reaches.sort_by(f64::total_cmp);
    let q = reaches[((CONFIDENCE * count) as usize).min(reaches.len() - 1)];
    let half = deviations.iter().map(|s| factor * q * s).collect();
    Band { at, value, half }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nine_of_ten_draws_stay_inside_over_the_whole_curve() {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let mut draw = || -> Vec<f64> { (0..12).map(|i| f64::from(i) + normal(&mut random)).collect() };
        let draws: Vec<Vec<f64>> = (0..500).map(|_| draw()).collect();
        let value: Vec<f64> = (0..12).map(f64::from).collect();
        let band = banded(value.clone(), value, &draws, 1.0);
        let inside = (0..500).filter(|_| band.largest_distance(&draw()) <= 1.0).count();
        assert!((430..475).contains(&inside), "{inside} of 500");
        // Twelve independent places need more than the 1.645 of a single one.
        assert!(band.half.iter().all(|half| (2.2..3.4).contains(half)), "{:?}", band.half);
        assert_eq!(band.largest_distance(&band.value), 0.0);
    }
}
