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
