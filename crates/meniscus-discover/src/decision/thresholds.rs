//! Thresholds learnt from the references: an effect is significant beyond the gains of clean glasses.
//!
//! Each reference is judged by the others, under the covariance that a glass is first judged under: how much each effect
//! lowers its cost, its misfit, the largest cell of its map and its offsets at rest. `bounds` says what one more
//! clean glass may show. Nothing that was learnt here judges a fit under another covariance.

use super::bounds::{MisfitPrior, bound, misfit_bound, pooled};
use super::rank::Candidate;
use super::rules::DecisionRules;
use super::settings::Settings;
use crate::baseline::calibrate::Calibration;
use crate::baseline::group::Group;
use crate::fitting::error::ProblemError;
use crate::fitting::fit::{fit, fit_beside, free_of};
use crate::fitting::localise::{largest, localise};
use crate::fitting::problem::Problem;
use crate::fitting::rest_offset::{Offset, RestOffset, rest_offsets};
use crate::fitting::search::search;
use crate::recordings::record::Quantity;
use meniscus::reduced::effects::Entry;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Thresholds that the references set.
#[derive(Clone, Debug, PartialEq)]
pub struct Thresholds {
    /// References that set them.
    pub references: usize,
    /// Least gain in BIC over none.
    pub gain: f64,
    /// Largest misfit a number beside an effect, whose formula is not exact.
    pub chi2: f64,
    /// The same where no effect is significant: what clean glasses show.
    pub clean_chi2: f64,
    /// Largest misfit a number in one cell of the map where no effect is significant; infinite without references, of
    /// which the plain model's own error is not known.
    pub cell: f64,
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
            references: 0,
            gain: rules.min_gain,
            chi2: rules.min_misfit_limit,
            clean_chi2: rules.min_misfit_limit,
            cell: f64::INFINITY,
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
    /// Largest misfit a number of a cell of its map.
    cell: f64,
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
        let calibration = Calibration::from(&others, &group.known, records, settings.own_clocks_s);
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
            cell: largest(&localise(&problem, &plain)).map_or(1.0, |cell| cell.chi2),
            offsets: rest_offsets(&problem, &plain),
        })
    };
    groups.iter().enumerate().map(one).collect()
}

/// Prior of the misfit of a clean glass, and of the largest cell of its map.
const MISFIT: MisfitPrior = MisfitPrior { mean: 0.0, deviation: 0.1 };
const CELL: MisfitPrior = MisfitPrior { mean: 0.5, deviation: 0.35 };

/// References below which the gain is raised: their own clean glass was judged by none.
const FEW: usize = 2;

/// Returns the thresholds from what references showed. A single reference was judged by none of its kind, which says
/// nothing of how it is judged by one.
#[must_use]
pub fn limits(shown: &[&Shown], settings: &Settings) -> Thresholds {
    let rules = &settings.rules;
    let mut limits = Thresholds::without_references(rules);
    limits.references = shown.len();
    let shown = if shown.len() < FEW { &[] } else { shown };
    if shown.is_empty() {
        limits.gain *= rules.few_references_factor;
    }
    let parameters = |i: usize| shown.first().map_or(1, |one| one.parameters[i].max(1));
    let each = |one: &&Shown| -> Vec<f64> {
        one.fall.iter().enumerate().map(|(i, fall)| fall / parameters(i) as f64).collect()
    };
    let pooled = pooled(&shown.iter().map(each).collect::<Vec<_>>());
    let chance = rules.false_name_rate / settings.library.len().max(1) as f64;
    for (i, entry) in settings.library.iter().enumerate() {
        let falls: Vec<f64> = shown.iter().map(|one| one.fall[i]).collect();
        limits.bound.insert(entry.name, bound(&falls, parameters(i), pooled, chance));
    }
    let of = |value: fn(&Shown) -> f64| shown.iter().map(|one| value(one)).collect::<Vec<f64>>();
    limits.clean_chi2 = misfit_bound(&of(|one| one.chi2), MISFIT, rules.false_unknown_rate);
    limits.chi2 = limits.chi2.max(limits.clean_chi2);
    if !shown.is_empty() {
        limits.cell = misfit_bound(&of(|one| one.cell), CELL, rules.false_unknown_rate);
    }
    let channels = shown.first().map_or(&[][..], |one| &one.offsets);
    for (i, offset) in channels.iter().enumerate() {
        let squares: Vec<f64> = shown.iter().filter_map(|one| one.offsets.get(i)).map(|o| o.square).collect();
        let limit = bound(&squares, 1, 1.0, rules.false_unknown_rate / channels.len() as f64);
        limits.offset.insert(offset.quantity, limit);
    }
    limits
}
