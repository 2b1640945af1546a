//! The stream of the outline: its payloads to grey images, whatever the camera sends.

use super::rectify::Rectifier;
use super::region::Region;
use crate::usb::frame::Stamp;
use crate::usb::uvc::places::Places;
use crate::usb::uvc::{Assembler, AssemblyOutcome, DeviceClock, Losses};

/// Joins the payloads of the outline's stream: Y8 as it comes, or YUY2 [rectified](Rectifier) into a second buffer.
///
/// ```
/// use meniscus::surface::{OutlineAssembler, Region};
/// use meniscus::usb::uvc::DeviceClock;
///
/// let mut buffer = [0; 4];
/// let mut outline = OutlineAssembler::infrared(&mut buffer);
/// // Length 6, flags PTS | EOF, PTS = 1000 us, an image of 2 x 2.
/// let payload = [6, 0b110, 0xe8, 3, 0, 0, 1, 2, 3, 4];
/// let stamp = outline.push(&payload, Region::whole((2, 2)), &mut DeviceClock::default());
/// assert_eq!(stamp.map(|stamp| stamp.captured.0), Some(1000));
/// assert_eq!(outline.pixels(), [1, 2, 3, 4]);
/// ```
#[derive(Debug)]
pub struct OutlineAssembler<'b> {
    assembler: Assembler<'b>,
    colour: Option<(Rectifier, Places<'b>)>,
}

impl<'b> OutlineAssembler<'b> {
    /// Of the infrared image, whose pixels are as many as the buffer's bytes.
    #[must_use]
    pub fn infrared(infrared: &'b mut [u8]) -> Self {
        Self { assembler: Assembler::new(infrared), colour: None }
    }

    /// Of the infrared image; `infrared` has room for two, and the last two are kept.
    #[must_use]
    pub fn infrared_keeping_two(infrared: &'b mut [u8]) -> Self {
        Self { assembler: Assembler::keeping_two(infrared), colour: None }
    }

    /// Of the colour image: `colour` has room for [`Rectifier::colour_bytes`], `grey` for
    /// [`Rectifier::grey_bytes`].
    #[must_use]
    pub fn colour(rectifier: Rectifier, colour: &'b mut [u8], grey: &'b mut [u8]) -> Self {
        Self { assembler: Assembler::new(colour), colour: Some((rectifier, Places::one(grey))) }
    }

    /// Of the colour image; `grey` has room for two grey images, and the last two are kept.
    #[must_use]
    pub fn colour_keeping_two(rectifier: Rectifier, colour: &'b mut [u8], grey: &'b mut [u8]) -> Self {
        Self { assembler: Assembler::new(colour), colour: Some((rectifier, Places::two(grey))) }
    }

    /// Number of images that are kept.
    #[must_use]
    pub fn kept(&self) -> usize {
        self.colour.as_ref().map_or_else(|| self.assembler.kept(), |(_, grey)| grey.count())
    }

    /// Takes a payload; the stamp of the frame that it ended, whose grey image is then in [`pixels`](Self::pixels):
    /// of infrared all of it, of colour `region`. `clock` is that of all streams of the camera.
    pub fn push(&mut self, payload: &[u8], region: Region, clock: &mut DeviceClock) -> Option<Stamp> {
        let AssemblyOutcome::Frame(frame) = self.assembler.push(payload, clock) else { return None };
        let stamp = frame.stamp;
        if let Some((rectifier, grey)) = &mut self.colour {
            grey.begin();
            rectifier.rectify(frame.pixels, grey.room(), region);
            grey.keep(stamp);
        }
        Some(stamp)
    }

    /// The last grey image, until the next payload.
    #[must_use]
    pub fn pixels(&self) -> &[u8] {
        self.colour.as_ref().map_or_else(|| self.assembler.pixels(), |(_, grey)| grey.last())
    }

    /// The grey image of `stamp`, while it is kept.
    #[must_use]
    pub fn pixels_of(&self, stamp: Stamp) -> Option<&[u8]> {
        self.colour.as_ref().map_or_else(|| self.assembler.pixels_of(stamp), |(_, grey)| grey.of(stamp))
    }

    /// The books so far.
    #[must_use]
    pub fn losses(&self) -> Losses {
        self.assembler.losses()
    }
}
