//! Is this frame the next one? Frame identifier, frame counter and PTS each give an answer.
//!
//! The counter tells how many frames never arrived, the [`DeviceClock`] of the camera unwraps the PTS, the frame identifier is a
//! cross-check that needs no metadata.

use super::device_clock::DeviceClock;
use super::header::PayloadHeader;
use super::losses::{Cause, Losses};
use super::timing::Timing;
use crate::units::Micros;
use crate::usb::frame::Stamp;

/// Memory of the last frame whose header could be read.
#[derive(Clone, Copy, Debug)]
struct Last {
    fid: bool,
    counter: u32,
    at: Micros,
}

/// Memory of the frame order of one stream.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Continuity {
    last: Option<Last>,
    /// Frames lost without a known place since the last placed one: the counter gap that they leave
    /// behind is theirs already.
    unidentified: u32,
}

impl Continuity {
    /// Notes that a frame was lost whose place in the order is not known.
    pub(super) fn lost_unidentified(&mut self) {
        self.unidentified = self.unidentified.saturating_add(1);
    }

    /// Places a frame after the last one of its stream, by the camera's `clock`, and gives its stamp. It is called once a frame, also
    /// for frames that turn out torn, so that their number is not counted a second time as a gap.
    pub(super) fn place(
        &mut self,
        header: &PayloadHeader<'_>,
        clock: &mut DeviceClock,
        losses: &mut Losses,
    ) -> Result<Stamp, Cause> {
        let timing = Timing::of(header);
        let Some(pts) = header.pts() else {
            self.lost_unidentified();
            return Err(Cause::PtsMissing);
        };
        let Some(at) = clock.time(pts) else {
            // Far too old, or the first of a clock that began anew.
            self.lost_unidentified();
            return Err(Cause::PtsBackwards);
        };
        let Some(last) = self.last else {
            return Ok(self.accept(header, &timing, at, timing.counter.unwrap_or(0)));
        };
        if at == last.at {
            return Err(Cause::Duplicate);
        }
        if at < last.at {
            if timing.counter.is_some() {
                // It was counted as missing when its successor came.
                losses.counter_gap = losses.counter_gap.saturating_sub(1);
            }
            return Err(Cause::PtsBackwards);
        }
        let counter = timing.counter.unwrap_or_else(|| {
            losses.counter_missing = losses.counter_missing.saturating_add(1);
            last.counter.wrapping_add(1)
        });
        let ahead = counter.wrapping_sub(last.counter);
        if ahead == 1 && last.fid == header.frame_id() {
            losses.fid_repeated = losses.fid_repeated.saturating_add(1);
        }
        if ahead == 0 || ahead > u32::MAX / 2 {
            losses.counter_restarted = losses.counter_restarted.saturating_add(1);
        } else {
            let never_seen = (ahead - 1).saturating_sub(self.unidentified);
            losses.counter_gap = losses.counter_gap.saturating_add(never_seen);
        }
        Ok(self.accept(header, &timing, at, counter))
    }

    fn accept(&mut self, header: &PayloadHeader<'_>, timing: &Timing, at: Micros, counter: u32) -> Stamp {
        self.last = Some(Last { fid: header.frame_id(), counter, at });
        self.unidentified = 0;
        // mid-exposure = PTS - sensor timestamp
        let captured = Micros(at.0.saturating_sub(u64::from(timing.sensor_us.unwrap_or(0))));
        Stamp { sequence: counter, captured }
    }
}
