//! Tally of the study: its judged trials and what is measured beside them.

use super::against_simulator::AgainstSimulator;
use super::bench::Judged;
use super::laboratory::judge::LaboratoryOutcome;
use super::measured::MeasuredResult;
use super::plans::{Answer, Family};
use super::run::JudgedTrial;
use super::sizes::trial::SizedTrials;
use super::unnamed::judge::LawOutcome;
use meniscus::reduced::effects::find;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Judged trials with everything that is measured beside them.
#[derive(Clone, Debug, Default)]
pub struct StudyTally {
    /// Trials.
    pub lines: Vec<JudgedTrial>,
    /// Number of trials that each family is planned to have.
    pub planned: BTreeMap<Family, usize>,
    /// Measurements beside the trials.
    pub beside: Beside,
}

/// Measurements beside the trials.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Beside {
    /// Measured water, where the data are there.
    pub measured: Option<Vec<MeasuredResult>>,
    /// Share of intervals that held the truth, of draws from the model itself, and how many were drawn.
    pub coverage: Option<(f64, usize)>,
    /// Seconds of one discovery on three recordings of 10 s.
    pub long_s: Option<f64>,
    /// Trials of the drawn law, where they were made.
    #[serde(default)]
    pub laws: Vec<LawOutcome>,
    /// Trials of the second laboratory, where they were made.
    #[serde(default)]
    pub laboratory: Vec<LaboratoryOutcome>,
    /// Trials against references by simulation, where they were made.
    #[serde(default)]
    pub against: Vec<AgainstSimulator>,
    /// Sizes by simulation; each lies in a file of its own.
    #[serde(skip)]
    pub sizes: SizedTrials,
}

impl StudyTally {
    /// Returns the trials of `family`.
    pub fn of(&self, family: Family) -> impl Iterator<Item = &JudgedTrial> {
        self.lines.iter().filter(move |(answer, _)| answer.family == family)
    }

    /// Returns the trials at reference size, those of fresh glasses too.
    pub fn reference(&self) -> impl Iterator<Item = &JudgedTrial> {
        let hidden = self.of(Family::Hidden).filter(|(answer, _)| answer.size == 1.0);
        hidden.chain(self.of(Family::Fresh))
    }

    /// Returns whether every planned trial was judged.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.planned.iter().all(|(family, count)| self.of(*family).count() == *count)
    }
}

/// Returns whether the verdict is `named` with the true effects.
#[must_use]
pub fn right(answer: &Answer, judged: &Judged) -> bool {
    judged.verdict == "named"
        && judged.names.len() == answer.effects.len()
        && answer.effects.iter().all(|(name, _)| judged.names.contains(name))
}

/// Returns whether the class of a `named` or `tied` verdict is that of the truth; none where no class is given.
#[must_use]
pub fn class_right(answer: &Answer, judged: &Judged) -> Option<bool> {
    let truth = answer.effects.first().and_then(|(name, _)| find(name)).map(|entry| entry.class.words())?;
    let class = judged.class.as_deref()?;
    matches!(judged.verdict.as_str(), "named" | "tied").then_some(class == truth)
}
