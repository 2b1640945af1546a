//! Observer of a run.

use crate::stage::Stage;

/// Observer of a run; a terminal shows bars, a test nothing.
pub trait Progress: Sync {
    /// `stage` begins; `about` says what it will do and how long that may take.
    fn begins(&self, stage: Stage, about: &str);
    /// `share` of the running stage is done, 0 to 1.
    fn advances(&self, share: f64);
    /// The running stage has ended; `result` says with what.
    fn ends(&self, result: &str);
    /// Whether a training shows no bars of its own.
    fn quiet(&self) -> bool;
}

/// Observer that shows nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Progress for Silent {
    fn begins(&self, _: Stage, _: &str) {}

    fn advances(&self, _: f64) {}

    fn ends(&self, _: &str) {}

    fn quiet(&self) -> bool {
        true
    }
}
