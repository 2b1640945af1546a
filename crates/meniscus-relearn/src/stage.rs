//! Stages of a run.

/// Stage of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// The liquid from recordings, or as stated.
    Identify,
    /// Recordings of the inside by the simulator.
    Simulate,
    /// Model from these recordings.
    Train,
    /// Correction on the measured recordings.
    Correct,
    /// Judgement on recordings that no stage saw, and the report.
    Report,
}

impl Stage {
    /// All stages in their order.
    pub const ALL: [Self; 5] = [Self::Identify, Self::Simulate, Self::Train, Self::Correct, Self::Report];

    /// Name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Identify => "identify",
            Self::Simulate => "simulate",
            Self::Train => "train",
            Self::Correct => "correct",
            Self::Report => "report",
        }
    }
}
