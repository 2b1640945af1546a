//! Is this frame the next one? Frame identifier, frame counter and PTS each give an answer.
//!
//! The counter tells how many frames never arrived, the PTS is unwrapped from 32 bits (71.6 minutes)
//! to [`Micros`], the frame identifier is a cross-check that needs no metadata.

use super::header::PayloadHeader;
use super::losses::{Cause, Losses};
use super::timing::Timing;
use crate::units::Micros;
use crate::usb::frame::Stamp;

/// A frame that is older than the last one by less than this came late, microseconds.
const LATE_US: u32 = 1_000_000;

/// Memory of the last frame whose header could be read.
#[derive(Clone, Copy, Debug)]
struct Last {
    fid: bool,
    counter: u32,
    pts: u32,
    unwrapped: Micros,
}

/// Memory of the frame order of one stream.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Continuity {
    last: Option<Last>,
    /// Frames lost without a known place since the last placed one: the counter gap that they leave
    /// behind is theirs already.
    unidentified: u32,
    /// The last frame was far too old; a second one in a row means that the camera's clock was reset.
    clock_reset: bool,
}

impl Continuity {
    /// Notes that a frame was lost whose place in the order is not known.
    pub(super) fn lost_unidentified(&mut self) {
        self.unidentified = self.unidentified.saturating_add(1);
    }

    /// Places a frame after the last one and gives its stamp. It is called once a frame, also for
    /// frames that turn out torn, so that their number is not counted a second time as a gap.
    pub(super) fn place(&mut self, header: &PayloadHeader<'_>, losses: &mut Losses) -> Result<Stamp, Cause> {
        let timing = Timing::of(header);
        let Some(pts) = header.pts() else {
            self.lost_unidentified();
            return Err(Cause::PtsMissing);
        };
        let Some(last) = self.last else {
            return Ok(self.accept(
                header,
                &timing,
                pts,
                Micros(u64::from(pts)),
                timing.counter.unwrap_or(0),
            ));
        };
        let step_us = pts.wrapping_sub(last.pts);
        if step_us == 0 {
            return Err(Cause::Duplicate);
        }
        // Half of the 32-bit circle ahead is later, the other half is earlier.
        if step_us > u32::MAX / 2 {
            self.step_back(last, pts, &timing, losses);
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
        let unwrapped = Micros(last.unwrapped.0.saturating_add(u64::from(step_us)));
        Ok(self.accept(header, &timing, pts, unwrapped, counter))
    }

    /// A frame older than the last one: it came late, or the camera's clock was reset.
    fn step_back(&mut self, last: Last, pts: u32, timing: &Timing, losses: &mut Losses) {
        if last.pts.wrapping_sub(pts) < LATE_US {
            if timing.counter.is_some() {
                // It was counted as missing when its successor came.
                losses.counter_gap = losses.counter_gap.saturating_sub(1);
            }
            return;
        }
        self.lost_unidentified();
        if self.clock_reset {
            // The second one in a row: go on from here, time itself never goes back.
            self.last = Some(Last { pts, ..last });
        }
        self.clock_reset = !self.clock_reset;
    }

    fn accept(
        &mut self,
        header: &PayloadHeader<'_>,
        timing: &Timing,
        pts: u32,
        at: Micros,
        counter: u32,
    ) -> Stamp {
        self.last = Some(Last { fid: header.frame_id(), counter, pts, unwrapped: at });
        self.unidentified = 0;
        self.clock_reset = false;
        // mid-exposure = PTS - sensor timestamp
        let captured = Micros(at.0.saturating_sub(u64::from(timing.sensor_us.unwrap_or(0))));
        Stamp { sequence: counter, captured }
    }
}
