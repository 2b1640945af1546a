//! Sizes of one hidden effect beside the truth.
//!
//! ```text
//! error of a size = (found - absent) / (hidden - absent) - 1
//! ```
//! An effect that is not the hidden one has no size that counts.

use crate::findings::{Estimate, Findings};
use crate::sizing::error::SizingError;
use crate::sizing::outcome::{SizedCandidate, Sizing};
use crate::study::cases::STATED;
use crate::study::plans::Answer;
use meniscus::reduced::effects::find;
use serde::{Deserialize, Serialize};

/// Size with its interval, SI.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FoundSize {
    /// Value.
    pub value: f64,
    /// Least value of the interval with a nominal coverage of 90 %.
    pub least: f64,
    /// Largest value.
    pub largest: f64,
}

impl FoundSize {
    fn of(estimate: &Estimate) -> Self {
        Self { value: estimate.value, least: estimate.interval.0, largest: estimate.interval.1 }
    }

    /// Returns whether the interval covers `truth`.
    #[must_use]
    pub fn covers(&self, truth: f64) -> bool {
        (self.least..=self.largest).contains(&truth)
    }
}

/// Sizing of one trial.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SizedTrial {
    /// Truth of the trial.
    pub answer: Answer,
    /// Hidden value, SI.
    pub truth: f64,
    /// Value at which the effect is absent, SI.
    pub absent: f64,
    /// Unit.
    pub unit: String,
    /// Size by the reduced model; none where another effect was chosen.
    pub reduced: Option<FoundSize>,
    /// Size by the simulator; none where another effect was chosen, or nothing was sized.
    pub simulated: Option<FoundSize>,
    /// Verdict in the end in one word; empty in a file from before it was kept.
    #[serde(default)]
    pub verdict: String,
    /// Class in the end.
    #[serde(default)]
    pub class: Option<String>,
    /// Names that are left after the comparison by the simulator.
    pub names: Vec<String>,
    /// Error of the simulator on the held-out recording without and with the effect, mm.
    pub held_out_mm: Option<[f64; 2]>,
    /// Cautions about the size, or the reason why there is none.
    pub said: Vec<String>,
    /// Simulations that were made.
    pub simulations: usize,
    /// Duration, s.
    pub seconds: f64,
}

impl SizedTrial {
    /// Returns the error of `size` relative to the hidden effect.
    #[must_use]
    pub fn error_of(&self, size: &FoundSize) -> f64 {
        (size.value - self.absent) / (self.truth - self.absent) - 1.0
    }

    /// Returns the size that the program states at the end: that of the simulator where there is one.
    #[must_use]
    pub fn stated(&self) -> Option<&FoundSize> {
        self.simulated.as_ref().or(self.reduced.as_ref())
    }

    /// Returns the share of the simulator's error on the held-out recording that the effect removes.
    #[must_use]
    pub fn gap_closed(&self) -> Option<f64> {
        self.held_out_mm.map(|[untouched, effect]| 1.0 - effect / untouched)
    }
}

/// Sized trials, and how many there should be of those that were judged.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SizedTrials {
    /// Trials, those of the held-out glasses first.
    pub trials: Vec<SizedTrial>,
    /// Trials that are to be sized.
    pub planned: usize,
    /// Trials whose effect the library lacks.
    #[serde(default)]
    pub without: Vec<SizedTrial>,
}

/// Returns the sizes beside the truth of `answer`.
pub(super) fn sized(answer: &Answer, findings: &Findings, sizing: Result<Sizing, SizingError>) -> SizedTrial {
    let (name, coordinate) = &answer.effects[0];
    let hidden = find(name).and_then(|effect| effect.parameters.first());
    let si = |value: f64| hidden.map_or(f64::NAN, |parameter| parameter.to_value(value, &STATED));
    let reduced = findings.estimates.first().filter(|estimate| estimate.effect == name);
    let mut out = SizedTrial {
        answer: answer.clone(),
        truth: si(*coordinate),
        absent: hidden.map_or(f64::NAN, |parameter| si(parameter.neutral)),
        unit: hidden.map_or("", |parameter| parameter.unit).into(),
        reduced: reduced.map(FoundSize::of),
        simulated: None,
        verdict: findings.assessment.verdict.word().into(),
        class: findings.assessment.verdict.class().map(|class| class.words().into()),
        names: findings.assessment.verdict.names().iter().map(|name| String::from(*name)).collect(),
        held_out_mm: None,
        said: Vec::new(),
        simulations: 0,
        seconds: 0.0,
    };
    match sizing {
        Ok(sizing) => {
            out.verdict = sizing.word.into();
            out.class = sizing.class().map(|class| class.words().into());
            out.names = sizing.names.iter().map(|name| String::from(*name)).collect();
            out.held_out_mm = sizing.held_out.map(|h| [h.untouched_m, h.effect_m].map(|m| 1e3 * m));
            (out.simulations, out.seconds) = (sizing.simulations.1, sizing.seconds);
            if sizing.is_unknown() {
                out.said.push(sizing.sentence());
            }
            if let Some(chosen) = sizing.chosen() {
                out.said.clone_from(&chosen.cautions);
                out.simulated = size_of(chosen, name);
            }
        }
        Err(error) => out.said.push(error.to_string()),
    }
    // A verdict that stays tied states a size of each effect that it names.
    if out.names.iter().any(|left| left == name) {
        let rival = findings.rivals.iter().find(|estimate| estimate.effect == name);
        out.reduced = out.reduced.or(rival.map(FoundSize::of));
    }
    out
}

/// Returns the size of the effect `name` in `chosen`; none where it is another effect.
fn size_of(chosen: &SizedCandidate, name: &str) -> Option<FoundSize> {
    let parameter = chosen.parameters.first().filter(|parameter| parameter.effect == name)?;
    let (least, largest) = parameter.interval;
    Some(FoundSize { value: parameter.value, least, largest })
}
