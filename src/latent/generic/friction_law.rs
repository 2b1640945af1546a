//! Friction of a liquid whose viscosity depends on the rate of shear.
//!
//! A trained D is the friction at a typical rate of shear. With the rate g of the present motion, in units of that one, the step takes
//! phi D in its place, phi being the stress of Herschel and Bulkley (1926) over the rate:
//!
//! ```text
//! g^2   = p / p1 + e^2                        p = dH^T D dH, what D alone would make of the motion into heat, H/s
//! phi   = (1 - y) g^(n - 1) + y / g           n the flow index, y the share of the yield stress in the stress at g = 1
//! ```
//! p1 is p at the typical rate, and e the rate below which the viscosity does not rise any more: some part of a glass always moves
//! faster. p is taken at the discrete gradient dH of the very step, so that phi D dH is the slope of a potential of dissipation,
//! which is convex for n >= 0. As phi > 0 the heat phi p dt stays positive, and the step keeps its one solution
//! (see [`super::Generic`]).

use crate::math::{pow, sqrt};

/// Numbers of a law.
pub const LAW_NUMBERS: usize = 4;

/// Friction over that of the trained D, by the rate at which it makes heat.
///
/// ```
/// use meniscus::latent::generic::FrictionLaw;
///
/// // A liquid that thins: index 0.5, no yield stress, typical heat 2 H/s.
/// let law = FrictionLaw::new([2.0, 0.1, 0.0, 0.5]).expect("a law");
/// assert!((law.factor(2.0) - 1.0).abs() < 0.01);
/// assert!(law.factor(0.02) > 2.0 && law.factor(200.0) < 0.5);
/// // A negative index would let friction fall as the rate rises: refused.
/// assert!(FrictionLaw::new([2.0, 0.1, 0.0, -0.5]).is_none());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrictionLaw {
    /// p1, H/s.
    pub typical: f64,
    /// e, above zero.
    pub floor: f64,
    /// y, 0 to 1.
    pub yield_share: f64,
    /// n, 0 to 2.
    pub index: f64,
}

impl FrictionLaw {
    /// Returns the law of p1, e, y and n; `None` where a number is not finite or out of its range.
    #[must_use]
    pub fn new([typical, floor, yield_share, index]: [f64; LAW_NUMBERS]) -> Option<Self> {
        let sound = typical.is_finite()
            && typical > 0.0
            && floor.is_finite()
            && floor >= 1e-3
            && (0.0..=1.0).contains(&yield_share)
            && (0.0..=2.0).contains(&index);
        sound.then_some(Self { typical, floor, yield_share, index })
    }

    /// Returns p1, e, y and n.
    #[must_use]
    pub fn numbers(&self) -> [f64; LAW_NUMBERS] {
        [self.typical, self.floor, self.yield_share, self.index]
    }

    /// g^2 at p.
    fn rate_square(&self, p: f64) -> f64 {
        p.max(0.0) / self.typical + self.floor * self.floor
    }

    /// Returns phi at p, H/s; above zero.
    #[must_use]
    pub fn factor(&self, p: f64) -> f64 {
        let square = self.rate_square(p);
        (1.0 - self.yield_share) * pow(square, 0.5 * (self.index - 1.0)) + self.yield_share / sqrt(square)
    }

    /// Returns the slope of phi in p, s/H.
    #[must_use]
    pub fn slope(&self, p: f64) -> f64 {
        let square = self.rate_square(p);
        let power = 0.5 * (self.index - 1.0);
        let thins = (1.0 - self.yield_share) * power * pow(square, power - 1.0);
        (thins - 0.5 * self.yield_share / (square * sqrt(square))) / self.typical
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slope_is_that_of_the_factor() {
        let law = FrictionLaw::new([3.0, 0.2, 0.4, 0.6]).expect("a law");
        for p in [0.0, 0.1, 3.0, 50.0] {
            let h = 1e-6 * (1.0 + p);
            let slope = (law.factor(p + h) - law.factor(p)) / h;
            assert!((slope - law.slope(p)).abs() < 1e-3 * law.slope(p).abs(), "{slope} at {p}");
        }
    }

    /// The force phi(p) g never falls as the rate rises: the potential of dissipation is convex.
    #[test]
    fn the_force_rises_with_the_rate() {
        for (yield_share, index) in [(0.0, 0.0), (1.0, 0.5), (0.4, 0.4), (0.0, 1.7)] {
            let law = FrictionLaw::new([1.0, 0.05, yield_share, index]).expect("a law");
            let force = |rate: f64| rate * law.factor(rate * rate);
            let rates = (0..200).map(|k| 0.05 * f64::from(k));
            let forces: heapless::Vec<f64, 200> = rates.map(force).collect();
            assert!(forces.windows(2).all(|two| two[1] >= two[0]), "y {yield_share}, n {index}");
        }
    }

    #[test]
    fn a_newtonian_law_changes_nothing() {
        let law = FrictionLaw::new([1.0, 0.3, 0.0, 1.0]).expect("a law");
        assert_eq!((law.factor(0.0), law.factor(7.0), law.slope(2.0)), (1.0, 1.0, 0.0));
    }
}
