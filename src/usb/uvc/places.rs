//! Images in a buffer of the caller's: one place, or two in turn, so that the one before the last is still there.

use crate::usb::frame::Stamp;

/// One or two places for images of equal length.
#[derive(Debug)]
pub(crate) struct Places<'b> {
    first: Place<'b>,
    second: Option<Place<'b>>,
    /// Whether the second one is written.
    in_second: bool,
}

/// One image, and its stamp once it is whole.
#[derive(Debug)]
struct Place<'b> {
    pixels: &'b mut [u8],
    stamp: Option<Stamp>,
}

impl<'b> Place<'b> {
    fn new(pixels: &'b mut [u8]) -> Self {
        Self { pixels, stamp: None }
    }
}

impl<'b> Places<'b> {
    /// One place.
    pub(crate) fn one(buffer: &'b mut [u8]) -> Self {
        Self { first: Place::new(buffer), second: None, in_second: false }
    }

    /// Two places, each half of `buffer`.
    pub(crate) fn two(buffer: &'b mut [u8]) -> Self {
        let half = buffer.len() / 2;
        let (first, second) = buffer.split_at_mut(half);
        Self { first: Place::new(first), second: Some(Place::new(second)), in_second: false }
    }

    /// Number of places.
    pub(crate) fn count(&self) -> usize {
        1 + usize::from(self.second.is_some())
    }

    /// Bytes of an image.
    pub(crate) fn bytes(&self) -> usize {
        self.first.pixels.len()
    }

    fn place(&self) -> &Place<'b> {
        match &self.second {
            Some(second) if self.in_second => second,
            _ => &self.first,
        }
    }

    fn place_mut(&mut self) -> &mut Place<'b> {
        match &mut self.second {
            Some(second) if self.in_second => second,
            _ => &mut self.first,
        }
    }

    /// Begins an image in the place of the older one.
    pub(crate) fn begin(&mut self) {
        self.in_second = !self.in_second;
        self.place_mut().stamp = None;
    }

    /// Room of the image that has begun.
    pub(crate) fn room(&mut self) -> &mut [u8] {
        self.place_mut().pixels
    }

    /// Notes that the image is whole, and of `stamp`.
    pub(crate) fn keep(&mut self, stamp: Stamp) {
        self.place_mut().stamp = Some(stamp);
    }

    /// The image that was begun last.
    pub(crate) fn last(&self) -> &[u8] {
        self.place().pixels
    }

    /// The whole image of `stamp`, if it is still there.
    pub(crate) fn of(&self, stamp: Stamp) -> Option<&[u8]> {
        let places = [Some(&self.first), self.second.as_ref()];
        places.into_iter().flatten().find(|place| place.stamp == Some(stamp)).map(|place| &*place.pixels)
    }
}
