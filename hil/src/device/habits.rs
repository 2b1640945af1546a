//! Habits of the device beside its trouble: its clock over a restart, and the order in which its streams bring their frames.

use crate::camera::Stream;

/// Manners of a camera's clock and streams. The default is a camera whose clock goes on, and whose streams start and arrive together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Habits {
    /// Clock and frame counter begin anew whenever the device comes back to the bus, as at power-up.
    pub clock_restarts: bool,
    /// Device time before the middle of the first exposure, microseconds of 32 bits: how long the camera has been up.
    pub up_us: u32,
    /// Frames of depth, and of the image beside it, that are lost at every start of the streams.
    pub lost_at_start: [u8; 2],
    /// The stream whose frames come behind the next frame of the other one.
    pub lags: Option<Lag>,
    /// Parts per million by which the device's clock runs faster than the bus's.
    pub drift_ppm: i32,
    /// Step of the device's clock.
    pub step: Option<ClockStep>,
    /// Shot at which somebody pulls the camera out; it is back two seconds later.
    pub replug_shot: Option<u64>,
}

/// Step of the device's clock, to later times: the next stamps are ahead.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ClockStep {
    /// Shot before which it steps.
    pub shot: u64,
    /// Size, microseconds.
    pub by_us: u32,
}

/// The stream that lags.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lag {
    /// Depth.
    Depth,
    /// The image beside it.
    Beside,
}

/// Delay of a lagging frame, microseconds: a frame interval and a little.
const LAG_US: u64 = 18_000;

impl Habits {
    /// Whether the frame of `stream` in the shot number `shot` since the start of the streams is lost.
    pub(super) fn loses(&self, stream: Stream, shot: u64) -> bool {
        let [depth, beside] = self.lost_at_start;
        shot < u64::from(if stream == Stream::Depth { depth } else { beside })
    }

    /// Time of the device's clock from the first shot to another one that lies `bus_us` behind it on the bus, microseconds.
    pub(super) fn since_first_us(&self, bus_us: u64) -> u64 {
        let drift_us = bus_us as i128 * i128::from(self.drift_ppm) / 1_000_000;
        bus_us.wrapping_add_signed(drift_us as i64)
    }

    /// Delay of a frame of `stream`, microseconds.
    pub(super) fn delay_us(&self, stream: Stream) -> u64 {
        let lags = match self.lags {
            None => false,
            Some(Lag::Depth) => stream == Stream::Depth,
            Some(Lag::Beside) => stream != Stream::Depth,
        };
        if lags { LAG_US } else { 0 }
    }
}
