//! The camera: takes images with their time, gives the payloads of its streams.

use crate::payload::{Image, Stamp, pack};

/// Which endpoint a payload comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stream {
    /// Z16, endpoint 0x82.
    Depth,
    /// Y8, endpoint 0x83.
    Infrared,
    /// YUY2, endpoint 0x84.
    Colour,
}

/// The camera's numbers of the pixel formats.
const Z16: u16 = 0;
const Y8: u16 = 1;
const YUY2: u16 = 4;

/// A payload on its way to the host.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Payload {
    /// Its stream.
    pub stream: Stream,
    /// Header and pixels.
    pub bytes: Vec<u8>,
    /// When its transfer completes, microseconds of the device clock.
    pub arrival_us: u64,
}

/// One exposure: the images that are streamed, and the time of its middle.
#[derive(Clone, Copy, Debug)]
pub struct Shot<'a> {
    /// Z16 pixels, little-endian.
    pub depth: &'a [u8],
    /// The image beside it: Y8 pixels of the left imager, or YUY2 pixels of the colour imager.
    pub beside: (Stream, &'a [u8]),
    /// Middle of the exposure, microseconds of the device clock.
    pub captured_us: u64,
}

impl<'a> Shot<'a> {
    /// Of depth (Z16) and left infrared (Y8).
    #[must_use]
    pub fn infrared(depth: &'a [u8], infrared: &'a [u8], captured_us: u64) -> Self {
        Self { depth, beside: (Stream::Infrared, infrared), captured_us }
    }
}

/// Anything that turns shots into payloads.
pub trait Source {
    /// The payloads that a shot leads to, in the order of their arrival.
    fn expose(&mut self, shot: &Shot<'_>) -> Vec<Payload>;
}

/// Image size, rate and exposure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CameraSettings {
    /// Pixels in a row.
    pub width: u16,
    /// Rows.
    pub height: u16,
    /// Frame interval, microseconds.
    pub interval_us: u32,
    /// Exposure, microseconds.
    pub exposure_us: u32,
    /// From the end of the exposure to the end of the transfer, microseconds.
    pub transfer_us: u32,
    /// Lead of the other image's frame counter over that of depth.
    pub counter_offset: u32,
}

impl Default for CameraSettings {
    fn default() -> Self {
        Self {
            width: 640,
            height: 480,
            interval_us: 16_667,
            exposure_us: 4_000,
            transfer_us: 6_000,
            counter_offset: 2,
        }
    }
}

/// A healthy camera.
#[derive(Clone, Debug)]
pub struct Camera {
    settings: CameraSettings,
    counter: u32,
}

impl Camera {
    /// A camera whose frame counter starts at 1.
    #[must_use]
    pub fn new(settings: CameraSettings) -> Self {
        Self { settings, counter: 0 }
    }

    /// Lets the frame counter begin anew, at 1.
    pub fn restart_counter(&mut self) {
        self.counter = 0;
    }
}

impl Source for Camera {
    fn expose(&mut self, shot: &Shot<'_>) -> Vec<Payload> {
        let settings = &self.settings;
        self.counter = self.counter.wrapping_add(1);
        let end_us = shot.captured_us + u64::from(settings.exposure_us / 2);
        let arrival_us = end_us + u64::from(settings.transfer_us);
        let stamp = Stamp {
            fid: self.counter & 1 == 1,
            pts_us: end_us as u32,
            bus_frame: (end_us / 1000) as u16,
            counter: self.counter,
            exposure_us: settings.exposure_us,
            interval_us: settings.interval_us,
        };
        let image = |pixels, format| Image { pixels, width: settings.width, height: settings.height, format };
        let (stream, pixels) = shot.beside;
        let format = if stream == Stream::Colour { YUY2 } else { Y8 };
        let beside = Stamp { counter: stamp.counter.wrapping_add(settings.counter_offset), ..stamp };
        vec![
            Payload { stream: Stream::Depth, bytes: pack(&stamp, &image(shot.depth, Z16)), arrival_us },
            Payload { stream, bytes: pack(&beside, &image(pixels, format)), arrival_us: arrival_us + 300 },
        ]
    }
}
