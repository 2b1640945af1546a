//! Progress of a discovery, reported to the caller.

use crate::sizing::workload::SimulationProgress;

/// Stage of a discovery, in the order in which they run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// The simulator makes references, because none are given.
    SimulateReferences,
    /// The baseline is fitted to the references.
    FitReferences,
    /// Each reference is judged by the others, which sets the thresholds.
    SetThresholds,
    /// The effects are ranked and the verdict is decided.
    Decide,
    /// The sizes are found by simulation.
    Size,
    /// The missing force is drawn, because no name fits.
    DrawLaw,
    /// The effects are inserted into the flashed model.
    InsertIntoModel,
    /// The held-out recording is simulated twice, without and with the effects.
    Simulate,
}

impl Stage {
    /// Returns the stage in words, for a line of progress.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::SimulateReferences => "simulating references",
            Self::FitReferences => "fitting the references",
            Self::SetThresholds => "judging the references by one another",
            Self::Decide => "ranking the effects",
            Self::DrawLaw => "drawing the missing force",
            Self::Size => "finding the sizes by simulation",
            Self::InsertIntoModel => "inserting the effects into the model",
            Self::Simulate => "simulating the held-out recording twice",
        }
    }
}

/// Observer of a discovery. The library itself prints nothing.
pub trait Progress {
    /// Is called when `stage` begins; a stage that is not needed is left out.
    fn begins(&self, stage: Stage);

    /// Is called before the first simulation of [`Stage::SimulateReferences`], with an estimate of the time, and after each one.
    fn referenced(&self, _progress: SimulationProgress) {}

    /// Is called before the first simulation of [`Stage::Size`], with an estimate of the time, and after each one.
    fn simulated(&self, _progress: SimulationProgress) {}
}

/// Observer that ignores everything.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Progress for Silent {
    fn begins(&self, _stage: Stage) {}
}

impl<F: Fn(Stage)> Progress for F {
    fn begins(&self, stage: Stage) {
        self(stage);
    }
}
