//! Tags of the family 36h11 in a grey image: near where the last one was, or anywhere.
//!
//! The work is that of `locus-core`: threshold, connected dark regions, quadrangles, bits, corners refined below a pixel. The refinement
//! skips squares of less than 3.3 pixels: the region around a small tag is looked at in double size.

use crate::region::{Part, Region};
use locus_core::{Detector, DetectorBuilder, DetectorConfig, ImageView, TagFamily};

/// Distance that a tag may move between two images, px.
const REACH_PX: f64 = 24.0;
/// Side of a small tag, px: of eight squares of 3.3 pixels, and a share more for a tag that goes away.
const SMALL_PX: f64 = 32.0;
/// Bytes behind the image that the detector's wide loads may touch.
const PADDING: usize = 64;
/// Wrong bits that are corrected. The family keeps 11 apart; a number that is not the tag's is worse than none.
const MOST_WRONG_BITS: u32 = 1;
/// From the detector's coordinates, which begin at the edge of the first pixel, to those of the lens, which begin at its centre, px.
const TO_CENTRE_PX: f64 = -0.5;

/// Place of the top left corner among the detector's: it calls the upright tag of AprilTag 3 upside down.
const FIRST_CORNER: usize = 2;

/// A tag in an image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenTag {
    /// Its number in the family.
    pub number: u32,
    /// Corners of its black border, px: top left, top right, bottom right, bottom left of the upright tag.
    pub corners_px: [[f64; 2]; 4],
}

/// Failure of the detector.
#[derive(Debug, thiserror::Error)]
#[error("the image cannot be searched for tags: {0}")]
pub struct FinderError(String);

/// Finds tags. It keeps its buffers between images.
pub struct TagFinder {
    single: Detector,
    doubled: Detector,
    size: (usize, usize),
    pixels: Vec<u8>,
    /// Found in the last image.
    found: Vec<SeenTag>,
}

impl std::fmt::Debug for TagFinder {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("TagFinder").field("size", &self.size).finish_non_exhaustive()
    }
}

impl TagFinder {
    /// Returns a finder for images of `size`, width and height.
    ///
    /// # Errors
    /// A configuration that the detector refuses.
    pub fn new(size: (usize, usize)) -> Result<Self, FinderError> {
        let detector = |upscale_factor| {
            let max_hamming_error = Some(MOST_WRONG_BITS);
            let config = DetectorConfig { upscale_factor, max_hamming_error, ..DetectorConfig::default() };
            let builder = DetectorBuilder::new().with_config(config).with_family(TagFamily::AprilTag36h11);
            builder.validated_build().map_err(|error| FinderError(error.to_string()))
        };
        let pixels = Vec::with_capacity(size.0 * size.1 + PADDING);
        Ok(Self { single: detector(1)?, doubled: detector(2)?, size, pixels, found: Vec::new() })
    }

    /// Returns all tags in `image`, row-major grey levels.
    ///
    /// # Errors
    /// [`FinderError`].
    pub fn anywhere(&mut self, image: &[u8]) -> Result<&[SeenTag], FinderError> {
        let (right, bottom) = self.size;
        self.within(image, Part { region: Region { left: 0, right, top: 0, bottom }, scale: 1 })
    }

    /// Returns the tags in a `part` of `image`.
    ///
    /// # Errors
    /// [`FinderError`].
    pub(crate) fn within(&mut self, image: &[u8], part: Part) -> Result<&[SeenTag], FinderError> {
        cut(image, self.size.0, part, &mut self.pixels);
        search(&mut self.single, part, &mut self.pixels, &mut self.found)?;
        Ok(&self.found)
    }

    /// Returns the tags in a `part` of `image` beside `tag`, which is painted over: it takes the detector as long as all the rest.
    ///
    /// # Errors
    /// [`FinderError`].
    pub(crate) fn beside(
        &mut self,
        image: &[u8],
        part: Part,
        tag: &SeenTag,
    ) -> Result<&[SeenTag], FinderError> {
        cut(image, self.size.0, part, &mut self.pixels);
        let columns = part.columns();
        let grey = self.pixels.first().copied().unwrap_or_default();
        let Region { left, right, top, bottom } = Region::around(&tag.corners_px, self.size, 0.0);
        let Part { region, scale } = part;
        let rows = self.pixels.chunks_exact_mut(columns.max(1)).enumerate();
        for (_, row) in rows.filter(|(row, _)| (top..bottom).contains(&(region.top + scale * row))) {
            let inside = |column: usize| (column.saturating_sub(region.left) / scale).min(columns);
            row[inside(left)..inside(right)].fill(grey);
        }
        search(&mut self.single, part, &mut self.pixels, &mut self.found)?;
        Ok(&self.found)
    }

    /// Returns the tags in `image` around the corners of an earlier one.
    ///
    /// # Errors
    /// [`FinderError`].
    pub fn nearby(&mut self, image: &[u8], corners_px: &[[f64; 2]; 4]) -> Result<&[SeenTag], FinderError> {
        let (width, height) = self.size;
        let region = Region::around(corners_px, self.size, REACH_PX);
        if region.left + 8 > region.right || region.top + 8 > region.bottom || image.len() < width * height {
            self.found.clear();
            return Ok(&self.found);
        }
        let detector = if is_small(corners_px) { &mut self.doubled } else { &mut self.single };
        let part = Part { region, scale: 1 };
        cut(image, width, part, &mut self.pixels);
        search(detector, part, &mut self.pixels, &mut self.found)?;
        Ok(&self.found)
    }
}

/// Whether the corners of a tag are better in double size.
pub(crate) fn is_small(corners_px: &[[f64; 2]; 4]) -> bool {
    let sides_px = (0..4).map(|k| {
        let ([x, y], [to_x, to_y]) = (corners_px[k], corners_px[(k + 1) % 4]);
        (to_x - x).hypot(to_y - y)
    });
    sides_px.fold(f64::INFINITY, f64::min) < SMALL_PX
}

impl SeenTag {
    /// Returns its centre, px.
    pub(crate) fn centre_px(&self) -> [f64; 2] {
        [0, 1].map(|axis| 0.25 * self.corners_px.iter().map(|corner| corner[axis]).sum::<f64>())
    }
}

/// Fills `pixels` with a part of an image of `width`.
fn cut(image: &[u8], width: usize, part: Part, pixels: &mut Vec<u8>) {
    let Part { region: Region { left, right, top, bottom }, scale } = part;
    pixels.clear();
    for line in image.get(top * width..bottom * width).unwrap_or_default().chunks_exact(scale * width) {
        if scale == 1 {
            pixels.extend_from_slice(&line[left..right]);
            continue;
        }
        pixels.extend((0..part.columns()).map(|column| {
            let block = line.chunks_exact(width).flat_map(|row| &row[left + scale * column..][..scale]);
            (block.map(|grey| usize::from(*grey)).sum::<usize>() / (scale * scale)) as u8
        }));
    }
}

/// Searches the `pixels` of a part.
fn search(
    detector: &mut Detector,
    part: Part,
    pixels: &mut Vec<u8>,
    found: &mut Vec<SeenTag>,
) -> Result<(), FinderError> {
    let Part { region: Region { left, top, .. }, scale } = part;
    let columns = part.columns();
    let rows = pixels.len() / columns.max(1);
    pixels.resize(pixels.len() + PADDING, 0);
    let view = ImageView::new(pixels, columns, rows, columns).map_err(FinderError)?;
    let tags = detector.detect(&view, None, None, false).map_err(|error| FinderError(error.to_string()))?;
    let (x, y) = (left as f64 + TO_CENTRE_PX, top as f64 + TO_CENTRE_PX);
    found.clear();
    found.extend(tags.ids.iter().zip(tags.corners).map(|(number, corners)| SeenTag {
        number: *number,
        corners_px: std::array::from_fn(|k| {
            let corner = corners[(k + FIRST_CORNER) % corners.len()];
            [scale as f64 * f64::from(corner.x) + x, scale as f64 * f64::from(corner.y) + y]
        }),
    }));
    Ok(())
}
