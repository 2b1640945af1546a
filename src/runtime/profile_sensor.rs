//! The eye: payloads of two streams in, one profile an instant out.

use super::budget::Clock;
use crate::surface::{
    self, ExtractionError, OutlineAssembler, Rectifier, SurfaceProfile, extract, extract_outline,
};
use crate::usb::frame::{DepthFrame, OutlineFrame, Stamp};
use crate::usb::uvc::{Assembler, AssemblyOutcome, DeviceClock, Losses, Pairer, Solitary, Stream};

/// The camera's frame interval, microseconds.
const INTERVAL_US: u32 = 16_667;

/// Observation of one frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameObservation {
    /// Number of the depth frame, and the time at which the outline was taken: of infrared the same instant. Of the outline
    /// alone, its own.
    pub stamp: Stamp,
    /// The profile, or why there is none.
    pub profile: Result<SurfaceProfile, ExtractionError>,
    /// Time from whole images to profile, microseconds.
    pub surface_us: u64,
}

/// Assembles, pairs and extracts; buffers are the caller's.
///
/// ```
/// # struct NoClock;
/// # impl meniscus::runtime::Clock for NoClock {
/// #     fn now_us(&mut self) -> u64 {
/// #         0
/// #     }
/// # }
/// use meniscus::runtime::ProfileSensor;
/// use meniscus::surface::{Config, ExtractionError, Settings};
/// use meniscus::usb::uvc::Stream;
///
/// let (mut depth, mut infrared) = (vec![0; 640 * 480 * 2], vec![0; 640 * 480]);
/// let config = Config::new(Settings::default())?;
/// let mut sensor = ProfileSensor::new(config, &mut depth, &mut infrared);
/// // A whole image in one payload: header of 6 bytes, PTS = 1000 us, then grey pixels.
/// let payload = |bytes: usize| [&[6, 0b110, 0xe8, 3, 0, 0][..], &vec![128; bytes]].concat();
/// assert!(sensor.accept(Stream::Depth, &payload(640 * 480 * 2), &mut NoClock).is_none());
/// // The second image completes the pair, and a grey wall has no liquid's edge.
/// let observation = sensor.accept(Stream::Outline, &payload(640 * 480), &mut NoClock).unwrap();
/// assert_eq!(observation.stamp.captured.0, 1000);
/// assert_eq!(observation.profile, Err(ExtractionError::NoContrast));
/// # Ok::<(), meniscus::surface::ConfigError>(())
/// ```
#[derive(Debug)]
pub struct ProfileSensor<'b> {
    config: surface::Config,
    /// Depth images, where the camera has them.
    depth: Option<DepthSide<'b>>,
    outline: OutlineAssembler<'b>,
    clock: DeviceClock,
    state: surface::ExtractionState,
}

/// Depth images and their pairing with the outline's.
#[derive(Debug)]
struct DepthSide<'b> {
    assembler: Assembler<'b>,
    pairer: Pairer,
}

impl<'b> ProfileSensor<'b> {
    /// An eye with buffers of one image each (two bytes a depth pixel), or of two: then a stream may come after the other's next
    /// frame, every time, and its images still pair.
    #[must_use]
    pub fn new(config: surface::Config, depth: &'b mut [u8], infrared: &'b mut [u8]) -> Self {
        let outline = if has_room_for_two(&config, 1, infrared) {
            OutlineAssembler::infrared_keeping_two(infrared)
        } else {
            OutlineAssembler::infrared(infrared)
        };
        Self::with(config, depth, outline)
    }

    /// An eye that traces the outline in the colour image; the buffers of [`OutlineAssembler::colour`], `depth` and `grey` of one
    /// image or of two.
    #[must_use]
    pub fn with_colour(
        config: surface::Config,
        depth: &'b mut [u8],
        rectifier: Rectifier,
        colour: &'b mut [u8],
        grey: &'b mut [u8],
    ) -> Self {
        let outline = if has_room_for_two(&config, 1, grey) {
            OutlineAssembler::colour_keeping_two(rectifier, colour, grey)
        } else {
            OutlineAssembler::colour(rectifier, colour, grey)
        };
        Self::with(config, depth, outline)
    }

    /// A sensor of a camera without depth images: a colour webcam at a known distance. `colour` has room for
    /// [`Rectifier::colour_bytes`], `grey` for [`Rectifier::grey_bytes`]. Depth payloads are not looked at.
    #[must_use]
    pub fn of_outline(
        config: surface::Config,
        rectifier: Rectifier,
        colour: &'b mut [u8],
        grey: &'b mut [u8],
    ) -> Self {
        Self::outline_alone(config, OutlineAssembler::colour(rectifier, colour, grey))
    }

    /// The same where the outline's image comes as it is traced, one byte a pixel.
    #[must_use]
    pub fn of_grey_outline(config: surface::Config, grey: &'b mut [u8]) -> Self {
        Self::outline_alone(config, OutlineAssembler::infrared(grey))
    }

    fn outline_alone(config: surface::Config, outline: OutlineAssembler<'b>) -> Self {
        let (clock, state) = (DeviceClock::default(), surface::ExtractionState::new());
        Self { config, depth: None, outline, clock, state }
    }

    fn with(config: surface::Config, depth: &'b mut [u8], outline: OutlineAssembler<'b>) -> Self {
        let assembler = if has_room_for_two(&config, 2, depth) {
            Assembler::keeping_two(depth)
        } else {
            Assembler::new(depth)
        };
        let pairer = Pairer::new(INTERVAL_US, assembler.kept().min(outline.kept()));
        Self { depth: Some(DepthSide { assembler, pairer }), ..Self::outline_alone(config, outline) }
    }

    /// Returns the lost payloads and frames, depth then outline.
    #[must_use]
    pub fn losses(&self) -> (Losses, Losses) {
        (
            self.depth.as_ref().map_or_else(Losses::default, |depth| depth.assembler.losses()),
            self.outline.losses(),
        )
    }

    /// Returns the losses of the stream whose number a turn has: depth, or the outline alone.
    #[must_use]
    pub fn losses_of_numbered(&self) -> Losses {
        self.depth.as_ref().map_or_else(|| self.outline.losses(), |depth| depth.assembler.losses())
    }

    /// Frames whose partner never came.
    #[must_use]
    pub fn solitary(&self) -> Solitary {
        self.depth.as_ref().map_or_else(Solitary::default, |depth| depth.pairer.solitary())
    }

    /// The last whole image in which the outline is traced, Y8.
    #[must_use]
    pub fn outline(&self) -> &[u8] {
        self.outline.pixels()
    }

    /// The last whole depth image, Z16 little-endian; empty without depth images.
    #[must_use]
    pub fn depth(&self) -> &[u8] {
        self.depth.as_ref().map_or(&[], |depth| depth.assembler.pixels())
    }

    /// Takes one payload; gives what was seen if it completes a pair of images, or the outline's where there is no depth.
    pub fn accept<C: Clock>(
        &mut self,
        stream: Stream,
        payload: &[u8],
        clock: &mut C,
    ) -> Option<FrameObservation> {
        let Self { config, depth, outline, clock: device_clock, state } = self;
        let (width, height) = config.image_size();
        let Some(DepthSide { assembler, pairer }) = depth else {
            let wanted = stream == Stream::Outline;
            let stamp =
                wanted.then(|| outline.push(payload, state.region(config), device_clock)).flatten()?;
            let start_us = clock.now_us();
            let frame = OutlineFrame { bytes: outline.pixels(), width, height, stamp };
            let profile = extract_outline(config, state, frame);
            return Some(FrameObservation {
                stamp,
                profile,
                surface_us: clock.now_us().saturating_sub(start_us),
            });
        };
        let frame = match stream {
            Stream::Depth => match assembler.push(payload, device_clock) {
                AssemblyOutcome::Frame(frame) => frame.stamp,
                AssemblyOutcome::Partial | AssemblyOutcome::Lost(_) => return None,
            },
            Stream::Outline => outline.push(payload, state.region(config), device_clock)?,
        };
        let pair = pairer.offer(stream, frame)?;
        let start_us = clock.now_us();
        let stamp = config.stamp_of(pair.depth, pair.outline);
        // Pixels of a frame that waited are gone once a later one has begun in their place.
        let (depth, outline) = (assembler.pixels_of(pair.depth)?, outline.pixels_of(pair.outline)?);
        let depth = DepthFrame { bytes: depth, width, height, stamp: pair.depth };
        let outline = OutlineFrame { bytes: outline, width, height, stamp: pair.outline };
        let profile = extract(config, state, depth, outline);
        let surface_us = clock.now_us().saturating_sub(start_us);
        Some(FrameObservation { stamp, profile, surface_us })
    }
}

/// Whether `buffer` has room for two images of so many bytes a pixel.
fn has_room_for_two(config: &surface::Config, pixel_bytes: usize, buffer: &[u8]) -> bool {
    let (width, height) = config.image_size();
    buffer.len() >= 2 * pixel_bytes * width * height
}
