//! From sums to probabilities.
//!
//! ```text
//! p(z | k, kappa) = prod_n [kappa^2 S_k]^(-g/2) exp(-g q_k / (2 kappa^2))
//! p(z | k)        = int p(z | k, kappa) N(ln kappa; 0, s_k) d ln kappa                liquid k
//! p(z | none)     = 1/K sum_k int p(z | k, kappa) U(ln kappa; 0, ln 20) d ln kappa    one that k predicts badly
//! P(k)            = p(z | k) / [sum_j p(z | j) + p(z | none)]                         equal priors
//! ```
//! The power g counts the independent numbers of a profile and not its points, because neighbouring errors go together:
//! a fractional power keeps a likelihood that takes them for independent from being too sure (Miller and Dunson, J. Am.
//! Stat. Assoc. 114 (2019) 1113; the number of independent ones of a series: Bayley and Hammersley, J. R. Stat. Soc.
//! Suppl. 8 (1946) 184). That an oscillator misses more on one recording of its own liquid than on the next is the scatter s.
//! `None` needs no threshold: it is a hypothesis that spreads over all residuals from the expected one to twenty times
//! as much, and wins where the residual of every liquid is larger than its own scatter explains (Bayes factors: Kass and
//! Raftery, J. Am. Stat. Assoc. 90 (1995) 773).

use super::evidence::{Calibration, Evidence};
use crate::math::{exp, ln};
use core::ops::Range;

/// Places of ln kappa at which the integrals are taken, by the midpoint rule.
const PLACES: u32 = 64;

/// The largest miss that `none` expects, over what is due.
const WORST: f64 = 20.0;

/// Standard deviations of ln kappa to each side that the integral of a known liquid takes in.
const REACH: f64 = 4.0;

/// Result of a recognition beside the probabilities.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Verdict {
    /// The most probable liquid; nothing where `none` is more probable than each.
    pub best: Option<usize>,
    /// Probability that it is none of them.
    pub none: f64,
    /// Profiles that this rests on.
    pub profiles: u32,
}

/// The mean over `ln kappa` at the middles of [`PLACES`] equal parts of `range` of the likelihood times `weight`, as
/// a logarithm.
fn ln_mean(evidence: &Evidence, numbers: f64, range: Range<f64>, weight: impl Fn(f64) -> f64) -> f64 {
    let Range { start: from, end: to } = range;
    let place = |i: u32| from + (to - from) * (f64::from(i) + 0.5) / f64::from(PLACES);
    let at = |i: u32| evidence.ln_likelihood(numbers, place(i)) + weight(place(i));
    ln_sum((0..PLACES).map(at)) - ln(f64::from(PLACES))
}

/// ln sum exp of `terms`, safe from overflow.
fn ln_sum(terms: impl Iterator<Item = f64> + Clone) -> f64 {
    let most = terms.clone().fold(f64::NEG_INFINITY, f64::max);
    if most == f64::NEG_INFINITY {
        return most;
    }
    most + ln(terms.map(|term| exp(term - most)).sum())
}

/// ln p(z | k).
fn known(evidence: &Evidence, numbers: f64, scatter: f64) -> f64 {
    let s = scatter.max(1e-3);
    // N(ln kappa; 0, s) times the width of the interval, so that a mean is an integral; what lies outside is 6e-5.
    let constant = ln(2.0 * REACH / sqrt_tau());
    ln_mean(evidence, numbers, -REACH * s..REACH * s, |t| constant - 0.5 * t * t / (s * s))
}

/// sqrt(2 pi).
fn sqrt_tau() -> f64 {
    crate::math::sqrt(core::f64::consts::TAU)
}

/// ln of the part of p(z | none) that rests on one of the liquids.
fn unknown(evidence: &Evidence, numbers: f64) -> f64 {
    ln_mean(evidence, numbers, 0.0..ln(WORST), |_| 0.0)
}

/// The probabilities of the liquids whose calibrations and sums are `rivals`, into `probabilities` (as many), and what
/// else there is to say. Without any evidence all are equal.
///
/// ```
/// use meniscus::identify::{Calibration, Evidence, posterior};
///
/// let usual = Calibration { scale: 0.1, scatter: 0.2, numbers: 0.5 };
/// // One liquid has residuals of the expected size, the other four times as large.
/// let sums = [1.0, 4.0].map(|kappa: f64| {
///     let mut evidence = Evidence::default();
///     (0..80).for_each(|_| evidence.add(kappa * kappa * 1e-6, 1e-6));
///     evidence
/// });
/// let mut probabilities = [0.0; 2];
/// let verdict = posterior(sums.iter().map(|sum| (&usual, sum)), &mut probabilities);
/// assert_eq!(verdict.best, Some(0));
/// assert!((probabilities.iter().sum::<f64>() + verdict.none - 1.0).abs() < 1e-12);
/// ```
pub fn posterior<'e>(
    rivals: impl Iterator<Item = (&'e Calibration, &'e Evidence)> + Clone,
    probabilities: &mut [f64],
) -> Verdict {
    let count = rivals.clone().count();
    // The same power for all hypotheses, the most cautious one: they speak of the same profiles.
    let numbers = rivals.clone().map(|(calibration, _)| calibration.numbers).fold(f64::INFINITY, f64::min);
    let numbers = if numbers.is_finite() { numbers.max(0.0) } else { 0.0 };
    let profiles = rivals.clone().map(|(_, evidence)| evidence.profiles).max().unwrap_or(0);
    let likelihood =
        |(calibration, evidence): (&Calibration, &Evidence)| known(evidence, numbers, calibration.scatter);
    let none =
        ln_sum(rivals.clone().map(|(_, evidence)| unknown(evidence, numbers))) - ln(count.max(1) as f64);
    let total = ln_sum(rivals.clone().map(likelihood).chain(core::iter::once(none)));
    if total == f64::NEG_INFINITY || total.is_nan() {
        probabilities.fill(0.0);
        return Verdict { best: None, none: 1.0, profiles };
    }
    let none = exp(none - total);
    let mut best = (None, none);
    for ((index, slot), rival) in probabilities.iter_mut().enumerate().zip(rivals) {
        *slot = exp(likelihood(rival) - total);
        if *slot > best.1 {
            best = (Some(index), *slot);
        }
    }
    Verdict { best: best.0, none, profiles }
}

#[cfg(test)]
mod tests {
    use super::*;

    const USUAL: Calibration = Calibration { scale: 0.1, scatter: 0.2, numbers: 0.5 };

    /// `profiles` frames that each missed by `kappa` times what was due.
    fn missed(kappa: f64, profiles: u32) -> Evidence {
        let mut evidence = Evidence::default();
        (0..profiles).for_each(|_| evidence.add(kappa * kappa * 1e-6, 1e-6));
        evidence
    }

    fn of(kappas: &[f64], profiles: u32) -> (heapless::Vec<f64, 8>, Verdict) {
        let sums: heapless::Vec<Evidence, 8> = kappas.iter().map(|&k| missed(k, profiles)).collect();
        let mut p: heapless::Vec<f64, 8> = kappas.iter().map(|_| 0.0).collect();
        let verdict = posterior(sums.iter().map(|e| (&USUAL, e)), &mut p);
        (p, verdict)
    }

    #[test]
    fn the_liquid_that_misses_as_usual_wins_and_all_sum_to_one() {
        let (p, verdict) = of(&[2.0, 1.0, 4.0], 80);
        assert_eq!(verdict.best, Some(1));
        assert!(p[1] > 0.9 && p[0] < 0.05, "{p:?}");
        assert!((p.iter().sum::<f64>() + verdict.none - 1.0).abs() < 1e-12);
    }

    #[test]
    fn none_where_all_miss_by_far_more_than_they_scatter() {
        let (p, verdict) = of(&[3.0, 5.0, 9.0], 80);
        assert_eq!(verdict.best, None);
        assert!(verdict.none > 0.95, "{p:?} {verdict:?}");
        // Half as much again is within what recordings of one liquid differ by.
        assert_eq!(of(&[1.3, 5.0, 9.0], 80).1.best, Some(0));
    }

    #[test]
    fn nothing_seen_says_nothing_and_more_seen_says_more() {
        let (p, verdict) = of(&[1.0, 2.0, 3.0], 0);
        assert!(p.iter().all(|p| (p - 0.25).abs() < 1e-3) && (verdict.none - 0.25).abs() < 1e-3, "{p:?}");
        let (few, many) = (of(&[1.0, 1.4], 5).0, of(&[1.0, 1.4], 50).0);
        assert!(few[0] > 0.34 && many[0] > few[0], "{few:?} {many:?}");
    }

    /// The integral against its closed form: with g n = 2 nu numbers at kappa = 1 the likelihood over ln kappa is
    /// Gamma(nu)/2 (nu q)^-nu for a flat weight over all ln kappa.
    #[test]
    fn the_integral_is_that_of_the_gamma_function() {
        let evidence = missed(4.0, 40);
        let numbers = 0.5;
        let nu = 0.5 * numbers * 40.0;
        let ln_gamma: f64 = (1..10).map(|n| ln(f64::from(n))).sum();
        let due =
            ln_gamma - ln(2.0) - nu * ln(0.5 * numbers * evidence.square) - 0.5 * numbers * evidence.log;
        let got = unknown(&evidence, numbers) + ln(ln(WORST));
        assert!((got - due).abs() < 1e-3, "{got} against {due}");
    }

    #[test]
    fn a_liquid_that_ran_away_does_not_spoil_the_rest() {
        let mut wild = Evidence::default();
        (0..80).for_each(|_| wild.add(f64::NAN, 1e-6));
        let sums = [missed(1.0, 80), wild];
        let mut p = [0.0; 2];
        let verdict = posterior(sums.iter().map(|e| (&USUAL, e)), &mut p);
        assert_eq!(verdict.best, Some(0), "{p:?} {verdict:?}");
    }
}
