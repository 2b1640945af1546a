//! The plan: which interface, endpoint and mode each stream uses, read from the descriptors.

use super::error::CameraError;
use super::settings::{OutlineImage, RATE_HZ};
use meniscus::usb::d4xx::UNIT_GUID;
use meniscus::usb::uvc::descriptor;
use meniscus::usb::uvc::descriptor::{Interface, VIDEO_CONTROL};
use meniscus::usb::uvc::format::{PixelFormat, video_modes};
use meniscus::usb::uvc::{Stream, Topology, extension_unit, probe_length};

/// Transfer types of endpoints.
const BULK: u8 = 2;
const INTERRUPT: u8 = 3;

/// One stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StreamPlan {
    /// Which.
    pub stream: Stream,
    /// Pixel format.
    pub pixels: PixelFormat,
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
        name(self.pixels)
    }

    /// Bytes of a transfer: an image, the longest header, rounded up to whole packets.
    #[must_use]
    pub fn transfer_bytes(&self) -> usize {
        (self.frame_bytes as usize + 1024).next_multiple_of(usize::from(self.packet.max(1)))
    }
}

/// Name of the infrared stream.
pub(super) const INFRARED: &str = "infrared";

fn name(pixels: PixelFormat) -> &'static str {
    match pixels {
        PixelFormat::Z16 => "depth",
        PixelFormat::Yuy2 => "colour",
        _ => INFRARED,
    }
}

/// Colour function of a camera, if its colour image is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ColourPlan {
    /// Its control interface.
    pub control: u8,
    /// Its camera terminal.
    pub terminal: u8,
}

/// The depth function of a camera, and its colour function where the outline is traced in colour.
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
    /// Depth, then the outline's: left infrared or colour.
    pub streams: [StreamPlan; 2],
    /// The colour function, if the outline is traced in it.
    pub colour: Option<ColourPlan>,
    /// Pixels in a row, rows.
    pub size: (u16, u16),
}

impl Plan {
    /// Reads the configuration descriptor for images of `size`.
    ///
    /// # Errors
    /// [`CameraError`] says what is missing.
    pub fn read(configuration: &[u8], size: (u16, u16), outline: OutlineImage) -> Result<Self, CameraError> {
        descriptor::check(configuration).map_err(CameraError::Descriptors)?;
        let all: Vec<Interface<'_>> = descriptor::interfaces(configuration).collect();
        let functions = || all.iter().filter(|interface| interface.class == VIDEO_CONTROL);
        let (control, unit) = functions()
            .find_map(|interface| Some((interface, extension_unit(interface, &UNIT_GUID)?)))
            .ok_or(CameraError::Missing("depth extension unit"))?;
        let topology = Topology::of(control).ok_or(CameraError::Missing("video control header"))?;
        let depth = stream(&of(&topology, &all), Stream::Depth, PixelFormat::Z16, size)?;
        let (second, colour) = match outline {
            OutlineImage::Infrared => {
                (stream(&of(&topology, &all), Stream::Outline, PixelFormat::Y8, size)?, None)
            }
            OutlineImage::Colour => {
                let mut others = functions().filter(|interface| interface.number != control.number);
                let (interface, topology) = others
                    .find_map(|interface| Some((interface, Topology::of(interface)?)))
                    .ok_or(CameraError::Missing("colour function"))?;
                let terminal =
                    topology.camera.ok_or(CameraError::Missing("terminal of the colour camera"))?;
                let plan = stream(&of(&topology, &all), Stream::Outline, PixelFormat::Yuy2, size)?;
                (plan, Some(ColourPlan { control: interface.number, terminal }))
            }
        };
        Ok(Self {
            control: control.number,
            unit,
            interrupt: control.input(INTERRUPT).map(|endpoint| endpoint.address),
            probe_length: probe_length(topology.version),
            streams: [depth, second],
            colour,
            size,
        })
    }

    /// The interfaces that a program has to hold.
    pub(super) fn interfaces(&self) -> impl Iterator<Item = u8> {
        let colour = self.colour.map(|colour| colour.control);
        [self.control].into_iter().chain(colour).chain(self.streams.map(|stream| stream.interface))
    }

    /// The stream of an endpoint.
    pub(super) fn stream_of(&self, endpoint: u8) -> Option<usize> {
        self.streams.iter().position(|stream| stream.endpoint == endpoint)
    }
}

/// The streaming interfaces of a function.
fn of<'a, 'd>(topology: &Topology<'_>, all: &'a [Interface<'d>]) -> Vec<&'a Interface<'d>> {
    all.iter().filter(|interface| topology.streaming.contains(&interface.number)).collect()
}

fn stream(
    own: &[&Interface<'_>],
    stream: Stream,
    pixels: PixelFormat,
    size: (u16, u16),
) -> Result<StreamPlan, CameraError> {
    for interface in own {
        let fits = |mode: &_| {
            let mode: &meniscus::usb::uvc::format::VideoMode<'_> = mode;
            mode.pixels == pixels && (mode.width, mode.height) == size && mode.interval_of(RATE_HZ).is_some()
        };
        let Some(mode) = video_modes(interface).find(fits) else { continue };
        let endpoint = interface.input(BULK).ok_or(CameraError::Missing("bulk endpoint"))?;
        return Ok(StreamPlan {
            stream,
            pixels,
            interface: interface.number,
            endpoint: endpoint.address,
            packet: endpoint.packet,
            mode: (mode.format, mode.frame),
            interval: mode.interval_of(RATE_HZ).unwrap_or_default(),
            // Not the descriptor's word: the size of the pixels that are understood here.
            frame_bytes: u32::from(size.0) * u32::from(size.1) * pixels.bytes().unwrap_or(1),
        });
    }
    Err(CameraError::NoMode { stream: name(pixels), size })
}
