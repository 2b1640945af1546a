//! Law of flow in the coordinates that a slosh distinguishes: the stress at a typical rate, the flow index, and the share of the
//! yield stress.
//!
//! ```text
//! tau(rate) = tau0 + k rate^n        T = tau(RATE)      y = tau0/T      k = (1 - y) T / RATE^n
//! ```
//! Laws with other numbers can have nearly the same curve over the rates of a slosh: of 2 Pa s^n, 0.4 and 3 Pa and of 4.6 Pa s^n,
//! 0.23 and 0.3 Pa the stresses differ by less than 10 % from 0.5 to 50 1/s. T is then known to some per cent where k is not.

use crate::law::Law;
use meniscus_discover::sizing::emulator::Prior;
use meniscus_discover::sizing::error::SizingError;
use meniscus_discover::sizing::forward::{Forward, Point, Simulated};
use meniscus_discover::sizing::search::OtherParameter;

/// Rate of T, 1/s: a velocity of 0.3 m/s over the radius of a glass.
pub(super) const RATE: f64 = 10.0;

/// Flow indices that are tried.
pub(super) const INDICES: (f64, f64) = (0.1, 1.0);

/// Shares of the yield stress that are tried.
pub(super) const SHARES: (f64, f64) = (0.0, 0.95);

/// Step of the derivatives by index and share.
const STEP: f64 = 0.1;

/// Point of a law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FlowCurve {
    /// Natural logarithm of T in Pa.
    pub log_stress: f64,
    /// Flow index n.
    pub index: f64,
    /// Share y of the yield stress in T.
    pub share: f64,
}

impl FlowCurve {
    /// Curve of `k` (Pa s^n), `n` and `tau0` (Pa).
    pub(super) fn of(k: f64, n: f64, tau0: f64) -> Self {
        let stress = tau0 + k * RATE.powf(n);
        Self { log_stress: stress.ln(), index: n, share: tau0 / stress }
    }

    /// Curve at `log_stress`, with the other numbers of `law` in their order; those that it lacks are of a Newtonian liquid.
    pub(super) fn at(law: Law, log_stress: f64, others: &[f64]) -> Self {
        let mut others = others.iter().copied();
        let mut next = |has: bool, absent: f64| if has { others.next().unwrap_or(absent) } else { absent };
        let index = next(law.has_index(), 1.0).clamp(INDICES.0, INDICES.1);
        let share = next(law.has_yield_stress(), 0.0).clamp(SHARES.0, SHARES.1);
        Self { log_stress, index, share }
    }

    /// The numbers behind the stress that `law` has.
    pub(super) fn others(&self, law: Law) -> Vec<f64> {
        let index = law.has_index().then_some(self.index);
        let share = law.has_yield_stress().then_some(self.share);
        index.into_iter().chain(share).collect()
    }

    /// T, Pa.
    pub(super) fn stress_pa(&self) -> f64 {
        self.log_stress.exp()
    }

    /// Yield stress tau0, Pa.
    pub(super) fn yield_stress_pa(&self) -> f64 {
        self.share * self.stress_pa()
    }

    /// Consistency k, Pa s^n.
    pub(super) fn consistency_pa_sn(&self) -> f64 {
        (1.0 - self.share) * self.stress_pa() / RATE.powf(self.index)
    }

    /// Largest difference of a number from that of `other`.
    pub(super) fn distance(&self, other: &Self) -> f64 {
        let apart = [self.log_stress - other.log_stress, self.index - other.index, self.share - other.share];
        apart.into_iter().fold(0.0, |most: f64, one| most.max(one.abs()))
    }

    /// The numbers behind the stress as parameters of a search, with a prior of this `deviation` around them.
    pub(super) fn parameters(&self, law: Law, deviation: f64) -> Vec<OtherParameter> {
        let one = |mean: f64| {
            // A step towards the middle stays among the values that are tried.
            let step = if mean > 0.5 { -STEP } else { STEP };
            OtherParameter { prior: Prior { mean, deviation }, step }
        };
        self.others(law).into_iter().map(one).collect()
    }
}

/// The simulator as a function of the flow curve.
pub(super) struct CurveForward<'a> {
    /// The same as a function of consistency, index and yield stress.
    pub inner: &'a dyn Forward,
    /// Law.
    pub law: Law,
    /// Consistency that a parameter of 1 stands for, Pa s^n.
    pub unit_pa_sn: f64,
}

impl CurveForward<'_> {
    /// Parameters of the liquid at those of the curve.
    pub(super) fn liquid(&self, parameters: &[f64]) -> Vec<f64> {
        let (stress, others) = parameters.split_first().unwrap_or((&0.0, &[]));
        let curve = FlowCurve::at(self.law, *stress, others);
        let index = self.law.has_index().then_some(curve.index);
        let yield_stress = self.law.has_yield_stress().then_some(curve.yield_stress_pa());
        std::iter::once(curve.consistency_pa_sn() / self.unit_pa_sn)
            .chain(index)
            .chain(yield_stress)
            .collect()
    }
}

impl Forward for CurveForward<'_> {
    fn run(&self, points: &[Point]) -> Result<Vec<Result<Simulated, String>>, SizingError> {
        let of = |point: &Point| Point { parameters: self.liquid(&point.parameters), ..point.clone() };
        self.inner.run(&points.iter().map(of).collect::<Vec<_>>())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_law_comes_back_from_its_curve() {
        let curve = FlowCurve::of(2.0, 0.4, 3.0);
        assert!((curve.stress_pa() - (3.0 + 2.0 * 10.0_f64.powf(0.4))).abs() < 1e-12);
        assert!(
            (curve.consistency_pa_sn() - 2.0).abs() < 1e-12 && (curve.yield_stress_pa() - 3.0).abs() < 1e-12
        );
        for law in [Law::Power, Law::Bingham, Law::HerschelBulkley] {
            let again = FlowCurve::at(law, curve.log_stress, &curve.others(law));
            assert_eq!((again.index == 0.4, again.share > 0.0), (law.has_index(), law.has_yield_stress()));
        }
    }

    #[test]
    fn values_that_no_liquid_has_are_not_simulated() {
        let wild = FlowCurve::at(Law::HerschelBulkley, 0.0, &[3.0, -0.4]);
        assert_eq!((wild.index, wild.share), (1.0, 0.0));
        let parameters = FlowCurve::of(1.0, 0.1, 0.0).parameters(Law::HerschelBulkley, 0.2);
        assert!(parameters.iter().all(|one| one.step > 0.0), "{parameters:?}");
    }
}
