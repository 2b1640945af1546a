//! Slices through the liquid, and the scale of their colours.

use super::{Panel, Picture, Slice, SliceTracer};
use meniscus_report::plot::{FONT, GREY, PictureError};
use plotters::prelude::*;
use plotters::style::colors::colormaps::{ColorMap, ViridisRGB};
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Steps of the colour scale.
const STEPS: i32 = 64;

/// Numbers beside the colour scale.
const NUMBERS: i32 = 5;

impl Picture<'_> {
    pub(super) fn draw_slice(
        &self,
        panel: &Panel<'_>,
        name: &str,
        slice: &Slice,
        top: f64,
    ) -> Result<(), PictureError> {
        let known = slice.tracers.iter().all(|tracer| tracer.value.is_some());
        let name = if known { name.into() } else { format!("{name}: {} not known", self.value) };
        let letter = self.letter(15);
        SliceChart { caption: &name, glass_mm: self.glass_mm, letter, top }.draw(panel, slice)
    }

    /// Draws the scale of the colours from 0 to `top`.
    pub(super) fn draw_scale(&self, panel: &Panel<'_>, top: f64) -> Result<(), PictureError> {
        let letter = self.letter(15);
        let (across, down) = panel.dim_in_pixel();
        let (across, down, letter_px) = (across as i32, down as i32, letter as i32);
        // As high as the slices beside it.
        let (left, upper, lower) = (letter_px / 2, 3 * letter_px, down - 4 * letter_px);
        let place = |share: f64| lower - (share * f64::from(lower - upper)) as i32;
        for step in 0..STEPS {
            let share = |step: i32| f64::from(step) / f64::from(STEPS);
            let box_ = [(left, place(share(step + 1))), (left + letter_px, place(share(step)))];
            let colour = ViridisRGB.get_color((share(step) + 0.5 * share(1)) as f32);
            panel.draw(&Rectangle::new(box_, colour.filled()))?;
        }
        let words = TextStyle::from((FONT, letter).into_font()).pos(Pos::new(HPos::Left, VPos::Center));
        for number in 0..NUMBERS {
            let share = f64::from(number) / f64::from(NUMBERS - 1);
            let text = format!("{:.3}", share * top);
            panel.draw(&Text::new(text, (left + 3 * letter_px / 2, place(share)), words.clone()))?;
        }
        let title = words.pos(Pos::new(HPos::Center, VPos::Bottom));
        panel.draw(&Text::new(self.value.clone(), (across / 2, upper - letter_px), title))?;
        Ok(())
    }
}

/// Axes of a slice through the glass.
#[derive(Clone, Copy, Debug)]
pub struct SliceChart<'c> {
    /// Line above it.
    pub caption: &'c str,
    /// Half the width of the glass and its height, millimetres.
    pub glass_mm: (f64, f64),
    /// Height of the letters of the axes, pixels.
    pub letter: u32,
    /// Value of the bright end of the colours.
    pub top: f64,
}

impl SliceChart<'_> {
    /// Draws the tracers of `slice` in their colours into the glass.
    ///
    /// # Errors
    /// [`PictureError`].
    pub fn draw(&self, panel: &Panel<'_>, slice: &Slice) -> Result<(), PictureError> {
        let (letter, top, (half, height)) = (self.letter, self.top, self.glass_mm);
        let mut chart = ChartBuilder::on(panel)
            .caption(self.caption, (FONT, 6 * letter / 5))
            .margin(8)
            .x_label_area_size(3 * letter)
            .y_label_area_size(7 * letter / 2)
            .build_cartesian_2d(-1.1 * half..1.1 * half, 0.0..height)?;
        chart
            .configure_mesh()
            .disable_mesh()
            .x_labels(4)
            .y_labels(6)
            .x_label_formatter(&|x| format!("{x:.0}"))
            .y_label_formatter(&|z| format!("{z:.0}"))
            .label_style((FONT, letter))
            .x_desc("x, mm")
            .y_desc("z, mm")
            .draw()?;
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
}
