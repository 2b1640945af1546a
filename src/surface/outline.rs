//! The stream of the outline: its payloads to grey images, whatever the camera sends.

use super::rectify::Rectifier;
use super::region::Region;
use crate::usb::frame::Stamp;
use crate::usb::uvc::{Assembler, AssemblyOutcome, Losses};

/// Joins the payloads of the outline's stream: Y8 as it comes, or YUY2 [rectified](Rectifier) into a second buffer.
///
/// ```
/// use meniscus::surface::{OutlineAssembler, Region};
///
/// let mut buffer = [0; 4];
/// let mut outline = OutlineAssembler::infrared(&mut buffer);
/// // Length 6, flags PTS | EOF, PTS = 1000 us, an image of 2 x 2.
/// let stamp = outline.push(&[6, 0b110, 0xe8, 3, 0, 0, 1, 2, 3, 4], Region::whole((2, 2)));
/// assert_eq!(stamp.map(|stamp| stamp.captured.0), Some(1000));
/// assert_eq!(outline.pixels(), [1, 2, 3, 4]);
/// ```
#[derive(Debug)]
pub struct OutlineAssembler<'b> {
    assembler: Assembler<'b>,
    colour: Option<(Rectifier, &'b mut [u8])>,
}

impl<'b> OutlineAssembler<'b> {
    /// Of the infrared image, whose pixels are as many as the buffer's bytes.
    #[must_use]
    pub fn infrared(infrared: &'b mut [u8]) -> Self {
        Self { assembler: Assembler::new(infrared), colour: None }
    }

    /// Of the colour image: `colour` has room for [`Rectifier::colour_bytes`], `grey` for
    /// [`Rectifier::grey_bytes`].
    #[must_use]
    pub fn colour(rectifier: Rectifier, colour: &'b mut [u8], grey: &'b mut [u8]) -> Self {
        Self { assembler: Assembler::new(colour), colour: Some((rectifier, grey)) }
    }

    /// Takes a payload; the stamp of the frame that it ended, whose grey image is then in [`pixels`](Self::pixels):
    /// of infrared all of it, of colour `region`.
    pub fn push(&mut self, payload: &[u8], region: Region) -> Option<Stamp> {
        let AssemblyOutcome::Frame(frame) = self.assembler.push(payload) else { return None };
        let stamp = frame.stamp;
        if let Some((rectifier, grey)) = &mut self.colour {
            rectifier.rectify(frame.pixels, grey, region);
        }
        Some(stamp)
    }

    /// The last grey image, until the next payload.
    #[must_use]
    pub fn pixels(&self) -> &[u8] {
        self.colour.as_ref().map_or_else(|| self.assembler.pixels(), |(_, grey)| grey)
    }

    /// The books so far.
    #[must_use]
    pub fn losses(&self) -> Losses {
        self.assembler.losses()
    }
}
