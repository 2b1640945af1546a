//! Numbers of a drawn law, and the curves that they stand for.
//!
//! ```text
//! f(a) = K A sum_i c_i hat_i(a/A)              straight lines between the heights of the hats, f(0) = 0
//! D(u) = S sum_j d_j hat_j(u/u_1),  d_j >= 0   straight lines between the rates of the hats, D(0) = 0, S = K A/5
//! ```
//! `A` is the largest height that was measured, `K = m w^2` and `u_1 = w A` are those of the plain first mode. Hats that are
//! not negative make a drag that is not negative. The force has hats on either side, so that it may be lopsided. In units of
//! K A a number of one is a force as large as gravity's own. The prior is normal: sizes are wide, and bends cost, so that the
//! curve is smooth where the recordings say nothing else.

use crate::baseline::predict::reduced_model;
use crate::recordings::record::{Quantity, Record};
use crate::recordings::stated::Known;
use meniscus::reduced::{DrawnLaw, LAW_HEIGHTS, LAW_RATES, LawTables};

/// Heights of the hats of the force, in units of the largest; zero between them has no hat.
const HEIGHTS: [f64; 14] =
    [-1.0, -0.8, -0.6, -0.42, -0.27, -0.15, -0.06, 0.06, 0.15, 0.27, 0.42, 0.6, 0.8, 1.0];

/// Number of hats of the force.
pub const SPRINGS: usize = HEIGHTS.len();

/// Rates of the hats of the drag, in units of the fastest.
const RATES: [f64; 7] = [0.05, 0.12, 0.22, 0.37, 0.55, 0.77, 1.0];

/// Numbers of a law: hats of the force, then those of the drag.
pub const NUMBERS: usize = SPRINGS + RATES.len();

/// Standard deviation of a hat of the force over its height, and of a bend of the force over unit distance.
const STIFFNESS_DEVIATION: f64 = 0.6;
const FORCE_BEND_DEVIATION: f64 = 1.0;

/// Standard deviation of a hat of the drag, and of a bend of the drag over unit distance.
const DRAG_DEVIATION: f64 = 2.0;
const DRAG_BEND_DEVIATION: f64 = 1.0;

/// Part of K A that is the unit of the drag: a damping of a tenth of the critical one makes a drag of it.
const DRAG_UNIT: f64 = 0.2;

/// Part by which the tables go beyond the largest measured height.
const BEYOND: f64 = 1.05;

/// Extents and units of a drawn law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// Largest height A, m.
    pub reach_m: f64,
    /// Largest rate u_1, m/s.
    pub fastest_m_s: f64,
    /// Unit of the conservative force K A, N.
    pub spring_n: f64,
}

impl Extent {
    /// Returns the extent of what `records` of the liquid `known` show; none without a slope of the surface.
    #[must_use]
    pub fn of(records: &[Record], known: &Known, theta: &[f64]) -> Option<Self> {
        let interval_s = records.first()?.interval_s;
        let slopes = records.iter().flat_map(|r| &r.channels).filter(|c| c.quantity == Quantity::Slope);
        let largest = slopes.flat_map(|c| &c.value).flatten().fold(0.0_f64, |m, z| m.max(z.abs()));
        let model = reduced_model(known, theta, &[], interval_s);
        let (reach_m, w) = (BEYOND * largest, model.frequency());
        let spring_n = model.mass_kg() * w * w * reach_m;
        (reach_m > 0.0).then_some(Self { reach_m, fastest_m_s: w * reach_m, spring_n })
    }

    /// Returns the heights of the table of the conservative force, m.
    #[must_use]
    pub fn heights_m(&self) -> [f64; LAW_HEIGHTS] {
        let middle = (LAW_HEIGHTS / 2) as f64;
        std::array::from_fn(|i| self.reach_m * (i as f64 / middle - 1.0))
    }

    /// Returns the rates of the table of the drag, m/s.
    #[must_use]
    pub fn rates_m_s(&self) -> [f64; LAW_RATES] {
        std::array::from_fn(|i| self.fastest_m_s * i as f64 / (LAW_RATES - 1) as f64)
    }

    /// Returns the tables of the law with these `numbers`.
    #[must_use]
    pub fn tables(&self, numbers: &[f64]) -> LawTables {
        let (springs, hats) = numbers.split_at(SPRINGS);
        let (at, value) = force_nodes(springs);
        let force = |height_m: f64| self.spring_n * between(&at, &value, height_m / self.reach_m);
        let (at, value) = drag_nodes(hats);
        let drag = |rate: f64| DRAG_UNIT * self.spring_n * between(&at, &value, rate / self.fastest_m_s);
        LawTables {
            reach_m: self.reach_m,
            force_n: self.heights_m().map(force),
            fastest_m_s: self.fastest_m_s,
            drag_n: self.rates_m_s().map(drag),
        }
    }

    /// Returns the law with these `numbers`; none where one is not finite or a hat negative.
    #[must_use]
    pub fn law(&self, numbers: &[f64]) -> Option<DrawnLaw> {
        DrawnLaw::new(self.tables(numbers))
    }
}

/// Returns the nodes of the force with these hats, and its values there: zero at rest.
fn force_nodes(springs: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let middle = SPRINGS / 2;
    let (mut at, mut value) = (HEIGHTS.to_vec(), springs.to_vec());
    at.insert(middle, 0.0);
    value.insert(middle, 0.0);
    (at, value)
}

/// Returns the nodes of the drag with these hats, and its values there: zero at rest.
fn drag_nodes(hats: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let with_rest = |all: &[f64]| std::iter::once(0.0).chain(all.iter().copied()).collect();
    (with_rest(&RATES), with_rest(hats))
}

/// Returns the straight lines through `value` at the nodes `at`, at `place`.
fn between(at: &[f64], value: &[f64], place: f64) -> f64 {
    let next = at.iter().position(|node| *node >= place).unwrap_or(at.len() - 1).max(1);
    let part = ((place - at[next - 1]) / (at[next] - at[next - 1])).clamp(0.0, 1.0);
    value[next - 1] + (value[next] - value[next - 1]) * part
}

/// Returns the bends of the straight lines through `value` at the nodes `at`: the change of the slope over the root of the
/// distance of its middles, whose prior is the same for any nodes (a Wiener process of the slope).
fn bends(at: &[f64], value: &[f64]) -> Vec<f64> {
    let slope = |i: usize| (value[i + 1] - value[i]) / (at[i + 1] - at[i]);
    let bend = |i: usize| (slope(i + 1) - slope(i)) / (0.5 * (at[i + 2] - at[i])).sqrt();
    (0..at.len() - 2).map(bend).collect()
}

/// Simple law from which a fit starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SimpleLaw {
    /// Stiffness in units of gravity's.
    pub stiffness: f64,
    /// Coefficient of the cube of the height.
    pub hardening: f64,
    /// Hat of the fastest rate; the drag grows straight with the rate.
    pub drag: f64,
}

impl SimpleLaw {
    /// Returns its numbers.
    #[must_use]
    pub fn numbers(&self) -> Vec<f64> {
        let spring = HEIGHTS.map(|x| self.stiffness * x + self.hardening * x * x * x);
        spring.into_iter().chain(RATES.map(|rate| self.drag * rate)).collect()
    }
}

/// Least value of each number.
#[must_use]
pub fn least() -> [f64; NUMBERS] {
    std::array::from_fn(|i| if i < SPRINGS { f64::NEG_INFINITY } else { 0.0 })
}

/// Returns the residuals of the prior in standard deviations: sizes, then bends. The drag may begin with a jump at rest, as dry
/// friction does, so that its first bend is free.
#[must_use]
pub fn prior(numbers: &[f64]) -> Vec<f64> {
    let (springs, hats) = numbers.split_at(SPRINGS);
    let sizes = springs.iter().zip(HEIGHTS).map(|(c, x)| c / (STIFFNESS_DEVIATION * x.abs()));
    let drags = hats.iter().map(|d| d / DRAG_DEVIATION);
    let (at, value) = force_nodes(springs);
    let force = bends(&at, &value).into_iter().map(|bend| bend / FORCE_BEND_DEVIATION);
    let drag = bends(&RATES, hats).into_iter().map(|bend| bend / DRAG_BEND_DEVIATION);
    sizes.chain(drags).chain(force).chain(drag).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const EXTENT: Extent = Extent { reach_m: 0.01, fastest_m_s: 0.2, spring_n: 0.5 };

    #[test]
    fn the_curves_are_those_of_the_formulas() {
        let simple = SimpleLaw { stiffness: 0.2, hardening: 0.0, drag: 0.7 };
        let tables = EXTENT.tables(&simple.numbers());
        for (height, force) in EXTENT.heights_m().into_iter().zip(tables.force_n) {
            assert!((force - 0.5 * 0.2 * height / 0.01).abs() < 1e-12, "{height}: {force}");
        }
        for (rate, drag) in EXTENT.rates_m_s().into_iter().zip(tables.drag_n) {
            assert!((drag - 0.2 * 0.5 * 0.7 * rate / 0.2).abs() < 1e-12, "{rate}: {drag}");
        }
        // Straight curves have no bend, and a kink has one.
        let straight = prior(&simple.numbers());
        assert!(straight[NUMBERS..].iter().all(|bend| bend.abs() < 1e-9), "{straight:?}");
        let mut kinked = simple.numbers();
        kinked[SPRINGS - 1] += 0.1;
        assert!(prior(&kinked)[NUMBERS..].iter().any(|bend| bend.abs() > 0.5));
        // A lopsided force stays so.
        let mut lopsided = vec![0.0; NUMBERS];
        lopsided[SPRINGS - 1] = 1.0;
        let force = EXTENT.tables(&lopsided).force_n;
        assert!(force[32] == 0.5 && force[0] == 0.0 && force[16] == 0.0, "{force:?}");
    }

    #[test]
    fn hats_that_are_not_negative_make_a_drag_that_is_not() {
        for i in 0..RATES.len() {
            let mut numbers = [0.0; NUMBERS];
            numbers[SPRINGS + i] = 0.4;
            assert!(EXTENT.law(&numbers).is_some());
            numbers[SPRINGS + i] = -0.4;
            assert!(EXTENT.law(&numbers).is_none(), "hat {i}");
        }
        assert!(least().iter().skip(SPRINGS).all(|l| *l == 0.0));
    }
}
