//! Which effect is said, or which two: each has to lower the cost by more than clean glasses let it.

use super::decision_rules::DecisionRules;
use super::fit::{Fitted, fit_beside};
use super::problem::Problem;
use super::rank::{Candidate, rank};
use super::settings::Settings;
use super::thresholds::Thresholds;
use super::verdict::Verdict;
use meniscus::reduced::effects::{Active, Entry, find};

/// What is said, and what it has to be told apart from.
pub(super) struct Choice {
    /// The chosen fit.
    pub(super) fitted: Fitted,
    /// The chosen candidate, then its rivals.
    pub(super) rivals: Vec<Candidate>,
    /// Whether two effects are said.
    pub(super) two: bool,
}

/// The first of `ranking` that gains enough, clears its bound, and clears it too beside each better one that
/// does not: what looks like an effect may be what clean glasses show.
pub(super) fn believed(problem: &Problem, ranking: &[Candidate], limits: &Thresholds) -> Option<usize> {
    let place = ranking.iter().position(|c| c.gain >= limits.gain && limits.clears(c))?;
    let (name, fitted) = (ranking[place].last(), ranking[place].fitted.as_ref()?);
    let active = fitted.active.last()?;
    let holds = |better: &Candidate| {
        let Some(base) = &better.fitted else { return true };
        base.cost - fit_beside(problem, base, active.entry, active).cost >= limits.of(name)
    };
    ranking[..place].iter().all(holds).then_some(place)
}

/// The believed single effect, or the pair with a second one where each lowers the cost beside the other by
/// more than clean glasses let it; where only the second does, the second alone.
pub(super) fn choose(
    problem: &Problem,
    limits: &Thresholds,
    settings: &Settings,
    verdict: &mut Verdict,
    place: usize,
) -> Option<Choice> {
    let none = verdict.plain.bic(verdict.count);
    let best = verdict.ranking[place].clone();
    let single = best.fitted.clone()?;
    verdict.pairs = rank(problem, &single, &settings.library, none);
    let alone = Choice { fitted: single.clone(), rivals: verdict.ranking[place..].to_vec(), two: false };
    let Some(first) = verdict.pairs.iter().position(|pair| limits.clears(pair)) else { return Some(alone) };
    let pair = verdict.pairs[first].clone();
    let Some(both) = &pair.fitted else { return Some(alone) };
    let entries: Vec<&Entry> = pair.names.iter().filter_map(|name| find(name)).collect();
    let share = settings.rules.second_share(&entries);
    if pair.gain - best.gain <= limits.gain.max(settings.rules.min_gap_other_class).max(share * best.gain) {
        return Some(alone);
    }
    let second = both.active.last()?;
    let fitted = fit_beside(problem, &verdict.plain, second.entry, second);
    if fitted.cost - both.cost >= limits.of(best.last()) {
        let mut rivals = verdict.pairs[first..].to_vec();
        rivals.extend(stand_ins(problem, &settings.rules, &verdict.ranking, &best, second, none));
        return Some(Choice { fitted: both.clone(), rivals, two: true });
    }
    let name = second.entry.name;
    let own = Candidate {
        names: vec![name],
        gain: none - fitted.bic(verdict.count),
        fall: verdict.plain.cost - fitted.cost,
        signature: pair.signature.clone(),
        fitted: Some(fitted.clone()),
    };
    let others = verdict.ranking.iter().filter(|c| c.last() != name && c.last() != best.last()).cloned();
    let rivals = std::iter::once(own).chain(others).collect();
    Some(Choice { fitted, rivals, two: false })
}

/// Pairs with the same `second` in which another effect stands in the place of `first`: whatever alone is not
/// told apart from the first.
fn stand_ins(
    problem: &Problem,
    rules: &DecisionRules,
    ranking: &[Candidate],
    first: &Candidate,
    second: &Active,
    plain: f64,
) -> Vec<Candidate> {
    let pair = |other: &Candidate| {
        let base = other.fitted.as_ref()?;
        let fitted = fit_beside(problem, base, second.entry, second);
        Some(Candidate {
            names: vec![other.last(), second.entry.name],
            gain: plain - fitted.bic(problem.count()),
            fall: base.cost - fitted.cost,
            fitted: Some(fitted),
            signature: other.signature.clone(),
        })
    };
    let near = |other: &&Candidate| {
        other.last() != first.last()
            && other.last() != second.entry.name
            && first.gain - other.gain < rules.min_gap_same_class
    };
    ranking.iter().filter(near).filter_map(pair).collect()
}

/// Whether `active`, if they are two, can be believed together: one happens in the liquid, the other is geometry,
/// which rest frames and the tracked glass show without the waves. Any other two may be making up for a single
/// one that the library lacks: a viscosity and a lift for a viscoelastic liquid, a gain and a fill for a scale.
pub(super) fn stand_apart(active: &[Active]) -> bool {
    let [one, other] = active else { return true };
    let (one, other) = (one.entry, other.entry);
    (one.is_geometry() && other.class.in_liquid()) || (other.is_geometry() && one.class.in_liquid())
}
