//! Report of a discovery: what the reduced model and the simulator say together.

use super::clocks::AlignedClock;
use super::insertion::Insertion;
use super::references::ReferenceOrigin;
use crate::findings::{Estimate, Findings};
use crate::fitting::fit_cache::FitCounts;
use crate::law::draw::{Drawn, NoLaw};
use crate::sizing::error::SizingError;
use crate::sizing::outcome::{SizedCandidate, Sizing};
use meniscus::reduced::effects::{Active, Class};

/// Report of a discovery.
#[derive(Clone, Debug)]
pub struct Report {
    /// Findings on the recordings.
    pub findings: Findings,
    /// Origin of the references.
    pub origin: ReferenceOrigin,
    /// Law that was drawn where the verdict is `unknown` in the end, or why there is none; nothing with another verdict.
    pub law: Option<Result<Drawn, NoLaw>>,
    /// Sizes by simulation, or why there are none; nothing where they were not requested or there is no effect.
    pub sizing: Option<Result<Sizing, SizingError>>,
    /// Name of the simulator.
    pub simulator: String,
    /// The effects in other models.
    pub insertion: Insertion,
    /// Alignments of the recordings with a clock of their own; none where they have none.
    pub clocks: Vec<AlignedClock>,
    /// Use of the cache of fits; zeros without a cache.
    pub fits: FitCounts,
}

/// Size of a parameter with its origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FinalSize {
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
    /// Model that it comes from.
    pub by: &'static str,
}

/// Name of the reduced model in reports.
pub const REDUCED: &str = "reduced model";

/// Name of the simulator in reports of sizes.
pub const SIMULATED: &str = "simulator";

impl Report {
    /// Returns the sizes by simulation, where there are any.
    #[must_use]
    pub fn sizes(&self) -> Option<&Sizing> {
        self.sizing.as_ref().and_then(|sizing| sizing.as_ref().ok())
    }

    /// Returns the candidate whose sizes hold.
    #[must_use]
    pub fn sized(&self) -> Option<&SizedCandidate> {
        self.sizes().and_then(Sizing::chosen)
    }

    /// Returns the verdict in one word of the file format.
    #[must_use]
    pub fn word(&self) -> &'static str {
        self.sizes().map_or(self.findings.assessment.verdict.word(), |sizing| sizing.word)
    }

    /// Returns the names of the verdict.
    #[must_use]
    pub fn names(&self) -> &[&'static str] {
        self.sizes().map_or(self.findings.assessment.verdict.names(), |sizing| &sizing.names)
    }

    /// Returns the class of the verdict, where one is certain.
    #[must_use]
    pub fn class(&self) -> Option<Class> {
        self.sizes().map_or(self.findings.assessment.verdict.class(), Sizing::class)
    }

    /// Returns the verdict of the reduced model, and what the simulator says to it.
    #[must_use]
    pub fn sentence(&self) -> String {
        let verdict = self.findings.assessment.verdict.sentence() + &self.origin.sentence();
        match &self.sizing {
            // A name that is taken back is not stated first.
            Some(Ok(sizing)) if sizing.is_unknown() => {
                format!("{}{}{}", sizing.sentence(), self.origin.sentence(), self.law_sentence())
            }
            None => verdict + &self.law_sentence(),
            Some(Ok(sizing)) => format!("{verdict} {}", sizing.sentence()),
            Some(Err(error)) => format!("{verdict} No size by simulation: {error}."),
        }
    }

    /// Returns the law that was drawn.
    #[must_use]
    pub fn drawn(&self) -> Option<&Drawn> {
        self.law.as_ref().and_then(|law| law.as_ref().ok())
    }

    /// Returns what is said of a law behind the verdict; nothing where none was tried.
    fn law_sentence(&self) -> String {
        match &self.law {
            None => String::new(),
            Some(Ok(drawn)) => format!(" {}", drawn.sentence()),
            Some(Err(why)) => format!(" No law is drawn: {why}."),
        }
    }

    /// Returns the effects that go into other models, with their final values; none where the verdict is `unknown`.
    #[must_use]
    pub fn effects(&self) -> &[Active] {
        if self.word() == "unknown" {
            return &[];
        }
        self.sized().map_or(&self.findings.assessment.chosen().active, |sized| &sized.active)
    }

    /// Returns the final sizes: by the simulator, where there are any, else by the reduced model; none where the simulator
    /// does not bear out what the reduced model names.
    #[must_use]
    pub fn final_sizes(&self) -> Vec<FinalSize> {
        if self.sizes().is_some_and(Sizing::is_unknown) {
            return Vec::new();
        }
        if let Some(sized) = self.sized() {
            let one = |p: &crate::sizing::outcome::SizedParameter| FinalSize {
                effect: p.effect,
                parameter: p.parameter,
                unit: p.unit,
                value: p.value,
                interval: p.interval,
                by: SIMULATED,
            };
            return sized.parameters.iter().map(one).collect();
        }
        let one = |e: &Estimate| FinalSize {
            effect: e.effect,
            parameter: e.parameter,
            unit: e.unit,
            value: e.value,
            interval: e.interval,
            by: REDUCED,
        };
        self.findings.estimates.iter().map(one).collect()
    }

    /// Returns the sizes of the other effects that the verdict still names, each if it alone is missing.
    pub fn rival_sizes(&self) -> impl Iterator<Item = &Estimate> {
        self.findings.rivals.iter().filter(|rival| self.names().contains(&rival.effect))
    }
}
