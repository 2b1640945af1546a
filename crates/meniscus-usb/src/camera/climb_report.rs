//! Notes about a climb of the ladder.

use super::{Note, Rung, Sink, Trouble};

/// Notes about a climb: the same rung again for the same reason is reported once.
#[derive(Debug, Default)]
pub struct ClimbReport {
    last: String,
}

impl ClimbReport {
    /// Takes the trouble that was met.
    pub fn meet(&mut self, met: Trouble) {
        // That a rung failed is the consequence of another trouble, whose words say more.
        if !matches!(met, Trouble::Failed(_)) {
            self.last = met.to_string();
        }
    }

    /// Reports that `rung` is taken.
    pub fn take(&self, met: Trouble, rung: Rung, sink: &mut impl Sink) {
        if met != Trouble::Failed(rung) {
            sink.note(Note::Trouble(met, rung));
        }
    }

    /// Reports that `rung` failed; returns the trouble that this is.
    pub fn fail(&mut self, met: Trouble, rung: Rung, reason: String, sink: &mut impl Sink) -> Trouble {
        if met != Trouble::Failed(rung) || reason != self.last {
            sink.note(Note::Failed(reason.clone()));
        }
        self.last = reason;
        Trouble::Failed(rung)
    }

    /// Returns the last reason.
    #[must_use]
    pub fn last(self) -> String {
        self.last
    }
}
