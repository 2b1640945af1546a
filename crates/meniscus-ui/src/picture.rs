//! The picture at the end of a run: what the camera saw, what the model says is inside, what was
//! inside, and how far the two were apart.

use meniscus_report::plot::{BLUE, FONT, GREEN, GREY, ORANGE, PURPLE, PictureError, prepare_font};
use plotters::prelude::*;
use plotters::style::colors::colormaps::{ColorMap, ViridisRGB};

/// Width and height of the picture, pixels.
pub const SIZE: (u32, u32) = (1500, 1000);

/// Share of the height that the upper row of panels has.
const UPPER: f64 = 0.56;

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
}

/// Returns the words of `text` in lines of at most `most` characters, but for a word that is longer.
fn wrapped(text: &str, most: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.len() + 1 + word.len() <= most => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.into()),
        }
    }
    lines
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
            let title = format!("{}; colour: {}, violet 0 to yellow {top:.3}", self.title, self.value);
            let mut area = area.titled(&title, (FONT, size.1 / 45))?;
            let height = size.1 / 62;
            for line in wrapped(self.unknown.as_deref().unwrap_or(""), (3 * size.0 / (2 * height)) as usize) {
                area = area.titled(&line, (FONT, height))?;
            }
            let (upper, lower) = area.split_vertically((UPPER * f64::from(size.1)) as u32);
            let panels = upper.split_evenly((1, 1 + self.slices.len()));
            let mut panels = panels.iter();
            if let Some(panel) = panels.next() {
                self.draw_camera(panel)?;
            }
            for ((name, slice), panel) in self.slices.iter().zip(panels) {
                self.draw_slice(panel, name, slice, top)?;
            }
            self.draw_errors(&lower)?;
            area.present()?;
        }
        Ok(pixels)
    }

    fn draw_camera(&self, panel: &Panel<'_>) -> Result<(), PictureError> {
        let panel = panel.titled("measured orange, estimated green", (FONT, 18))?;
        let (left, top, width, height) = self.camera.crop;
        let (across, down) = panel.dim_in_pixel();
        let zoom = (f64::from(across) / width as f64).min(f64::from(down) / height as f64);
        let place = |u: f64, v: f64| {
            let x = (u + 0.5 - left as f64) * zoom;
            let y = (v + 0.5 - top as f64) * zoom;
            (x.round() as i32, y.round() as i32)
        };
        for row in top..top + height {
            for column in left..left + width {
                let grey = self.camera.infrared.get(row * self.camera.size.0 + column).copied().unwrap_or(0);
                let (u, v) = (column as f64, row as f64);
                let box_ = [place(u - 0.5, v - 0.5), place(u + 0.5, v + 0.5)];
                panel.draw(&Rectangle::new(box_, RGBColor(grey, grey, grey).filled()))?;
            }
        }
        let pixel = |&(u, v): &(f32, f32)| place(f64::from(u), f64::from(v));
        for point in &self.camera.measured {
            panel.draw(&Circle::new(pixel(point), 5, ORANGE.filled()))?;
        }
        let line: Vec<_> = self.camera.estimated.iter().map(pixel).collect();
        panel.draw(&PathElement::new(line, GREEN.stroke_width(2)))?;
        Ok(())
    }

    /// Largest value of all slices: the same colour means the same value in each.
    fn top_value(&self) -> f64 {
        if let Some(top) = self.top {
            return top.max(f64::MIN_POSITIVE);
        }
        let values = self.slices.iter().flat_map(|(_, slice)| slice.values());
        values.fold(f64::MIN_POSITIVE, f64::max)
    }

    fn draw_slice(&self, panel: &Panel<'_>, name: &str, slice: &Slice, top: f64) -> Result<(), PictureError> {
        let (half, height) = self.glass_mm;
        let known = slice.tracers.iter().all(|tracer| tracer.value.is_some());
        let name = if known { name.into() } else { format!("{name}: {} not known", self.value) };
        let mut chart = ChartBuilder::on(panel)
            .caption(name, (FONT, 18))
            .margin(10)
            .x_label_area_size(34)
            .y_label_area_size(40)
            .build_cartesian_2d(-1.1 * half..1.1 * half, 0.0..height)?;
        chart.configure_mesh().disable_mesh().x_desc("x, mm").y_desc("z, mm").draw()?;
        let wall = [(-half, height), (-half, 0.0), (half, 0.0), (half, height)];
        chart.draw_series([PathElement::new(wall.to_vec(), GREY.stroke_width(2))])?;
        let dot = |tracer: &SliceTracer| {
            let colour = |value: f64| ViridisRGB.get_color((value / top).min(1.0) as f32).to_rgba();
            let grey = GREY.mix(0.35);
            Circle::new(tracer.at_mm, 6, tracer.value.map_or(grey, colour).filled())
        };
        chart.draw_series(slice.tracers.iter().map(dot))?;
        Ok(())
    }

    fn draw_errors(&self, panel: &Panel<'_>) -> Result<(), PictureError> {
        let all = || self.errors.iter().flat_map(|curve| &curve.points);
        let end = all().map(|point| point.0).fold(0.1, f64::max);
        let most = all().map(|point| point.1).fold(0.1, f64::max);
        let mut chart = ChartBuilder::on(panel)
            .caption("error of the surface, |z - estimate| / z, mean over the profile", (FONT, 20))
            .margin(10)
            .x_label_area_size(40)
            .y_label_area_size(60)
            .build_cartesian_2d(0.0..end, 0.0..1.05 * most)?;
        chart.configure_mesh().x_desc("time, s").y_desc("error, %").draw()?;
        let colours = [BLUE, GREY, PURPLE, ORANGE];
        for (curve, colour) in self.errors.iter().zip(colours) {
            let points = curve.points.iter().copied();
            let line = LineSeries::new(points, colour.stroke_width(2));
            chart
                .draw_series(line)?
                .label(curve.name.as_str())
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 24, y)], colour.stroke_width(3)));
        }
        if let Some(now) = self.now_s {
            chart.draw_series([PathElement::new([(now, 0.0), (now, 1.05 * most)], GREEN.stroke_width(2))])?;
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperLeft)
            .label_font((FONT, 16))
            .background_style(WHITE.mix(0.8))
            .border_style(GREY)
            .draw()?;
        Ok(())
    }
}

/// A part of the picture.
type Panel<'a> = DrawingArea<BitMapBackend<'a>, plotters::coord::Shift>;

/// RGB pixels to PNG bytes.
fn encode(pixels: &[u8]) -> Result<Vec<u8>, PictureError> {
    use image::ImageEncoder;
    let mut bytes = Vec::new();
    image::codecs::png::PngEncoder::new(&mut bytes)
        .write_image(pixels, SIZE.0, SIZE.1, image::ExtendedColorType::Rgb8)
        .map_err(|error| PictureError(error.to_string()))?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_hold_all_words_and_no_more_than_they_may() {
        let text = "This model was corrected from the free surface alone.";
        let lines = wrapped(text, 20);
        assert_eq!(lines.join(" "), text);
        assert!(lines.iter().all(|line| line.len() <= 20), "{lines:?}");
        assert_eq!(wrapped("uncommonly", 4), ["uncommonly"]);
        assert!(wrapped("", 20).is_empty());
    }
}
