//! A plot as SVG.

use crate::plot::{BLUE, FONT, GREEN, GREY, ORANGE, PURPLE, PictureError, prepare_font};
use plotters::prelude::*;

/// Width and height, pixels.
const SIZE: (u32, u32) = (900, 320);
/// Colours by number; the first is for what is only there to compare with.
const COLOURS: [RGBColor; 5] = [GREY, BLUE, ORANGE, GREEN, PURPLE];

/// Mark of a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// A line through them, in their order.
    Line,
    /// A dot each.
    Dots,
}

/// Points that belong together.
#[derive(Clone, Copy, Debug)]
pub struct Series<'s> {
    /// Its name in the legend.
    pub name: &'s str,
    /// Points; those that are not finite are left out.
    pub points: &'s [(f64, f64)],
    /// Their mark.
    pub mark: Mark,
    /// Grey, blue, orange, green, purple, and so on again.
    pub colour: usize,
}

/// A plot.
#[derive(Clone, Copy, Debug)]
pub struct Chart<'s> {
    /// Caption below it.
    pub caption: &'s str,
    /// Label of the abscissa, with its unit.
    pub x: &'s str,
    /// Label of the ordinate, with its unit.
    pub y: &'s str,
    /// Series, the last on top.
    pub series: &'s [Series<'s>],
}

impl Chart<'_> {
    /// On the right, where the last points are not.
    fn legend(&self, y: (f64, f64)) -> SeriesLabelPosition {
        let ends = self.series.iter().filter_map(|series| series.points.last());
        let upper = ends.clone().filter(|point| point.1 > 0.5 * (y.0 + y.1)).count();
        if 2 * upper > ends.count() {
            SeriesLabelPosition::LowerRight
        } else {
            SeriesLabelPosition::UpperRight
        }
    }

    /// The plot as an `svg` element.
    ///
    /// # Errors
    /// [`PictureError`], when there is no finite point.
    pub fn svg(&self) -> Result<String, PictureError> {
        prepare_font();
        let finite = |(x, y): &(f64, f64)| x.is_finite() && y.is_finite();
        let all = || self.series.iter().flat_map(|series| series.points).filter(|point| finite(point));
        let empty = || PictureError(format!("'{}' has no finite point", self.caption));
        let x = range(all().map(|point| point.0)).ok_or_else(empty)?;
        let y = range(all().map(|point| point.1)).ok_or_else(empty)?;
        let mut svg = String::new();
        {
            let area = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
            area.fill(&WHITE)?;
            let mut chart = ChartBuilder::on(&area)
                .margin(8)
                .x_label_area_size(36)
                .y_label_area_size(84)
                .build_cartesian_2d(x.0..x.1, y.0..y.1)?;
            chart.configure_mesh().x_desc(self.x).y_desc(self.y).light_line_style(WHITE).draw()?;
            for series in self.series {
                let colour = COLOURS[series.colour % COLOURS.len()];
                let points = series.points.iter().copied().filter(finite);
                let drawn = match series.mark {
                    Mark::Line => chart.draw_series(LineSeries::new(points, colour.stroke_width(2)))?,
                    Mark::Dots => chart
                        .draw_series(points.map(|point| Circle::new(point, 3, colour.mix(0.7).filled())))?,
                };
                drawn
                    .label(series.name)
                    .legend(move |(x, y)| Rectangle::new([(x, y - 3), (x + 16, y + 3)], colour.filled()));
            }
            chart
                .configure_series_labels()
                .label_font((FONT, 14))
                .position(self.legend(y))
                .background_style(WHITE.mix(0.85))
                .border_style(GREY)
                .draw()?;
            area.present()?;
        }
        // The declaration of a document has no place inside of a page.
        Ok(svg.split_once("<svg").map_or(String::new(), |(_, rest)| format!("<svg{rest}")))
    }
}

/// Least and greatest value with a little room; none of nothing.
fn range(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let ends = values.fold(None, |ends: Option<(f64, f64)>, value| {
        Some(ends.map_or((value, value), |(low, high)| (low.min(value), high.max(value))))
    })?;
    let room = if ends.1 > ends.0 { 0.04 * (ends.1 - ends.0) } else { 0.5 * ends.0.abs().max(1.0) };
    // Quantities that are never below zero begin there.
    let low = if ends.0 >= 0.0 && ends.0 < 0.3 * ends.1 { 0.0 } else { ends.0 - room };
    Some((low, ends.1 + room))
}
