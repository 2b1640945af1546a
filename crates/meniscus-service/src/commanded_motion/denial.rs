//! Messages about the camera's verdict on a motion from outside.

use super::MotionCounters;
use super::sender::Say;
use std::sync::atomic::Ordering;

/// Message when a motion from outside is not used any more.
const NOT_USED: &str = "the commanded motion is not that of the glass in the image: the glass is tracked by the camera \
                        instead. Check the sender, the direction of x, the unit (m/s2) and --motion-lag-ms";

/// Message when it is used again.
const USED_AGAIN: &str = "the commanded motion agrees with the glass in the image again and is used";

/// Contradictions that were reported.
#[derive(Debug, Default)]
pub(super) struct Denials(u64);

impl Denials {
    /// Reports when the camera has contradicted the motion, or agrees again; returns whether it has contradicted it anew.
    pub(super) fn look(&mut self, counters: &MotionCounters, say: &Say) -> bool {
        let contradictions = counters.contradictions.load(Ordering::Relaxed);
        let anew = contradictions > self.0;
        if anew {
            say(NOT_USED);
        }
        if counters.reconciled.swap(false, Ordering::Relaxed) {
            say(USED_AGAIN);
        }
        self.0 = contradictions;
        anew
    }
}
