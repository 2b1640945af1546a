//! The books of what was lost on the wire, one counter a cause.

use serde::{Deserialize, Serialize};

/// Cause of a lost frame, or of a remark on a whole one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// The payload had no byte, or a header and no pixel.
    EmptyPayload,
    /// The header length contradicts its flags or the payload.
    BadHeader,
    /// The camera set the error bit.
    ErrorBit,
    /// The frame ended before it was full.
    ShortFrame,
    /// The frame brought more pixels than it has.
    OverlongFrame,
    /// The next frame began before this one ended or was full.
    FrameUnended,
    /// The frame has no time stamp.
    PtsMissing,
    /// The frame is older than the one before.
    PtsBackwards,
    /// The same frame came again.
    Duplicate,
}

/// Counters of frames that were lost, and of oddities in frames that were not. They saturate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Losses {
    /// Lost: payloads without content.
    pub empty_payload: u32,
    /// Lost: header length 0, below its fields, or beyond the payload.
    pub bad_header: u32,
    /// Lost: error bit of the camera.
    pub error_bit: u32,
    /// Lost: ended before full (torn).
    pub short_frame: u32,
    /// Lost: more pixels than expected.
    pub overlong_frame: u32,
    /// Lost: the next frame began in the middle of it.
    pub frame_unended: u32,
    /// Lost: no time stamp.
    pub pts_missing: u32,
    /// Lost: time stamp not later than the last one.
    pub pts_backwards: u32,
    /// Lost on purpose: seen before.
    pub duplicate: u32,
    /// Lost: frames that never arrived, by the camera's counter.
    pub counter_gap: u32,
    /// Oddity: a whole new frame with the frame identifier of the last one.
    pub fid_repeated: u32,
    /// Oddity: a full frame without the end-of-frame bit.
    pub eof_missing: u32,
    /// Oddity: no frame counter; the sequence number was continued by one.
    pub counter_missing: u32,
    /// Oddity: the counter went back while time went on (the camera restarted it).
    pub counter_restarted: u32,
}

impl Losses {
    /// Books one lost frame.
    pub(super) fn book(&mut self, cause: Cause) {
        let counter = match cause {
            Cause::EmptyPayload => &mut self.empty_payload,
            Cause::BadHeader => &mut self.bad_header,
            Cause::ErrorBit => &mut self.error_bit,
            Cause::ShortFrame => &mut self.short_frame,
            Cause::OverlongFrame => &mut self.overlong_frame,
            Cause::FrameUnended => &mut self.frame_unended,
            Cause::PtsMissing => &mut self.pts_missing,
            Cause::PtsBackwards => &mut self.pts_backwards,
            Cause::Duplicate => &mut self.duplicate,
        };
        *counter = counter.saturating_add(1);
    }

    /// Frames that the camera made and nobody will see; a duplicate is no loss, its first copy came out.
    #[must_use]
    pub fn frames(&self) -> u32 {
        [
            self.empty_payload,
            self.bad_header,
            self.error_bit,
            self.short_frame,
            self.overlong_frame,
            self.frame_unended,
            self.pts_missing,
            self.pts_backwards,
            self.counter_gap,
        ]
        .into_iter()
        .fold(0, u32::saturating_add)
    }
}
