//! The plan: which interface, endpoint and mode each stream uses, read from the descriptors.

use super::error::CameraError;
use super::settings::RATE_HZ;
use crate::d4xx::UNIT_GUID;
use crate::host::prelude::*;
use crate::uvc::descriptor::{self, Interface, VIDEO_CONTROL};
use crate::uvc::format::{PixelFormat, video_modes};
use crate::uvc::{Stream, Topology, extension_unit, probe_length};

/// Transfer types of endpoints.
const BULK: u8 = 2;
const INTERRUPT: u8 = 3;

/// One stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StreamPlan {
    /// Which.
    pub stream: Stream,
    /// Its streaming interface.
    pub interface: u8,
    /// Its bulk endpoint.
    pub endpoint: u8,
    /// wMaxPacketSize of the endpoint.
    pub packet: u16,
    /// Format and frame index.
    pub mode: (u8, u8),
    /// Frame interval, 100 ns.
    pub interval: u32,
    /// Bytes of an image.
    pub frame_bytes: u32,
}

impl StreamPlan {
    /// As it is printed.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self.stream {
            Stream::Depth => "depth",
            Stream::Infrared => "infrared",
        }
    }

    /// Bytes of a transfer: an image, the longest header, rounded up to whole packets.
    #[must_use]
    pub fn transfer_bytes(&self) -> usize {
        (self.frame_bytes as usize + 1024).next_multiple_of(usize::from(self.packet.max(1)))
    }
}

/// The depth function of a camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// Its control interface.
    pub control: u8,
    /// Its extension unit.
    pub unit: u8,
    /// Interrupt endpoint, if it has one.
    pub interrupt: Option<u8>,
    /// Bytes of a probe record.
    pub probe_length: usize,
    /// Depth and left infrared.
    pub streams: [StreamPlan; 2],
    /// Pixels in a row, rows.
    pub size: (u16, u16),
}

impl Plan {
    /// Reads the configuration descriptor for images of `size`.
    ///
    /// # Errors
    /// [`CameraError`] says what is missing.
    pub fn read(configuration: &[u8], size: (u16, u16)) -> Result<Self, CameraError> {
        descriptor::check(configuration).map_err(CameraError::Descriptors)?;
        let all: Vec<Interface<'_>> = descriptor::interfaces(configuration).collect();
        let function = all.iter().filter(|interface| interface.class == VIDEO_CONTROL);
        let (control, unit) = function
            .filter_map(|interface| Some((interface, extension_unit(interface, &UNIT_GUID)?)))
            .next()
            .ok_or(CameraError::Missing("depth extension unit"))?;
        let topology = Topology::of(control).ok_or(CameraError::Missing("video control header"))?;
        let own = |interface: &&Interface<'_>| topology.streaming.contains(&interface.number);
        let own: Vec<&Interface<'_>> = all.iter().filter(own).collect();
        let depth = stream(&own, Stream::Depth, PixelFormat::Z16, size)?;
        let infrared = stream(&own, Stream::Infrared, PixelFormat::Y8, size)?;
        Ok(Self {
            control: control.number,
            unit,
            interrupt: control.input(INTERRUPT).map(|endpoint| endpoint.address),
            probe_length: probe_length(topology.version),
            streams: [depth, infrared],
            size,
        })
    }

    /// The stream of an endpoint.
    pub(super) fn stream_of(&self, endpoint: u8) -> Option<usize> {
        self.streams.iter().position(|stream| stream.endpoint == endpoint)
    }
}

fn stream(
    own: &[&Interface<'_>],
    stream: Stream,
    pixels: PixelFormat,
    size: (u16, u16),
) -> Result<StreamPlan, CameraError> {
    let name = if stream == Stream::Depth { "depth" } else { "infrared" };
    for interface in own {
        let fits = |mode: &_| {
            let mode: &crate::uvc::format::VideoMode<'_> = mode;
            mode.pixels == pixels && (mode.width, mode.height) == size && mode.interval_of(RATE_HZ).is_some()
        };
        let Some(mode) = video_modes(interface).find(fits) else { continue };
        let endpoint = interface.input(BULK).ok_or(CameraError::Missing("bulk endpoint"))?;
        return Ok(StreamPlan {
            stream,
            interface: interface.number,
            endpoint: endpoint.address,
            packet: endpoint.packet,
            mode: (mode.format, mode.frame),
            interval: mode.interval_of(RATE_HZ).unwrap_or_default(),
            // Not the descriptor's word: the size of the pixels that are understood here.
            frame_bytes: u32::from(size.0) * u32::from(size.1) * pixels.bytes().unwrap_or(1),
        });
    }
    Err(CameraError::NoMode { stream: name, size })
}
