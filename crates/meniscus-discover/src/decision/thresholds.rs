//! Thresholds learnt from the references: an effect is significant beyond the gains of clean glasses.
//!
//! Each reference is judged by the others. Effect e lowers its cost (minus twice the logarithm of the
//! likelihood) by T_e although nothing is hidden. Were the model exact, T_e would be chi-squared with its p
//! free parameters. It is not, and its error resembles some effects more than others:
//! ```text
//! T_e ~ phi_e chi2_p,       phi_e = max(1, mean of T_e over n references / p)
//! T_e of the next clean glass / (p phi_e) ~ F(p, n p)
//! bound_e = p phi_e F_(1 - c/K)(p, n p),      c = 0.01 for all K effects together
//! ```
//! (overdispersion and its F test: McCullagh and Nelder 1989, 4.5; prediction bounds for one more of n:
//! Hahn and Meeker 1991, 4.) The fewer the references, the higher the bound: with K = 21 it is 22 phi of
//! twelve, 41 phi of six and 340 phi of three. F(1, n) is Student's t squared; the upper tail of F(2, 2n)
//! is `(1 + x/n)^-n`. The misfit has the bound of a normal ln(chi2/n), `m + t s sqrt(1 + 1/n)`; the square of
//! an offset at rest has that of an effect with one parameter.

use super::rank::Candidate;
use super::rules::DecisionRules;
use super::settings::Settings;
use crate::baseline::calibrate::Calibration;
use crate::baseline::group::Group;
use crate::fitting::error::ProblemError;
use crate::fitting::fit::{fit, fit_beside, free_of};
use crate::fitting::problem::Problem;
use crate::fitting::rest_offset::{Offset, RestOffset, rest_offsets};
use crate::fitting::search::search;
use crate::recordings::record::Quantity;
use meniscus::reduced::effects::Entry;
use meniscus_numerics::statistics::{f_exceeded, mean, student_t_exceeded, variance};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Thresholds that the references set.
#[derive(Clone, Debug, PartialEq)]
pub struct Thresholds {
    /// Least gain in BIC over none.
    pub gain: f64,
    /// Largest misfit a number beside an effect, whose formula is not exact.
    pub chi2: f64,
    /// The same where no effect is significant: what clean glasses show.
    pub clean_chi2: f64,
    /// Decrease of the cost that each effect has to reach beside the other effects; 0 where it is not given.
    pub bound: BTreeMap<&'static str, f64>,
    /// Largest square of an offset at rest, in units of its variance.
    pub offset: BTreeMap<Quantity, f64>,
    /// The same without references.
    pub unseen_offset: f64,
}

impl Default for Thresholds {
    fn default() -> Self {
        Self::without_references(&DecisionRules::default())
    }
}

impl Thresholds {
    /// Returns the thresholds that `rules` set before any reference.
    #[must_use]
    pub fn without_references(rules: &DecisionRules) -> Self {
        Self {
            gain: rules.min_gain,
            chi2: rules.min_misfit_limit,
            clean_chi2: rules.min_misfit_limit,
            unseen_offset: rules.unseen_offset_limit,
            bound: BTreeMap::new(),
            offset: BTreeMap::new(),
        }
    }

    /// Returns by how much the effect called `name` has to lower the cost.
    #[must_use]
    pub fn of(&self, name: &str) -> f64 {
        self.bound.get(name).copied().unwrap_or(0.0)
    }

    /// Returns whether the last effect of `candidate` lowers the cost by more than a clean glass lets it.
    #[must_use]
    pub fn clears(&self, candidate: &Candidate) -> bool {
        candidate.fitted.is_some() && candidate.fall >= self.of(candidate.last())
    }

    /// Returns the offset that exceeds those of clean glasses most; none where all are within them.
    #[must_use]
    pub fn beyond(&self, offsets: &[Offset]) -> Option<RestOffset> {
        let over =
            |o: &&Offset| o.square / self.offset.get(&o.quantity).copied().unwrap_or(self.unseen_offset);
        let most = offsets.iter().max_by(|a, b| over(a).total_cmp(&over(b)))?;
        (over(&most) > 1.0).then_some(RestOffset { quantity: most.quantity, m: most.m })
    }
}

/// Result of one reference when the others judge it.
#[derive(Clone, Debug)]
pub struct Shown {
    /// Decrease of the cost by each effect of the library.
    fall: Vec<f64>,
    /// Free parameters of each.
    parameters: Vec<usize>,
    /// Misfit a number without any effect.
    chi2: f64,
    /// Offsets at rest without any effect.
    offsets: Vec<Offset>,
}

/// Returns the thresholds that `groups` of references set: each in turn is judged by the others.
///
/// # Errors
/// [`ProblemError`], when a reference cannot be fitted.
pub fn thresholds(groups: &[&Group], settings: &Settings) -> Result<Thresholds, ProblemError> {
    let shown = shown(groups, settings)?;
    Ok(limits(&shown.iter().collect::<Vec<_>>(), settings))
}

/// Returns the result of each of `groups` when the others judge it.
///
/// # Errors
/// [`ProblemError`], when a reference cannot be fitted.
pub fn shown(groups: &[&Group], settings: &Settings) -> Result<Vec<Shown>, ProblemError> {
    let one = |(index, group): (usize, &&Group)| {
        let others: Vec<&Group> =
            groups.iter().enumerate().filter(|(i, _)| *i != index).map(|(_, g)| *g).collect();
        let records = &group.split.fitted;
        let calibration = Calibration::from(&others, records, settings.own_clocks_s);
        let problem =
            Problem::new(records, group.known, &calibration, settings.noise)?.with_cache(&settings.cache);
        let plain = fit(&problem, &problem.mean, &[], &[]);
        let fall = |entry: &&'static Entry| {
            let (_, from, _) = search(&problem, &plain, entry);
            (plain.cost - fit_beside(&problem, &plain, entry, &from).cost).max(0.0)
        };
        Ok(Shown {
            fall: settings.library.par_iter().map(fall).collect(),
            parameters: settings.library.iter().map(|entry| free_of(&problem, entry).len()).collect(),
            chi2: plain.chi2(problem.count()),
            offsets: rest_offsets(&problem, &plain),
        })
    };
    groups.iter().enumerate().map(one).collect()
}

/// Returns the thresholds from what references showed; with fewer than three of them the gain is raised instead.
#[must_use]
pub fn limits(shown: &[&Shown], settings: &Settings) -> Thresholds {
    let rules = &settings.rules;
    let mut limits = Thresholds::without_references(rules);
    let Some(first) = shown.first().filter(|_| shown.len() > 2) else {
        limits.gain *= rules.few_references_factor;
        return limits;
    };
    let chance = rules.false_name_rate / settings.library.len().max(1) as f64;
    for ((i, entry), parameters) in settings.library.iter().enumerate().zip(&first.parameters) {
        let falls: Vec<f64> = shown.iter().map(|one| one.fall[i]).collect();
        limits.bound.insert(entry.name, bound(&falls, *parameters, chance));
    }
    let misfits: Vec<f64> = shown.iter().map(|one| one.chi2.ln()).collect();
    limits.clean_chi2 = next(&misfits, rules.false_name_rate).exp();
    limits.chi2 = limits.chi2.max(limits.clean_chi2);
    for (i, offset) in first.offsets.iter().enumerate() {
        let squares: Vec<f64> = shown.iter().filter_map(|one| one.offsets.get(i)).map(|o| o.square).collect();
        let limit = bound(&squares, 1, rules.false_name_rate / first.offsets.len() as f64);
        limits.offset.insert(offset.quantity, limit);
    }
    limits
}

/// Returns the bound that T of an effect with `parameters` exceeds in one more clean glass with probability `chance`, after
/// references that showed `falls`.
#[must_use]
pub fn bound(falls: &[f64], parameters: usize, chance: f64) -> f64 {
    let (n, p) = (falls.len() as f64, parameters.max(1) as f64);
    let phi = (falls.iter().sum::<f64>() / (n * p)).max(1.0);
    p * phi * f_exceeded(chance, parameters.max(1), n * p)
}

/// Returns the bound that one more of `values` exceeds with probability `chance`, were they normal.
fn next(values: &[f64], chance: f64) -> f64 {
    let n = values.len() as f64;
    mean(values) + student_t_exceeded(chance, n - 1.0) * (variance(values) * (1.0 + 1.0 / n)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tails_are_those_of_the_tables() {
        // F(1, 6) of 1 %: 13.745; F(2, 8) of 1 %: 8.649.
        assert!((bound(&[1.0; 6], 1, 0.01) - 13.745).abs() < 2e-3);
        assert!((bound(&[2.0; 4], 2, 0.01) / 2.0 - 8.649).abs() < 2e-3);
        // Clean glasses that show less than chance does not lower the bound below chance's own.
        assert_eq!(bound(&[0.0; 6], 1, 0.01), bound(&[1.0; 6], 1, 0.01));
        assert!(bound(&[5.0; 12], 1, 0.01) < bound(&[5.0; 6], 1, 0.01));
    }

    #[test]
    fn one_more_exceeds_its_bound_as_often_as_it_says() {
        use meniscus_numerics::random::normal;
        use rand::SeedableRng;
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(3);
        let mut square = || 7.0 * normal(&mut random).powi(2);
        let chance = 0.05;
        const TRIALS: usize = 2000;
        let over = (0..TRIALS).filter(|_| {
            let seen: Vec<f64> = (0..7).map(|_| square()).collect();
            let next = square();
            let phi = (seen.iter().sum::<f64>() / 7.0).max(1.0);
            next > phi * 5.591
        });
        // t of 7 degrees at 2.5 % is 2.3646, squared 5.591.
        assert!((f_exceeded(chance, 1, 7.0) - 5.591).abs() < 2e-3);
        let share = over.count() as f64 / TRIALS as f64;
        assert!((share - chance).abs() < 0.015, "{share}");
    }
}
