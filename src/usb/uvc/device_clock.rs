//! The camera's clock, one for all of its streams: 32-bit time stamps, which roll over every 71.6 minutes, to [`Micros`].
//!
//! A stamp is ahead of the newest one by up to half of the circle, or behind it. One that is far behind says that the
//! clock began anew with the camera, when a second one in a row agrees. Time itself never goes back: it goes on from there.
//! Each stream by itself would find that at another frame, and their times would stay apart for ever.

use crate::units::Micros;

/// A stamp that is behind the newest one by less than this is of a stream that lags, or came late, microseconds.
const LATE_US: i64 = 250_000;

/// Time between the last frame before a new start and the first one after it, microseconds: longer than half of a frame
/// interval, so that no frame from before is taken for the partner of one from after.
const RESTART_US: u64 = 33_333;

/// The newest stamp, as sent and as a time.
#[derive(Clone, Copy, Debug)]
struct Newest {
    pts: u32,
    at: Micros,
}

/// Unwraps the time stamps of a camera.
///
/// ```
/// use meniscus::units::Micros;
/// use meniscus::usb::uvc::DeviceClock;
///
/// let mut clock = DeviceClock::default();
/// assert_eq!(clock.time(u32::MAX), Some(Micros(4_294_967_295)));
/// assert_eq!(clock.time(16_666), Some(Micros(4_294_983_962)));
/// // The other stream lags a little; it is on the same time.
/// assert_eq!(clock.time(u32::MAX), Some(Micros(4_294_967_295)));
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct DeviceClock {
    newest: Option<Newest>,
    /// A stamp that was far behind, if it was the last one.
    behind: Option<u32>,
}

impl DeviceClock {
    /// Time of the stamp `pts`, microseconds of 32 bits; `None` where it is far behind the newest one. The second such stamp
    /// in a row starts the clock anew, from the next one on.
    pub fn time(&mut self, pts: u32) -> Option<Micros> {
        let Some(newest) = self.newest else {
            return Some(self.advance(pts, Micros(u64::from(pts))));
        };
        let step = i64::from(pts.wrapping_sub(newest.pts).cast_signed());
        if step >= 0 {
            return Some(self.advance(pts, Micros(newest.at.0.saturating_add(step.unsigned_abs()))));
        }
        if step > -LATE_US {
            self.behind = None;
            return Some(Micros(newest.at.0.saturating_sub(step.unsigned_abs())));
        }
        let agrees = |before: u32| i64::from(pts.wrapping_sub(before).cast_signed()).abs() < LATE_US;
        if self.behind.is_some_and(agrees) {
            self.advance(pts, Micros(newest.at.0.saturating_add(RESTART_US)));
        } else {
            self.behind = Some(pts);
        }
        None
    }

    fn advance(&mut self, pts: u32, at: Micros) -> Micros {
        (self.newest, self.behind) = (Some(Newest { pts, at }), None);
        at
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_that_start_on_either_side_of_the_rollover_share_a_time() {
        let mut clock = DeviceClock::default();
        let depth = clock.time(u32::MAX - 99).expect("a time");
        let infrared = clock.time(100).expect("a time");
        assert_eq!(infrared.0 - depth.0, 200);
        assert_eq!(clock.time((u32::MAX - 99).wrapping_add(16_667)).expect("a time").0, depth.0 + 16_667);
    }

    #[test]
    fn a_clock_that_begins_anew_goes_on_for_both_streams_at_once() {
        let mut clock = DeviceClock::default();
        let last = clock.time(60_000_000).expect("a time");
        assert_eq!((clock.time(500_000), clock.time(500_100)), (None, None));
        let [depth, infrared] = [516_667, 516_767].map(|pts| clock.time(pts).expect("a time").0);
        assert_eq!((depth - last.0, infrared - depth), (RESTART_US + 16_567, 100));
    }

    #[test]
    fn one_stamp_far_behind_is_no_new_start() {
        let mut clock = DeviceClock::default();
        clock.time(60_000_000);
        assert_eq!(clock.time(500_000), None);
        assert_eq!(clock.time(60_016_667), Some(Micros(60_016_667)));
        // The next one is a first one again; a third one elsewhere does not agree with it.
        assert_eq!((clock.time(500_000), clock.time(20_000_000)), (None, None));
        assert_eq!(clock.time(60_033_334), Some(Micros(60_033_334)));
    }
}
