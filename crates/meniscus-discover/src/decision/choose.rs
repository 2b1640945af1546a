//! Choice of the effect, or of two: each has to lower the cost by more than clean glasses let it.

use super::assessment::Search;
use super::rank::{Candidate, rank};
use super::settings::Settings;
use super::thresholds::Thresholds;
use crate::fitting::fit::{Fitted, fit_beside};
use crate::fitting::problem::Problem;
use meniscus::reduced::effects::{Active, Entry, find};

/// Problem that is decided, with everything that decides it.
#[derive(Clone, Copy)]
pub(super) struct Case<'a> {
    pub(super) problem: &'a Problem,
    pub(super) limits: &'a Thresholds,
    pub(super) settings: &'a Settings,
}

/// Significant candidate of a ranking.
pub(super) struct Significant {
    /// Its index in the ranking.
    pub(super) index: usize,
    /// Its fit.
    pub(super) fitted: Fitted,
}

/// Chosen candidate with its rivals.
pub(super) struct Choice {
    /// Fit of the chosen candidate.
    pub(super) fitted: Fitted,
    /// The chosen candidate, then its rivals.
    pub(super) rivals: Vec<Candidate>,
    /// Whether two effects are chosen.
    pub(super) is_pair: bool,
}

/// Returns the first of `ranking` that gains enough and clears its bound, also beside each better one that does not.
///
/// A better candidate that does not clear its own bound may be what clean glasses show.
pub(super) fn significant(
    problem: &Problem,
    ranking: &[Candidate],
    limits: &Thresholds,
) -> Option<Significant> {
    let index = ranking.iter().position(|c| c.gain >= limits.gain && limits.clears(c))?;
    let (name, fitted) = (ranking[index].last(), ranking[index].fitted.as_ref()?);
    let active = fitted.active.last()?;
    let holds = |better: &Candidate| {
        let Some(base) = &better.fitted else { return true };
        base.cost - fit_beside(problem, base, active.entry, active).cost >= limits.of(name)
    };
    ranking[..index].iter().all(holds).then(|| Significant { index, fitted: fitted.clone() })
}

/// Returns the first of `ranking`, under the error of a formula, that was `cleared` before that error was added and gains
/// enough, also beside each better one that was not.
///
/// No bound was learnt under this covariance, so the gain alone decides.
pub(super) fn still_significant(
    problem: &Problem,
    ranking: &[Candidate],
    cleared: &[&'static str],
    limits: &Thresholds,
) -> Option<Significant> {
    let stays = |c: &Candidate| c.gain >= limits.gain && c.fitted.is_some() && cleared.contains(&c.last());
    let index = ranking.iter().position(stays)?;
    let fitted = ranking[index].fitted.as_ref()?;
    let active = fitted.active.last()?;
    let holds = |better: &Candidate| {
        let Some(base) = &better.fitted else { return true };
        base.cost - fit_beside(problem, base, active.entry, active).cost >= limits.gain
    };
    ranking[..index].iter().all(holds).then(|| Significant { index, fitted: fitted.clone() })
}

/// Chooses the significant single effect, or the pair with a second one, or the second one alone.
///
/// It is the pair where each of the two lowers the cost beside the other by more than clean glasses let it, and the
/// second alone where only the second does. The pairs are kept in `search`.
pub(super) fn choose(case: &Case<'_>, search: &mut Search, best: Significant) -> Choice {
    let Case { problem, settings, .. } = *case;
    let none = search.plain.bic(search.count);
    search.pairs = rank(problem, &best.fitted, &settings.library, none);
    let single = &search.ranking[best.index];
    match chosen_pair(case, search, single, none) {
        Some(choice) => choice,
        None => Choice { fitted: best.fitted, rivals: search.ranking[best.index..].to_vec(), is_pair: false },
    }
}

/// Returns the choice of the best pair that clears its bound, or of its second effect; none where the single one stays.
fn chosen_pair(case: &Case<'_>, search: &Search, single: &Candidate, none: f64) -> Option<Choice> {
    let Case { problem, limits, settings } = *case;
    let rules = &settings.rules;
    let first = search.pairs.iter().position(|pair| limits.clears(pair))?;
    let pair = &search.pairs[first];
    let both = pair.fitted.as_ref()?;
    let entries: Vec<&Entry> = pair.names.iter().filter_map(|name| find(name)).collect();
    let share = rules.second_share(&entries);
    if pair.gain - single.gain <= limits.gain.max(rules.min_gap_other_class).max(share * single.gain) {
        return None;
    }
    let second = both.active.last()?;
    let fitted = fit_beside(problem, &search.plain, second.entry, second);
    if fitted.cost - both.cost >= limits.of(single.last()) {
        let mut rivals = search.pairs[first..].to_vec();
        rivals.extend(substituted_pairs(case, search, single, second, none));
        return Some(Choice { fitted: both.clone(), rivals, is_pair: true });
    }
    let name = second.entry.name;
    let own = Candidate {
        names: vec![name],
        gain: none - fitted.bic(search.count),
        fall: search.plain.cost - fitted.cost,
        signature: pair.signature.clone(),
        fitted: Some(fitted.clone()),
    };
    let others = search.ranking.iter().filter(|c| c.last() != name && c.last() != single.last()).cloned();
    let rivals = std::iter::once(own).chain(others).collect();
    Some(Choice { fitted, rivals, is_pair: false })
}

/// Returns the pairs of `second` with each effect that alone is not distinguished from `first`.
fn substituted_pairs(
    case: &Case<'_>,
    search: &Search,
    first: &Candidate,
    second: &Active,
    none: f64,
) -> Vec<Candidate> {
    let problem = case.problem;
    let pair = |other: &Candidate| {
        let base = other.fitted.as_ref()?;
        let fitted = fit_beside(problem, base, second.entry, second);
        Some(Candidate {
            names: vec![other.last(), second.entry.name],
            gain: none - fitted.bic(problem.count()),
            fall: base.cost - fitted.cost,
            fitted: Some(fitted),
            signature: other.signature.clone(),
        })
    };
    let near = |other: &&Candidate| {
        other.last() != first.last()
            && other.last() != second.entry.name
            && first.gain - other.gain < case.settings.rules.min_gap_same_class
    };
    search.ranking.iter().filter(near).filter_map(pair).collect()
}

/// Returns whether `active`, if they are two, can be claimed together.
///
/// They can where one happens in the liquid and the other is geometry, which rest frames and the tracked glass show
/// without the waves. Any other two may stand for a single one that the library lacks: a viscosity and a lift for a
/// viscoelastic liquid, a gain and a fill for a scale.
pub(super) fn not_confounded(active: &[Active]) -> bool {
    let [one, other] = active else { return true };
    let (one, other) = (one.entry, other.entry);
    (one.is_geometry() && other.class.in_liquid()) || (other.is_geometry() && one.class.in_liquid())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_liquid_effect_and_a_geometry_effect_are_claimed_together() {
        let active = |name: &str| {
            let entry = find(name).expect("in the library");
            Active { entry, values: entry.neutral() }
        };
        let both = |one: &str, other: &str| not_confounded(&[active(one), active(other)]);
        assert!(both("yield_stress", "camera_pitch") && both("camera_pitch", "yield_stress"));
        assert!(!both("viscosity", "foam"), "both in the liquid");
        assert!(!both("actuation_gain", "depth_scale"), "both geometry");
        assert!(not_confounded(&[active("foam")]), "a single one");
    }
}
