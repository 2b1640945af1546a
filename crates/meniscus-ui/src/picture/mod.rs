//! The picture at the end of a run: what the camera saw, what the model says is inside, what was
//! inside, and how far the two were apart.

mod camera_panel;
mod errors;
mod slices;

pub use slices::SliceChart;

use crate::wrapped::wrapped;
use meniscus_report::plot::{FONT, PictureError, prepare_font};
use plotters::prelude::*;

/// Width and height of the picture, pixels.
pub const SIZE: (u32, u32) = (1500, 1000);

/// Share of the height that the upper row of panels has.
const UPPER: f64 = 0.58;

/// Width of the scale of the colours, in letters.
const SCALE: u32 = 7;

/// The camera's image with lines on it.
#[derive(Clone, Debug)]
pub struct CameraImage<'a> {
    /// Y8 pixels, row-major.
    pub infrared: &'a [u8],
    /// Width and height.
    pub size: (usize, usize),
    /// Pixels of the measured points.
    pub measured: Vec<(f32, f32)>,
    /// Pixels of the estimated surface.
    pub estimated: Vec<(f32, f32)>,
    /// Part of the image to show: left, top, width, height.
    pub crop: (usize, usize, usize, usize),
}

/// Tracer of a slice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SliceTracer {
    /// Position along x and z, millimetres.
    pub at_mm: (f64, f64),
    /// Value that gives the colour; grey without one, because it is not known.
    pub value: Option<f64>,
}

/// Tracers of a slice through the middle of the glass.
#[derive(Clone, Debug, Default)]
pub struct Slice {
    /// Tracers.
    pub tracers: Vec<SliceTracer>,
}

impl Slice {
    /// Returns the values that are known.
    pub fn values(&self) -> impl Iterator<Item = f64> {
        self.tracers.iter().filter_map(|tracer| tracer.value)
    }
}

/// One curve over time.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Name in the legend.
    pub name: String,
    /// Seconds and value.
    pub points: Vec<(f64, f64)>,
}

/// Everything in the picture.
#[derive(Clone, Debug)]
pub struct Picture<'a> {
    /// First line.
    pub title: String,
    /// The camera's image.
    pub camera: CameraImage<'a>,
    /// The estimated field, and the true one where it is known.
    pub slices: Vec<(String, Slice)>,
    /// Quantity shown by the colour, with its unit.
    pub value: String,
    /// Sentence about what is grey because it is not known.
    pub unknown: Option<String>,
    /// The value at the bright end of the colours; the largest in the slices if `None`.
    pub top: Option<f64>,
    /// Errors over time, per cent.
    pub errors: Vec<Curve>,
    /// The moment that the panels show, seconds, to be marked among the errors.
    pub now_s: Option<f64>,
    /// Half the width of the glass and its height, millimetres.
    pub glass_mm: (f64, f64),
    /// Size of the letters, in units of that of a still picture; more for a film that is shown small.
    pub letters: f64,
}

impl Picture<'_> {
    /// Draws the picture and gives it as the bytes of a PNG file.
    ///
    /// # Errors
    /// [`PictureError`].
    pub fn png(&self) -> Result<Vec<u8>, PictureError> {
        encode(&self.rgb(SIZE)?)
    }

    /// Draws the picture at `size` and gives it as red, green and blue, row after row.
    ///
    /// # Errors
    /// [`PictureError`].
    pub fn rgb(&self, size: (u32, u32)) -> Result<Vec<u8>, PictureError> {
        prepare_font();
        let mut pixels = vec![0; (3 * size.0 * size.1) as usize];
        {
            let area = BitMapBackend::with_buffer(&mut pixels, size).into_drawing_area();
            area.fill(&WHITE)?;
            let top = self.top_value();
            let area = area.margin(self.letter(14), 0, 0, 0);
            let mut area = area.titled(&self.title, (FONT, self.letter(22)))?;
            let height = self.letter(16);
            for line in wrapped(self.unknown.as_deref().unwrap_or(""), (3 * size.0 / (2 * height)) as usize) {
                area = area.titled(&line, (FONT, height))?;
            }
            let (upper, lower) = area.split_vertically((UPPER * f64::from(area.dim_in_pixel().1)) as u32);
            let (upper, scale) = upper.split_horizontally(size.0 - SCALE * self.letter(15));
            let panels = upper.split_evenly((1, 1 + self.slices.len()));
            let mut panels = panels.iter();
            if let Some(panel) = panels.next() {
                self.draw_camera(panel)?;
            }
            for ((name, slice), panel) in self.slices.iter().zip(panels) {
                self.draw_slice(panel, name, slice, top)?;
            }
            self.draw_scale(&scale, top)?;
            self.draw_errors(&lower)?;
            area.present()?;
        }
        Ok(pixels)
    }

    /// Returns the height of letters that are `px` pixels high in a still picture.
    fn letter(&self, px: u32) -> u32 {
        (self.letters * f64::from(px)).round() as u32
    }

    /// Largest value of all slices: the same colour means the same value in each.
    fn top_value(&self) -> f64 {
        if let Some(top) = self.top {
            return top.max(f64::MIN_POSITIVE);
        }
        let values = self.slices.iter().flat_map(|(_, slice)| slice.values());
        values.fold(f64::MIN_POSITIVE, f64::max)
    }
}

/// A part of a picture.
pub type Panel<'a> = DrawingArea<BitMapBackend<'a>, plotters::coord::Shift>;

/// RGB pixels to PNG bytes.
fn encode(pixels: &[u8]) -> Result<Vec<u8>, PictureError> {
    use image::ImageEncoder;
    let mut bytes = Vec::new();
    image::codecs::png::PngEncoder::new(&mut bytes)
        .write_image(pixels, SIZE.0, SIZE.1, image::ExtendedColorType::Rgb8)
        .map_err(|error| PictureError(error.to_string()))?;
    Ok(bytes)
}
