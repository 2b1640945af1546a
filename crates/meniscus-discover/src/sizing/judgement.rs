//! Verdict in the end, from that of the reduced model and the comparison of its candidates by the simulator.

use super::outcome::{Change, SizedCandidate};
use crate::decision::verdict::Verdict;

/// Verdict behind a comparison by the simulator.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Judgement {
    /// Verdict in one word of the file format: `named`, `tied` or `unknown`.
    pub word: &'static str,
    /// Names that are left; of an unknown verdict those that are nearest.
    pub names: Vec<&'static str>,
    /// Change of the verdict.
    pub change: Change,
}

impl Judgement {
    fn new(word: &'static str, names: &[&'static str], change: Change) -> Self {
        Self { word, names: names.to_vec(), change }
    }
}

/// Candidates that the simulator compared.
#[derive(Clone, Copy, Debug)]
pub struct Compared<'a> {
    /// Names of the reduced model's choice.
    pub chosen: &'a [&'static str],
    /// Candidates, the best first.
    pub candidates: &'a [SizedCandidate],
}

/// Judges `verdict` when its candidates were `compared`.
///
/// A name that is refuted is taken back, even where no rival is better: then none explains the recordings.
#[must_use]
pub fn judge(verdict: &Verdict, compared: &Compared<'_>) -> Judgement {
    let Some(best) = compared.candidates.first() else {
        return Judgement::new(verdict.word(), verdict.names(), Change::Kept);
    };
    if !best.scores.beat_absent() {
        return Judgement::new("unknown", verdict.names(), Change::NotBorneOut);
    }
    match verdict {
        Verdict::Identified(_) => identified(best, compared),
        _ => ambiguous(verdict.names(), best, compared),
    }
}

/// Judges a verdict that names one effect, or two.
fn identified(best: &SizedCandidate, compared: &Compared<'_>) -> Judgement {
    let chosen = compared.chosen;
    let reduced = compared.candidates.iter().find(|c| c.names == chosen);
    let is_contradicted = reduced.is_some_and(|reduced| best.scores.beat(&reduced.scores));
    let stands_for_it = if is_contradicted { Some(best) } else { reduced };
    if stands_for_it.is_some_and(|candidate| candidate.refutation.is_some()) {
        return Judgement::new("unknown", chosen, Change::Refuted);
    }
    if !is_contradicted {
        return Judgement::new("named", chosen, Change::Kept);
    }
    let mut names = best.names.clone();
    names.extend(chosen.iter().filter(|name| !best.names.contains(name)));
    Judgement { word: "tied", names, change: Change::Contradicted }
}

/// Judges a verdict whose `names` the reduced model did not distinguish.
fn ambiguous(names: &[&'static str], best: &SizedCandidate, compared: &Compared<'_>) -> Judgement {
    let with = |name: &'static str| compared.candidates.iter().filter(move |c| c.names.contains(&name));
    let is_left =
        |name: &&&'static str| best.names.contains(name) || with(name).all(|c| !best.scores.beat(&c.scores));
    let left: Vec<&'static str> = names.iter().filter(is_left).copied().collect();
    let is_refuted = |name: &&'static str| with(name).any(|c| c.refutation.is_some());
    if left.iter().all(is_refuted) {
        return Judgement::new("unknown", names, Change::Refuted);
    }
    let sized_all = names.iter().all(|name| with(name).next().is_some());
    // A single name that the reduced model did not bear out is no more certain for having no rival.
    if names.len() > 1 && sized_all && left == best.names {
        return Judgement { word: "named", names: left, change: Change::Decided };
    }
    Judgement { word: "tied", names: left, change: Change::Kept }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::decision::verdict::tests::claim;
    use crate::sizing::candidate::tests::KNOWN;
    use crate::sizing::comparison::{Score, Scores};
    use crate::sizing::interval::SizeVariance;

    /// A candidate that leaves `squares` of each recording, of 40000 without it.
    fn candidate(names: &[&'static str], squares: f64) -> SizedCandidate {
        let one = |name: &str| Score { recording: name.into(), numbers: 400, squares, absent: 40_000.0 };
        SizedCandidate {
            names: names.to_vec(),
            parameters: Vec::new(),
            viscosity: None,
            active: Vec::new(),
            known: KNOWN,
            variance: SizeVariance::default(),
            spacings: Vec::new(),
            scores: Scores { each: ["a", "b", "c"].map(one).into(), correlation: 5.0 },
            cautions: Vec::new(),
            refutation: None,
        }
    }

    fn refuted(names: &[&'static str], squares: f64) -> SizedCandidate {
        SizedCandidate { refutation: Some("it stands at the end".into()), ..candidate(names, squares) }
    }

    /// Judges what the reduced model names `names`, the first of them its choice.
    fn judged(names: &[&'static str], candidates: &[SizedCandidate]) -> Judgement {
        let verdict = match names {
            [_] => Verdict::Identified(claim(names, &[])),
            _ => Verdict::Ambiguous(claim(names, &[])),
        };
        judge(&verdict, &Compared { chosen: &names[..1], candidates })
    }

    #[test]
    fn a_name_that_the_simulator_refutes_is_taken_back() {
        let names = ["viscosity"];
        let kept = Judgement::new("named", &names, Change::Kept);
        assert_eq!(judged(&names, &[candidate(&names, 400.0)]), kept);
        assert_eq!(judged(&names, &[]), kept);
        let unknown = Judgement::new("unknown", &names, Change::Refuted);
        assert_eq!(judged(&names, &[refuted(&names, 400.0)]), unknown);
        // A rival that is no better does not bear the name out.
        let rival = candidate(&["shear_thinning"], 404.0);
        assert_eq!(judged(&names, &[refuted(&names, 400.0), rival.clone()]), unknown);
        assert_eq!(judged(&names, &[rival, refuted(&names, 410.0)]), unknown);
        // One that is better and is refuted itself does not stand for it.
        assert_eq!(judged(&names, &[refuted(&["foam"], 400.0), candidate(&names, 9000.0)]), unknown);
    }

    #[test]
    fn a_rival_that_explains_them_contradicts_the_name_and_does_not_make_it_unknown() {
        let candidates = [candidate(&["shear_thinning"], 400.0), refuted(&["viscosity"], 9000.0)];
        let judged = judged(&["viscosity"], &candidates);
        assert_eq!(judged, Judgement::new("tied", &["shear_thinning", "viscosity"], Change::Contradicted));
    }

    #[test]
    fn an_ambiguous_verdict_is_decided_by_the_squares_and_unknown_where_no_name_is_left() {
        let names = ["foam", "contact_line"];
        let apart = [candidate(&names[..1], 400.0), candidate(&names[1..], 1200.0)];
        assert_eq!(judged(&names, &apart), Judgement::new("named", &names[..1], Change::Decided));
        let alike = [candidate(&names[..1], 400.0), candidate(&names[1..], 404.0)];
        assert_eq!(judged(&names, &alike), Judgement::new("tied", &names, Change::Kept));
        let neither = [refuted(&names[..1], 400.0), refuted(&names[1..], 404.0)];
        let unknown = Judgement::new("unknown", &names, Change::Refuted);
        assert_eq!(judged(&names, &neither), unknown);
        assert_eq!(judged(&names, &[refuted(&names[..1], 400.0), candidate(&names[1..], 9000.0)]), unknown);
        let one = [refuted(&names[..1], 400.0), candidate(&names[1..], 404.0)];
        assert_eq!(judged(&names, &one), Judgement::new("tied", &names, Change::Kept));
    }

    #[test]
    fn an_effect_without_which_the_simulator_is_as_good_is_not_borne_out() {
        let names = ["swirl"];
        let judged = judged(&names, &[candidate(&names, 40_000.0)]);
        assert_eq!(judged, Judgement::new("unknown", &names, Change::NotBorneOut));
    }
}
