//! The camera's picture of a glass in a terminal, two pixels a character, with what was found drawn over it.

use meniscus_service::setup::{Body, Portrait};
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Color;
use ratatui::widgets::Widget;

/// Columns of the image that are shown, about its middle: those that are searched.
const COLUMNS: f32 = 256.0;
/// The first of the 24 greys of a terminal with 256 colours.
const BLACK: u8 = 232;
/// Far to near, of the same 256 colours.
const DEPTHS: [u8; 10] = [17, 18, 24, 30, 36, 42, 78, 120, 157, 194];
/// Depths that the colours span, metres.
const FAR_M: f32 = 0.9;
const NEAR_M: f32 = 0.25;
/// Colours of the sides, the traced edge, the surface points and the rest line.
const SIDE: Color = Color::Indexed(51);
const EDGE: Color = Color::Indexed(214);
const POINT: Color = Color::Indexed(201);
const REST: Color = Color::Indexed(226);
/// A pixel without depth.
const HOLE: Color = Color::Indexed(52);

/// Which image is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Layer {
    /// Left infrared.
    #[default]
    Infrared,
    /// Depth.
    Depth,
}

/// A picture to be drawn.
#[derive(Clone, Copy, Debug)]
pub struct GlassPicture<'p> {
    /// The image.
    pub portrait: &'p Portrait,
    /// Which of the two.
    pub layer: Layer,
    /// The traced body: its sides and its upper edge.
    pub body: Option<&'p Body>,
    /// Measured surface points, column and row.
    pub points: &'p [(f32, f32)],
    /// Where the said fill lies, column and row.
    pub rest: &'p [(f32, f32)],
}

/// Where image pixels go in the terminal.
#[derive(Clone, Copy)]
struct Place {
    left: f32,
    top: f32,
    /// Image pixels in one dot.
    step: f32,
    width: usize,
    rows: usize,
}

impl Place {
    /// Returns the index of the dot that shows the image pixel at column `u` and row `v`.
    fn dot(&self, u: f32, v: f32) -> Option<usize> {
        let (x, y) = (((u - self.left) / self.step).floor(), ((v - self.top) / self.step).floor());
        let inside = x >= 0.0 && y >= 0.0 && (x as usize) < self.width && (y as usize) < self.rows;
        inside.then(|| y as usize * self.width + x as usize)
    }
}

impl GlassPicture<'_> {
    fn place(&self, area: Rect) -> Place {
        let (width, rows) = (usize::from(area.width), 2 * usize::from(area.height));
        let image = (self.portrait.width as f32, self.portrait.height as f32);
        let step = (COLUMNS.min(image.0) / width as f32).max(0.45 * image.1 / rows as f32);
        let middle = self.body.map_or(0.5 * image.1, |body| {
            let (first, last) = body.rows();
            0.5 * (first + last) as f32
        });
        let left = 0.5 * (image.0 - step * width as f32);
        Place { left, top: middle - 0.5 * step * rows as f32, step, width, rows }
    }

    /// Colour of the image in the dot whose first pixel is `(u, v)`.
    fn colour(&self, u: f32, v: f32, step: f32) -> Color {
        if u < 0.0 || v < 0.0 || u >= self.portrait.width as f32 || v >= self.portrait.height as f32 {
            return Color::Reset;
        }
        let at = (v + 0.5 * step) as usize * self.portrait.width + (u + 0.5 * step) as usize;
        match self.layer {
            Layer::Infrared => {
                let grey = self.portrait.grey.get(at).copied().unwrap_or(0.0);
                Color::Indexed(BLACK + (grey / 255.0 * 23.0) as u8)
            }
            Layer::Depth => {
                let depth_m = self.portrait.depth_m.get(at).copied().unwrap_or(0.0);
                let near = ((FAR_M - depth_m) / (FAR_M - NEAR_M)).clamp(0.0, 0.999);
                let colour = DEPTHS.get((near * DEPTHS.len() as f32) as usize);
                colour.filter(|_| depth_m > 0.0).map_or(HOLE, |colour| Color::Indexed(*colour))
            }
        }
    }

    /// The dots of the picture, row by row.
    fn dots(&self, place: Place) -> Vec<Color> {
        let mut dots = Vec::with_capacity(place.width * place.rows);
        for y in 0..place.rows {
            for x in 0..place.width {
                let (u, v) = (place.left + x as f32 * place.step, place.top + y as f32 * place.step);
                dots.push(self.colour(u, v, place.step));
            }
        }
        let mut put = |at: (f32, f32), colour: Color| {
            if let Some(dot) = place.dot(at.0, at.1).and_then(|dot| dots.get_mut(dot)) {
                *dot = colour;
            }
        };
        // What was measured goes over what was said.
        self.rest.iter().for_each(|point| put(*point, REST));
        if let Some(body) = self.body {
            for (row, ends) in &body.sides {
                ends.iter().for_each(|column| put((*column, *row as f32), SIDE));
            }
            body.top.iter().for_each(|(column, row)| put((*column as f32, *row), EDGE));
        }
        self.points.iter().for_each(|point| put(*point, POINT));
        dots
    }
}

impl Widget for GlassPicture<'_> {
    fn render(self, area: Rect, buffer: &mut Buffer) {
        let place = self.place(area);
        if place.width == 0 || place.rows == 0 {
            return;
        }
        let dots = self.dots(place);
        let lines = dots.chunks_exact(2 * place.width);
        for (y, line) in (area.top()..area.bottom()).zip(lines) {
            let (upper, lower) = line.split_at(place.width);
            for (x, (upper, lower)) in (area.left()..area.right()).zip(upper.iter().zip(lower)) {
                if let Some(cell) = buffer.cell_mut((x, y)) {
                    cell.set_symbol("▀").set_fg(*upper).set_bg(*lower);
                }
            }
        }
    }
}
