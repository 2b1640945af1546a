//! Intervals of the numbers of a law: their extremes over all flow curves that fit nearly as well as the best one.
//!
//! The derivatives of a slosh by the numbers hold at the best curve alone, and numbers far from it can have nearly the same curve. A
//! slosh is driven by the stress over the rates of shear. So a curve c lies in the region of those that fit if some step p of the
//! numbers within their linear region changes the stresses as c does:
//!
//! ```text
//! min over p of  mean over r of (ln tau_c(r) - ln tau(r) - sum_j p_j d_j(r))^2 / u^2  +  p^T (D R D)^-1 p  <=  1
//!
//! tau the best curve, d_j = d ln tau / d number j       r: 0.5 to 50 1/s, evenly in ln r
//! D the half-widths of the numbers, R their correlation in the fit
//! u half of the half-width of ln T
//! ```
//! u is a difference of the stresses that the recordings do not show: a slosh shows the shape of a curve less than its height, and the
//! height to the half-width of ln T. Where the law is linear in its numbers, a number ends somewhat beyond its half-width: by a
//! tenth of it in a power law.

use super::flow_curve::{FlowCurve, INDICES, RATE, SHARES};
use crate::law::Law;
use nalgebra::{DMatrix, DVector};

/// u over the half-width of ln T.
const SHAPE: f64 = 0.5;

/// Rates of shear in a slosh, 1/s.
const RATES: (f64, f64) = (0.5, 50.0);

/// Rates that are looked at.
const COUNT: usize = 21;

/// Steps of ln T over twice its half-width to either side, and of index and share between the ends of what is tried.
const STEPS: [usize; 3] = [60, 90, 76];

/// Least and largest half-width: a number that has none, and one that the recordings say nothing of.
const HALF: (f64, f64) = (1e-3, 3.0);

/// The best curve with the linear region of its numbers.
pub(super) struct LinearRegion {
    /// Best curve.
    pub best: FlowCurve,
    /// Law.
    pub law: Law,
    /// Half-widths of the numbers of `law`: ln T, index, share of the yield stress.
    pub half: Vec<f64>,
    /// Their correlation.
    pub correlation: DMatrix<f64>,
}

/// Curves that fit nearly as well as the best one.
pub(super) struct CurveRegion(Vec<FlowCurve>);

impl CurveRegion {
    /// Returns the curves of the region of `linear`, the best one among them.
    pub(super) fn of(linear: &LinearRegion) -> Self {
        let LinearRegion { best, law, .. } = linear;
        let cost = Cost::of(linear);
        let reach = 2.0 * linear.half.first().map_or(HALF.1, |half| half.clamp(HALF.0, HALF.1));
        let stresses = grid(best.log_stress - reach, best.log_stress + reach, STEPS[0]);
        let only = |has: bool, (low, high): (f64, f64), steps: usize, absent: f64| {
            if has { grid(low, high, steps) } else { vec![absent] }
        };
        let indices = only(law.has_index(), INDICES, STEPS[1], best.index);
        let shares = only(law.has_yield_stress(), SHARES, STEPS[2], best.share);
        let mut curves = vec![*best];
        for &index in &indices {
            for &share in &shares {
                let at = stresses.iter().map(|&log_stress| FlowCurve { log_stress, index, share });
                curves.extend(at.filter(|curve| cost.at(curve) <= 1.0));
            }
        }
        Self(curves)
    }

    /// Returns the least and the largest value of `of`.
    pub(super) fn ends(&self, of: fn(&FlowCurve) -> f64) -> [f64; 2] {
        let fold = |pick: fn(f64, f64) -> f64, start: f64| self.0.iter().map(of).fold(start, pick);
        [fold(f64::min, f64::INFINITY), fold(f64::max, f64::NEG_INFINITY)]
    }
}

/// Left side of the condition of the region.
///
/// With A of the columns d_j / (u sqrt(COUNT)) and y the same of the change of ln tau, the minimum over p is
/// y^T y - y^T A (A^T A + C^-1)^-1 A^T y.
struct Cost {
    best: Vec<f64>,
    /// 1 / (u sqrt(COUNT)).
    weight: f64,
    /// A, `[COUNT, numbers]`.
    tangents: DMatrix<f64>,
    /// (A^T A + C^-1)^-1.
    inverse: DMatrix<f64>,
}

impl Cost {
    fn of(linear: &LinearRegion) -> Self {
        let LinearRegion { best, law, half, correlation } = linear;
        let of = |k: usize| half.get(k).copied().unwrap_or(HALF.1).clamp(HALF.0, HALF.1);
        let weight = 1.0 / (SHAPE * of(0) * (COUNT as f64).sqrt());
        let columns: Vec<usize> = [true, law.has_index(), law.has_yield_stress()]
            .iter()
            .zip(0..)
            .filter(|(has, _)| **has)
            .map(|(_, j)| j)
            .collect();
        let tangents =
            DMatrix::from_fn(COUNT, columns.len(), |i, j| weight * slopes(best, rate(i))[columns[j]]);
        let covariance = DMatrix::from_fn(columns.len(), columns.len(), |i, j| {
            of(i) * of(j) * correlation.get((i, j)).copied().unwrap_or(f64::from(u8::from(i == j)))
        });
        let information =
            covariance.try_inverse().unwrap_or_else(|| DMatrix::zeros(columns.len(), columns.len()));
        let inverse = (tangents.tr_mul(&tangents) + information)
            .try_inverse()
            .unwrap_or_else(|| DMatrix::zeros(columns.len(), columns.len()));
        Self { best: stresses(best), weight, tangents, inverse }
    }

    fn at(&self, curve: &FlowCurve) -> f64 {
        let Self { weight, .. } = *self;
        let changed = stresses(curve).into_iter().zip(&self.best).map(|(one, best)| weight * (one - best));
        let change = DVector::from_iterator(COUNT, changed);
        let score = self.tangents.tr_mul(&change);
        change.norm_squared() - score.dot(&(&self.inverse * &score))
    }
}

/// Rate number `i`, 1/s.
fn rate(i: usize) -> f64 {
    RATES.0 * (RATES.1 / RATES.0).powf(i as f64 / (COUNT - 1) as f64)
}

/// ln tau at every rate: T (y + (1 - y) (r/RATE)^n).
fn stresses(curve: &FlowCurve) -> Vec<f64> {
    let at = |i: usize| {
        let power = (rate(i) / RATE).powf(curve.index);
        curve.log_stress + (curve.share + (1.0 - curve.share) * power).ln()
    };
    (0..COUNT).map(at).collect()
}

/// d ln tau by ln T, n and y at `rate`.
fn slopes(curve: &FlowCurve, rate: f64) -> [f64; 3] {
    let power = (rate / RATE).powf(curve.index);
    let whole = curve.share + (1.0 - curve.share) * power;
    [1.0, (1.0 - curve.share) * power * (rate / RATE).ln() / whole, (1.0 - power) / whole]
}

/// `steps` equal steps from `low` to `high`.
fn grid(low: f64, high: f64, steps: usize) -> Vec<f64> {
    (0..=steps).map(|i| low + (high - low) * i as f64 / steps as f64).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Index and share far from the best ones, whose curve is the same to 10 %, lie within; a curve that differs does not.
    #[test]
    fn the_region_follows_the_curves_and_not_their_tangent() {
        // Of 2 Pa s^n, 0.4 and 3 Pa, and of 4.6 Pa s^n, 0.23 and 0.3 Pa.
        let (truth, found) = (FlowCurve::of(2.0, 0.4, 3.0), FlowCurve::of(4.6, 0.23, 0.3));
        let half = vec![0.1, 0.08, 0.35];
        let correlation = DMatrix::from_row_slice(3, 3, &[1.0, 0.0, 0.0, 0.0, 1.0, 0.9, 0.0, 0.9, 1.0]);
        let region =
            CurveRegion::of(&LinearRegion { best: found, law: Law::HerschelBulkley, half, correlation });
        let [low, high] = region.ends(|curve| curve.index);
        assert!(low < found.index && high >= truth.index, "{low} to {high}");
        let [low, high] = region.ends(FlowCurve::yield_stress_pa);
        assert!(low < found.yield_stress_pa() && high >= truth.yield_stress_pa(), "{low} to {high}");
        let [_, high] = region.ends(|curve| curve.index);
        assert!(high < 0.8, "a Newtonian liquid has another curve: {high}");
    }

    /// Where the law is linear in its numbers, each ends a tenth beyond its half-width.
    #[test]
    fn small_half_widths_are_those_of_the_linear_region() {
        let best = FlowCurve { log_stress: 1.0, index: 0.5, share: 0.0 };
        let linear = LinearRegion {
            best,
            law: Law::Power,
            half: vec![0.2, 0.1],
            correlation: DMatrix::identity(2, 2),
        };
        let region = CurveRegion::of(&linear);
        let [low, high] = region.ends(|curve| curve.index);
        assert!((low - 0.39).abs() < 0.015 && (high - 0.61).abs() < 0.015, "{low} to {high}");
        let [low, high] = region.ends(|curve| curve.log_stress);
        assert!((low - 0.78).abs() < 0.02 && (high - 1.22).abs() < 0.02, "{low} to {high}");
    }
}
