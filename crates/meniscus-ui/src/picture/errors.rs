//! Errors over time.

use super::{Panel, Picture};
use meniscus_report::plot::{BLUE, FONT, GREEN, GREY, ORANGE, PURPLE, PictureError};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Length of a line in the legend, in letters.
const SWATCH: i32 = 2;

impl Picture<'_> {
    pub(super) fn draw_errors(&self, panel: &Panel<'_>) -> Result<(), PictureError> {
        let all = || self.errors.iter().flat_map(|curve| &curve.points);
        let end = all().map(|point| point.0).fold(0.1, f64::max);
        let most = 1.05 * all().map(|point| point.1).fold(0.1, f64::max);
        let letter = self.letter(15);
        let title = "error of the surface, |z - estimate| / z, mean over the profile";
        let panel = panel.titled(title, (FONT, self.letter(18)))?;
        let colours = [BLUE, GREY, PURPLE, ORANGE];
        let curves = || self.errors.iter().zip(colours);
        let (legend, panel) = panel.split_vertically(3 * letter / 2);
        let mut names: Vec<_> = curves().map(|(curve, colour)| (curve.name.as_str(), colour)).collect();
        if self.now_s.is_some() {
            names.push(("the moment above", GREEN));
        }
        self.draw_legend(&legend, &names)?;
        let mut chart = ChartBuilder::on(&panel)
            .margin(10)
            .margin_right(30)
            .x_label_area_size(3 * letter)
            .y_label_area_size(4 * letter)
            .build_cartesian_2d(0.0..end, 0.0..most)?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(GREY.mix(0.25))
            .x_labels(10)
            .y_labels(5)
            .x_label_formatter(&|t| format!("{t:.1}"))
            .y_label_formatter(&|error| format!("{error:.2}"))
            .label_style((FONT, letter))
            .x_desc("time, s")
            .y_desc("error, %")
            .draw()?;
        for (curve, colour) in curves() {
            chart.draw_series(LineSeries::new(curve.points.iter().copied(), colour.stroke_width(2)))?;
        }
        if let Some(now) = self.now_s {
            chart.draw_series([PathElement::new([(now, 0.0), (now, most)], GREEN.stroke_width(2))])?;
        }
        Ok(())
    }

    /// Draws the names beside lines of their colours in a row above the chart, where they cover no curve.
    fn draw_legend(&self, panel: &Panel<'_>, names: &[(&str, RGBColor)]) -> Result<(), PictureError> {
        let letter = self.letter(15);
        let words = TextStyle::from((FONT, letter).into_font()).pos(Pos::new(HPos::Left, VPos::Center));
        let (letter, middle) = (letter as i32, panel.dim_in_pixel().1 as i32 / 2);
        let mut x = 4 * letter;
        for (name, colour) in names {
            let line = [(x, middle), (x + SWATCH * letter, middle)];
            panel.draw(&PathElement::new(line, colour.stroke_width(3)))?;
            x += SWATCH * letter + letter / 2;
            panel.draw(&Text::new(*name, (x, middle), words.clone()))?;
            x += panel.estimate_text_size(name, &words)?.0 as i32 + 2 * letter;
        }
        Ok(())
    }
}
