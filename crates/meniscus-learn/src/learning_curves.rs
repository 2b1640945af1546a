//! Learning curves as a picture: a row a stage, training and validation error over its steps.

use meniscus_optim::progress::Curve;
use meniscus_report::plot::{BLUE, FONT, ORANGE, PictureError, legend, prepare_font};
use plotters::prelude::*;
use std::path::Path;

/// Width of the picture, and height of a row, pixels.
const SIZE: (u32, u32) = (1000, 260);

/// Draws `curves` to a PNG at `path`. Errors are relative; training errors are those of the
/// loss, with noise in what is seen, so that they may lie above validation.
///
/// # Errors
/// [`PictureError`], when the file cannot be written.
pub fn curves_png(curves: &[Curve], path: &Path) -> Result<(), PictureError> {
    prepare_font();
    let rows = curves.len().max(1);
    let area = BitMapBackend::new(path, (SIZE.0, SIZE.1 * rows as u32)).into_drawing_area();
    area.fill(&WHITE)?;
    for (curve, part) in curves.iter().zip(area.split_evenly((rows, 1))) {
        let percent = |of: fn(&meniscus_optim::progress::LookAt) -> f64| {
            let points = curve.looks.iter().map(move |look| (f64::from(look.0), 100.0 * of(look)));
            points.filter(|point| point.1.is_finite() && point.1 > 0.0).collect::<Vec<_>>()
        };
        let lines =
            [(percent(|look| look.1), ORANGE, "training"), (percent(|look| look.2), BLUE, "validation")];
        let errors = || lines.iter().flat_map(|line| &line.0).map(|point| point.1);
        let most = errors().fold(0.0, f64::max);
        let end = curve.looks.last().map_or(1.0, |look| f64::from(look.0));
        let mut chart = ChartBuilder::on(&part)
            .caption(&curve.stage, (FONT, 20))
            .margin(8)
            .margin_right(28)
            .x_label_area_size(34)
            .y_label_area_size(60)
            .build_cartesian_2d(0.0..end, 0.0..(1.05 * most).max(1.0))?;
        chart.configure_mesh().x_desc("steps").y_desc("error, %").draw()?;
        for (points, colour, name) in lines {
            chart
                .draw_series(LineSeries::new(points, colour.stroke_width(2)))?
                .label(name)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], colour.stroke_width(3)));
        }
        legend(&mut chart, SeriesLabelPosition::UpperRight)?;
    }
    Ok(area.present()?)
}
