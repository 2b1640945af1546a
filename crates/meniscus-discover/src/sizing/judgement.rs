//! What becomes of a verdict when its candidates were compared by the simulator.

use super::outcome::SizedCandidate;
use crate::decision::verdict::Verdict;

/// Largest misfit per number of an explanation that is complete. The noise of a number holds 2 % of the signal for the simulator,
/// so that an effect that is the right one leaves less than one.
pub const COMPLETE: f64 = 2.5;

/// Change of the verdict by the simulator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// The simulator agrees with the reduced model, or cannot distinguish the candidates either.
    Kept,
    /// The simulator distinguishes what the reduced model did not.
    Decided,
    /// The simulator explains what the reduced model did not.
    Explained,
    /// The simulator finds two effects where the reduced model named one or some.
    Paired,
    /// The simulator prefers a rival of the effect that the reduced model named.
    Contradicted,
    /// With the effect the simulator is no better than without.
    NotBorneOut,
}

/// Verdict behind a comparison by the simulator.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Judgement {
    /// The verdict in one word of the file format.
    pub word: &'static str,
    /// Names that are left.
    pub names: Vec<&'static str>,
    /// Change of the verdict.
    pub change: Change,
}

impl Judgement {
    fn named(names: &[&'static str], change: Change) -> Self {
        Self { word: "named", names: names.to_vec(), change }
    }

    fn tied(names: Vec<&'static str>, change: Change) -> Self {
        Self { word: "tied", names, change }
    }

    fn kept(verdict: &Verdict) -> Self {
        Self { word: verdict.word(), names: verdict.names().to_vec(), change: Change::Kept }
    }
}

/// Judges `verdict` when `candidates` were compared, the best of them first; `chosen` are the names of the reduced model's choice.
///
/// Two effects, or one that the reduced model does not bear out, are named only where they explain the recordings completely
/// and nothing else that was sized does nearly as well.
#[must_use]
pub fn judge(verdict: &Verdict, chosen: &[&'static str], candidates: &[SizedCandidate]) -> Judgement {
    let Some(best) = candidates.first() else { return Judgement::kept(verdict) };
    let is_alone = candidates[1..].iter().all(|other| best.scores.beat(&other.scores));
    let is_certain = is_alone && best.is_complete() && best.scores.beat_absent();
    let is_new_pair = best.names.len() > 1 && best.names != chosen;
    match verdict {
        Verdict::Unknown(_) if is_certain => Judgement::named(&best.names, Change::Explained),
        Verdict::Unknown(_) | Verdict::None { .. } => Judgement::kept(verdict),
        _ if is_new_pair && is_certain => Judgement::named(&best.names, Change::Paired),
        _ => among_named(verdict, chosen, candidates),
    }
}

/// Judges a verdict with names by those of `candidates` that are as large as its choice.
fn among_named(verdict: &Verdict, chosen: &[&'static str], candidates: &[SizedCandidate]) -> Judgement {
    let candidates: Vec<&SizedCandidate> =
        candidates.iter().filter(|candidate| candidate.names.len() <= chosen.len()).collect();
    let Some((best, others)) = candidates.split_first() else { return Judgement::kept(verdict) };
    if !best.scores.beat_absent() {
        return Judgement::tied(verdict.names().to_vec(), Change::NotBorneOut);
    }
    let gone: Vec<&[&'static str]> = others
        .iter()
        .filter(|other| best.scores.beat(&other.scores))
        .map(|other| other.names.as_slice())
        .collect();
    if let Verdict::Identified(_) = verdict {
        let reduced = candidates.iter().find(|c| c.names == chosen);
        if best.names == chosen || reduced.is_none_or(|reduced| !best.scores.beat(&reduced.scores)) {
            return Judgement::named(chosen, Change::Kept);
        }
        let left = chosen.iter().filter(|name| !best.names.contains(name));
        return Judgement::tied(best.names.iter().chain(left).copied().collect(), Change::Contradicted);
    }
    let stays =
        |name: &&&'static str| best.names.contains(name) || !gone.iter().any(|gone| gone.contains(name));
    let names: Vec<&'static str> = verdict.names().iter().filter(stays).copied().collect();
    let sized_all = verdict.names().iter().all(|name| candidates.iter().any(|c| c.names.contains(name)));
    // A single name that the reduced model did not bear out is no more certain for having no rival.
    if verdict.names().len() > 1 && sized_all && names == best.names {
        return Judgement::named(&names, Change::Decided);
    }
    Judgement::tied(names, Change::Kept)
}
