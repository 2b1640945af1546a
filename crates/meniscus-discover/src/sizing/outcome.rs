//! Outcome of a sizing: sizes by the simulator beside those of the reduced model, and what becomes of the verdict.

use super::comparison::Scores;
use super::interval::SizeVariance;
use crate::decision::verdict::Verdict;
use crate::recordings::stated::Known;
use meniscus::reduced::effects::{Active, Class, find};

/// Size by the simulator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SizedParameter {
    /// Effect.
    pub effect: &'static str,
    /// Parameter.
    pub parameter: &'static str,
    /// Unit of the SI value.
    pub unit: &'static str,
    /// SI value.
    pub value: f64,
    /// Interval with a nominal coverage of 90 %, SI.
    pub interval: (f64, f64),
    /// SI value that the reduced model found.
    pub reduced: f64,
    /// SI value at which the effect is absent.
    pub absent: f64,
}

/// Sizes that were tried at one spacing.
#[derive(Clone, Debug, PartialEq)]
pub struct SpacingResult {
    /// Spacing of the particles, m.
    pub spacing_m: f64,
    /// SI value that fits best.
    pub value: f64,
    /// SI values that were simulated.
    pub sizes: Vec<f64>,
    /// Misfit per number.
    pub misfit: f64,
}

/// Candidate with its sizes.
#[derive(Clone, Debug)]
pub struct SizedCandidate {
    /// Names.
    pub names: Vec<&'static str>,
    /// Sizes; the first was searched.
    pub parameters: Vec<SizedParameter>,
    /// Factor on the stated viscosity that fits beside the effect, and its interval; none where it is an effect.
    pub viscosity: Option<(f64, (f64, f64))>,
    /// Effects at these sizes.
    pub active: Vec<Active>,
    /// Glass and liquid with the fitted viscosity.
    pub known: Known,
    /// Parts of the variance of the first size, in its coordinate.
    pub variance: SizeVariance,
    /// Results by spacing, the coarsest first.
    pub spacings: Vec<SpacingResult>,
    /// Scores on recordings that the sizes were not fitted to.
    pub scores: Scores,
    /// Cautions about the size, in words.
    pub cautions: Vec<String>,
}

/// Candidate that could not be sized.
#[derive(Clone, Debug, PartialEq)]
pub struct Unsized {
    /// Names.
    pub names: Vec<&'static str>,
    /// Reason.
    pub reason: String,
}

/// Change of the verdict by the simulator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// The simulator agrees with the reduced model, or cannot distinguish the candidates either.
    Kept,
    /// The simulator distinguishes what the reduced model did not.
    Decided,
    /// The simulator prefers a rival of the effect that the reduced model named.
    Contradicted,
    /// With the effect the simulator is no better than without.
    NotBorneOut,
}

/// Error of the simulator on the held-out recording, m, noise subtracted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeldOutError {
    /// Without the effects.
    pub untouched_m: f64,
    /// With the effects as the simulator sizes them.
    pub effect_m: f64,
}

/// Sizes by simulation.
#[derive(Clone, Debug)]
pub struct Sizing {
    /// Candidates, the best first.
    pub candidates: Vec<SizedCandidate>,
    /// Candidates that could not be sized.
    pub not_sized: Vec<Unsized>,
    /// Verdict in one word of the file format: `named` or `tied`.
    pub word: &'static str,
    /// Names that are left.
    pub names: Vec<&'static str>,
    /// Change of the verdict.
    pub change: Change,
    /// Error on the held-out recording, where there is one.
    pub held_out: Option<HeldOutError>,
    /// Recordings that had a reference in the same motion, of all that were fitted.
    pub with_control: (usize, usize),
    /// Packings.
    pub packings: usize,
    /// Simulations that were taken from the store, and those that were made.
    pub simulations: (usize, usize),
    /// Time of all, s.
    pub seconds: f64,
}

/// Decides what becomes of `verdict` when `candidates` were compared, the best of them first; `chosen` are the names of the
/// reduced model's choice.
#[must_use]
pub fn decide(
    verdict: &Verdict,
    chosen: &[&'static str],
    candidates: &[SizedCandidate],
) -> (&'static str, Vec<&'static str>, Change) {
    let Some(best) = candidates.first() else {
        return (verdict.word(), verdict.names().to_vec(), Change::Kept);
    };
    if !best.scores.beat_absent() {
        return ("tied", verdict.names().to_vec(), Change::NotBorneOut);
    }
    let beaten = |other: &&SizedCandidate| best.scores.beat(&other.scores);
    let left = |names: &[&'static str]| -> Vec<&'static str> {
        let gone: Vec<&[&'static str]> =
            candidates[1..].iter().filter(beaten).map(|c| c.names.as_slice()).collect();
        names
            .iter()
            .filter(|name| best.names.contains(name) || !gone.iter().any(|gone| gone.contains(name)))
            .copied()
            .collect()
    };
    match verdict {
        Verdict::Identified(_) => {
            let reduced = candidates.iter().find(|c| c.names == chosen);
            if best.names == chosen || reduced.is_none_or(|reduced| !best.scores.beat(&reduced.scores)) {
                return ("named", chosen.to_vec(), Change::Kept);
            }
            let mut names = best.names.clone();
            names.extend(chosen.iter().filter(|name| !best.names.contains(name)));
            ("tied", names, Change::Contradicted)
        }
        _ => {
            let names = left(verdict.names());
            let sized_all =
                verdict.names().iter().all(|name| candidates.iter().any(|c| c.names.contains(name)));
            // A single name that the reduced model did not bear out is no more certain for having no rival.
            if verdict.names().len() > 1 && sized_all && names == best.names {
                return ("named", names, Change::Decided);
            }
            ("tied", names, Change::Kept)
        }
    }
}

impl Sizing {
    /// Returns the candidate that goes into other models: that of the reduced model where the verdict stays, else the best.
    #[must_use]
    pub fn chosen(&self) -> Option<&SizedCandidate> {
        let kept = self.candidates.iter().find(|c| self.word == "named" && c.names == self.names);
        kept.or(self.candidates.first())
    }

    /// Returns the class of the names that are left, where they share one.
    #[must_use]
    pub fn class(&self) -> Option<Class> {
        let mut classes = self.names.iter().filter_map(|name| find(name)).map(|entry| entry.class);
        let first = classes.next()?;
        classes.all(|class| class == first).then_some(first)
    }

    /// Returns what the simulator says to the verdict, and how far its sizes can be trusted.
    #[must_use]
    pub fn sentence(&self) -> String {
        let Some(best) = self.chosen() else {
            let reasons: Vec<String> =
                self.not_sized.iter().map(|c| format!("{}: {}", c.names.join(" + "), c.reason)).collect();
            return format!("No size was found by simulation ({}).", reasons.join("; "));
        };
        let names = best.names.join(" + ");
        let rivals: Vec<String> =
            self.candidates.iter().filter(|c| c.names != best.names).map(|c| c.names.join(" + ")).collect();
        let verdict = match self.change {
            Change::Kept if rivals.is_empty() => {
                format!("Sized by simulation: {names}; no rival was compared.")
            }
            Change::Kept if self.word == "named" && self.is_alone(best) => {
                format!(
                    "The simulator agrees: {names} predicts recordings that it was not fitted to better than {}.",
                    rivals.join(" and ")
                )
            }
            Change::Kept => format!(
                "The simulator does not distinguish {names} from {} either; the verdict is that of the reduced model.",
                rivals.join(" and ")
            ),
            Change::Decided => format!(
                "The simulator decides it: {names} predicts recordings that it was not fitted to better than {}.",
                rivals.join(" and ")
            ),
            Change::Contradicted => format!(
                "The simulator contradicts the reduced model: {names} predicts recordings that it was not fitted to better, so \
                 that the verdict is open."
            ),
            Change::NotBorneOut => format!(
                "With {names} the simulator predicts recordings that it was not fitted to no better than without."
            ),
        };
        format!("{verdict} {}", self.trust())
    }

    /// Returns whether `best` beats every other candidate.
    fn is_alone(&self, best: &SizedCandidate) -> bool {
        self.candidates.iter().filter(|c| c.names != best.names).all(|c| best.scores.beat(&c.scores))
    }

    /// Returns how far the sizes can be trusted.
    #[must_use]
    pub fn trust(&self) -> String {
        let (with, all) = self.with_control;
        let control = match with {
            0 => {
                "No reference moved in the same way, so that the simulator's own errors are part of the sizes"
                    .into()
            }
            with if with == all => {
                String::from("The simulator's error in the reference liquid is subtracted")
            }
            with => format!(
                "The simulator's error in the reference liquid is subtracted in {with} of {all} recordings"
            ),
        };
        let spacing = match self.chosen().map_or(0, |c| c.spacings.len()) {
            2.. => "the interval covers noise, scatter over packings and the error of the spacing",
            _ => {
                "the interval covers noise and scatter over packings; one spacing says nothing of the error of the spacing"
            }
        };
        let cautions: Vec<&str> =
            self.chosen().iter().flat_map(|c| c.cautions.iter().map(String::as_str)).collect();
        let cautions = if cautions.is_empty() {
            String::new()
        } else {
            format!(" Not to be trusted: {}.", cautions.join("; "))
        };
        format!("{control}; {spacing}.{cautions}")
    }
}
