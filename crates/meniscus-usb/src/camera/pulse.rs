//! The pulse of a stream: when it last brought a whole new frame.

use meniscus::usb::uvc::PayloadHeader;
use std::time::Duration;

/// A time stamp that is older than the last one by less than this repeats or comes late, microseconds.
const LATE_US: u32 = 250_000;

/// Class of a payload.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Verdict {
    /// It completes a new frame, of this time stamp.
    Whole(u32),
    /// It is a part of one.
    Part,
    /// It repeats an earlier time.
    Repeated,
    /// Damaged, too long, or with the error bit.
    Damaged,
}

/// The pulse.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pulse {
    /// When a whole new frame last came, or the stream was started.
    pub(super) last: Duration,
    /// Damaged transfers in a row.
    pub(super) damaged_transfers: u32,
    /// Whether a frame has come since the start.
    pub(super) beats: bool,
    frame: Option<(u32, usize)>,
}

impl Pulse {
    /// A stream that is started now. The time of the last frame before is remembered: the same one is
    /// not new after a restart either.
    pub(super) fn started(before: Option<Self>, now: Duration) -> Self {
        Self { last: now, damaged_transfers: 0, beats: false, frame: before.and_then(|pulse| pulse.frame) }
    }

    /// Judges a payload of a stream whose frames have `frame_bytes`.
    pub(super) fn judge(&mut self, payload: &[u8], frame_bytes: usize, now: Duration) -> Verdict {
        let Ok((header, pixels)) = PayloadHeader::split(payload) else { return Verdict::Damaged };
        let Some(pts) = header.pts().filter(|_| !header.error()) else { return Verdict::Damaged };
        let before = match self.frame {
            Some((last, filled)) if last == pts => {
                if filled >= frame_bytes {
                    return Verdict::Repeated;
                }
                filled
            }
            Some((last, _)) if last.wrapping_sub(pts) < LATE_US => return Verdict::Repeated,
            _ => 0,
        };
        let filled = before + pixels.len();
        self.frame = Some((pts, filled));
        match filled.cmp(&frame_bytes) {
            std::cmp::Ordering::Less if header.end_of_frame() => Verdict::Damaged,
            std::cmp::Ordering::Less => Verdict::Part,
            std::cmp::Ordering::Greater => Verdict::Damaged,
            std::cmp::Ordering::Equal => {
                (self.last, self.beats) = (now, true);
                Verdict::Whole(pts)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn payload(pts: u32, end: bool, pixels: usize) -> Vec<u8> {
        let head = [6, 0b100 | (u8::from(end) << 1)];
        [&head[..], &pts.to_le_bytes(), &vec![0; pixels]].concat()
    }

    #[test]
    fn only_a_whole_new_frame_is_a_beat() {
        let mut pulse = Pulse::started(None, Duration::ZERO);
        let mut judge = |pts, end, pixels, at| {
            let verdict = pulse.judge(&payload(pts, end, pixels), 4, Duration::from_millis(at));
            (verdict, pulse.last.as_millis())
        };
        assert_eq!(judge(1000, true, 4, 1), (Verdict::Whole(1000), 1));
        assert_eq!(judge(1000, true, 4, 2), (Verdict::Repeated, 1));
        assert_eq!(judge(900, true, 4, 3), (Verdict::Repeated, 1), "late");
        assert_eq!(judge(2000, true, 3, 4), (Verdict::Damaged, 1), "torn");
        assert_eq!(judge(3000, true, 5, 5), (Verdict::Damaged, 1), "overlong");
        assert_eq!(judge(4000, false, 3, 6), (Verdict::Part, 1));
        assert_eq!(judge(4000, true, 1, 7), (Verdict::Whole(4000), 7));
        assert_eq!(pulse.judge(&[0], 4, Duration::ZERO), Verdict::Damaged);
        let mut again = Pulse::started(Some(pulse), Duration::ZERO);
        assert_eq!(again.judge(&payload(4000, true, 4), 4, Duration::ZERO), Verdict::Repeated);
    }
}
