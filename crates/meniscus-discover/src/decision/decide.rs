//! Decision from the fits to a verdict; the class is decided before the name.

use super::assessment::{Assessment, Search};
use super::choose::{Case, Choice, choose, not_confounded, significant, still_significant};
use super::evidence::{cross_validate, inclusion};
use super::rank::{Candidate, rank};
use super::settings::Settings;
use super::thresholds::Thresholds;
use super::verdict::{CellMisfit, Claim, Unknown, Verdict};
use crate::fitting::fit::{Fitted, fit};
use crate::fitting::localise::{Cell, largest, localise};
use crate::fitting::problem::Problem;
use crate::fitting::rest_offset::rest_offsets;
use meniscus::reduced::effects::find;

/// Ranks the effects of the library on `problem` and decides.
///
/// The bounds were learnt under the covariance of `problem`, so what is significant is decided under it. A formula is not
/// exact: the correction that the best effect makes says by how much. Under the covariance that holds its error too, the
/// significant effects are compared with each other; what does not stay ahead there is unknown, never nothing.
#[must_use]
pub fn decide(problem: &Problem, limits: &Thresholds, settings: &Settings) -> Assessment {
    let Settings { library, rules, .. } = settings;
    let count = problem.count();
    let first = fit(problem, &problem.mean, &[], &[]);
    let map = localise(problem, &first);
    let ranking = rank(problem, &first, library, first.bic(count));
    let Some(best) = significant(problem, &ranking, limits) else {
        let search = Search { plain: first.clone(), first, ranking, pairs: Vec::new(), count };
        let verdict = without_effect(problem, limits, &search, &map);
        return Assessment { search, verdict, map };
    };
    let cleared: Vec<&'static str> =
        ranking.iter().filter(|c| c.fall >= limits.of(c.last())).map(Candidate::last).collect();
    let Fitted { theta, active, .. } = &best.fitted;
    let inflated = problem.with_formula_error(theta, active, rules.formula_error(active)).ok();
    let (problem, plain, ranking) = match &inflated {
        Some(problem) => {
            let plain = fit(problem, &first.theta, &[], &[]);
            let ranking = rank(problem, &plain, library, plain.bic(count));
            (problem, plain, ranking)
        }
        None => (problem, first.clone(), ranking),
    };
    let mut search = Search { first, plain, ranking, pairs: Vec::new(), count };
    let case = Case { problem, limits, settings };
    let verdict = match still_significant(problem, &search.ranking, &cleared, limits) {
        Some(best) => {
            let choice = choose(&case, &mut search, best);
            judge(&case, &search, choice)
        }
        None => Verdict::Unknown(Unknown::NoSignificantEffect {
            misfit: search.first.chi2(count),
            best_gain: search.ranking.first().map_or(0.0, |best| best.gain),
            rest_offset: None,
            cell: largest(&map).map(CellMisfit::of),
        }),
    };
    Assessment { search, verdict, map }
}

/// Decides where no effect is significant: something may be missing all the same.
///
/// `none` needs the misfit, the offsets at rest and every cell of the map to be within what references show.
fn without_effect(problem: &Problem, limits: &Thresholds, search: &Search, map: &[Cell]) -> Verdict {
    let misfit = search.first.chi2(search.count);
    let best_gain = search.ranking.first().map_or(0.0, |best| best.gain);
    let rest_offset = limits.beyond(&rest_offsets(problem, &search.first));
    let cell = largest(map).filter(|cell| cell.chi2 > limits.cell).map(CellMisfit::of);
    if misfit > limits.clean_chi2 || rest_offset.is_some() || cell.is_some() {
        Verdict::Unknown(Unknown::NoSignificantEffect { misfit, best_gain, rest_offset, cell })
    } else {
        Verdict::None { references: limits.references, misfit, best_gain }
    }
}

/// Decides whether the choice is identified, ambiguous or unknown.
fn judge(case: &Case<'_>, search: &Search, choice: Choice) -> Verdict {
    let Case { problem, limits, settings } = *case;
    let Choice { fitted, rivals, is_pair } = choice;
    let rules = &settings.rules;
    let gain = rivals[0].gain;
    let misfit = fitted.chi2(search.count);
    let rest_offset = limits.beyond(&rest_offsets(problem, &fitted));
    let held_out = cross_validate(problem, &search.plain, &fitted);
    let inclusion = inclusion(problem, &rivals, &search.plain, settings.seed);

    // Rivals within the gap of their class are not distinguished from the winner, which is one of them.
    let class_of = |candidate: &Candidate| find(candidate.last()).map(|entry| entry.class);
    let class = class_of(&rivals[0]);
    let close = |rival: &&Candidate| gain - rival.gain < rules.min_gap(class_of(rival) == class);
    let near: Vec<&Candidate> = rivals.iter().filter(close).collect();
    let same_class = near.iter().all(|rival| class_of(rival) == class);

    let range_ends = range_ends(&fitted);
    let supported = inclusion >= rules.min_inclusion && held_out.improvement > 0.0 && range_ends.is_empty();
    let confounded = is_pair && !not_confounded(&fitted.active);
    let mut claim = Box::new(Claim {
        names: rivals[0].names.clone(),
        class: class.filter(|_| same_class && !is_pair),
        fitted,
        gain,
        misfit,
        inclusion,
        held_out,
        range_ends,
    });
    if misfit > limits.chi2 || rest_offset.is_some() {
        return Verdict::Unknown(Unknown::Unexplained { nearest: claim, rest_offset });
    }
    if confounded {
        return Verdict::Unknown(Unknown::PossiblyConfounded(claim));
    }
    if near.len() == 1 && supported {
        return Verdict::Identified(claim);
    }
    claim.names = distinct_names(&near);
    Verdict::Ambiguous(claim)
}

/// Returns the names of `candidates` in their order, each once.
fn distinct_names(candidates: &[&Candidate]) -> Vec<&'static str> {
    let mut names: Vec<&'static str> = Vec::new();
    for name in candidates.iter().flat_map(|candidate| &candidate.names) {
        if !names.contains(name) {
            names.push(name);
        }
    }
    names
}

/// Returns the free parameters of `fitted` that stand at the end of their range, in words.
fn range_ends(fitted: &Fitted) -> Vec<String> {
    let at_end = |(effect, which): &(usize, usize)| {
        let active = &fitted.active[*effect];
        let (parameter, value) = (&active.entry.parameters[*which], active.values[*which]);
        let (least, largest) = parameter.range;
        let near = 1e-6 * (largest - least);
        (value <= least + near.min(1e-9) || value >= largest - near).then(|| {
            format!(
                "the {} of {} stands at the end of its range of {least} to {largest}{}{}",
                parameter.name,
                active.entry.name,
                if parameter.unit == "1" { "" } else { " " },
                parameter.unit.trim_start_matches('1')
            )
        })
    };
    fitted.free.iter().filter_map(at_end).collect()
}
