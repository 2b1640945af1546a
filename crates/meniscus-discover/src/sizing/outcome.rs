//! Outcome of a sizing: sizes by the simulator beside those of the reduced model, and what becomes of the verdict.

use super::comparison::Scores;
use super::interval::SizeVariance;
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
    /// Reason for which the effect cannot be what is missing, in words.
    pub refutation: Option<String>,
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
    /// With the effect the simulator is no better than without, so that nothing is named.
    NotBorneOut,
    /// In the simulator the effect would need a size that it cannot have, or a viscosity beside it that the liquid does not have.
    Refuted,
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
    /// Verdict in one word of the file format: `named`, `tied` or `unknown`.
    pub word: &'static str,
    /// Names that are left; of an unknown verdict those that are nearest.
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

impl Sizing {
    /// Returns whether the simulator takes every name of the verdict back.
    #[must_use]
    pub fn is_unknown(&self) -> bool {
        self.word == "unknown"
    }

    /// Returns the candidate that goes into other models: that of the reduced model where the verdict stays, else the best;
    /// none where no candidate explains the recordings.
    #[must_use]
    pub fn chosen(&self) -> Option<&SizedCandidate> {
        if self.is_unknown() {
            return None;
        }
        let kept = self.candidates.iter().find(|c| self.word == "named" && c.names == self.names);
        kept.or(self.candidates.first())
    }

    /// Returns the class of the names that are left, where they share one and explain the recordings.
    #[must_use]
    pub fn class(&self) -> Option<Class> {
        if self.is_unknown() {
            return None;
        }
        let mut classes = self.names.iter().filter_map(|name| find(name)).map(|entry| entry.class);
        let first = classes.next()?;
        classes.all(|class| class == first).then_some(first)
    }

    /// Returns what the simulator says to the verdict, and how far its sizes can be trusted.
    #[must_use]
    pub fn sentence(&self) -> String {
        if self.is_unknown() {
            return self.taken_back();
        }
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
            // No candidate is chosen then.
            Change::NotBorneOut | Change::Refuted => String::new(),
        };
        format!("{verdict} {}", self.trust())
    }

    /// Returns why the names of the reduced model are taken back.
    fn taken_back(&self) -> String {
        let refutation = self.candidates.iter().find_map(|candidate| candidate.refutation.as_deref());
        let reason = match refutation.filter(|_| self.change == Change::Refuted) {
            Some(refutation) => format!("in the simulator {refutation}"),
            None => {
                "with that the simulator predicts recordings that it was not fitted to no better than without"
                    .into()
            }
        };
        format!(
            "Something is missing that no effect of the library explains by itself: the reduced model takes it for {}, but {reason}.",
            self.names.join(" or ")
        )
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
