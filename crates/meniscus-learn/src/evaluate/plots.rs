//! The study as pictures: error over time before and after, and the crests.

use super::LiquidResult;
use meniscus_report::plot::{BLUE, FONT, GREY, ORANGE, PictureError, legend, prepare_font};
use plotters::coord::Shift;
use plotters::prelude::*;
use std::path::Path;

/// Width of a picture, and height of one liquid in it, pixels.
const SIZE: (u32, u32) = (1200, 260);

/// A row of a picture.
type Row<'a> = DrawingArea<BitMapBackend<'a>, Shift>;

/// Draws `rows` rows, `each` its own.
fn draw(
    path: &Path,
    rows: usize,
    each: impl Fn(usize, &Row<'_>) -> Result<(), PictureError>,
) -> Result<(), PictureError> {
    prepare_font();
    let rows = rows.max(1);
    let area = BitMapBackend::new(path, (SIZE.0, SIZE.1 * rows as u32)).into_drawing_area();
    area.fill(&WHITE)?;
    for (row, part) in area.split_evenly((rows, 1)).iter().enumerate() {
        each(row, part)?;
    }
    Ok(area.present()?)
}

/// Mean error of the height over time, before and after correction, a row a liquid.
///
/// # Errors
/// [`PictureError`], when the file cannot be written.
pub fn curves_png(results: &[LiquidResult], path: &Path) -> Result<(), PictureError> {
    draw(path, results.len(), |row, area| {
        let Some(result) = results.get(row) else { return Ok(()) };
        let curves = [&result.before.score.curves[0], &result.after.score.curves[0]];
        let end = curves[0].last().map_or(1.0, |point| point.0);
        let top = curves.iter().flat_map(|c| c.iter()).map(|p| p.1).fold(0.1, f64::max);
        let mut chart = ChartBuilder::on(area)
            .caption(result.course.name, (FONT, 20))
            .margin(8)
            .x_label_area_size(34)
            .y_label_area_size(54)
            .build_cartesian_2d(0.0..end, 0.0..1.05 * top)?;
        chart.configure_mesh().x_desc("time, s").y_desc("error, %").draw()?;
        for (curve, colour, name) in [(curves[0], GREY, "before"), (curves[1], BLUE, "after")] {
            chart
                .draw_series(LineSeries::new(curve.iter().copied(), colour.stroke_width(2)))?
                .label(name)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], colour.stroke_width(3)));
        }
        legend(&mut chart, SeriesLabelPosition::UpperLeft)?;
        Ok(())
    })
}

/// Estimated over true crest heights, before and after, a row a liquid.
///
/// # Errors
/// [`PictureError`], when the file cannot be written.
pub fn peaks_png(results: &[LiquidResult], path: &Path) -> Result<(), PictureError> {
    draw(path, results.len(), |row, area| {
        let Some(result) = results.get(row) else { return Ok(()) };
        let peaks = [&result.before.peaks, &result.after.peaks];
        let top = 1e3 * peaks.iter().flat_map(|p| p.iter()).map(|p| p.height_m).fold(0.005, f64::max);
        let end = result.before.score.curves[0].last().map_or(1.0, |point| point.0);
        let mut chart = ChartBuilder::on(area)
            .caption(result.course.name, (FONT, 20))
            .margin(8)
            .x_label_area_size(34)
            .y_label_area_size(54)
            .build_cartesian_2d(0.0..end, 0.0..1.2 * top)?;
        chart.configure_mesh().x_desc("time, s").y_desc("crest, mm").draw()?;
        let truth =
            peaks[0].iter().map(|p| Circle::new((p.time_s, 1e3 * p.height_m), 6, GREY.stroke_width(2)));
        chart.draw_series(truth)?.label("truth").legend(|(x, y)| Circle::new((x + 10, y), 5, GREY));
        for (peaks, colour, name) in [(peaks[0], ORANGE, "before"), (peaks[1], BLUE, "after")] {
            let place = |p: &super::Peak| (p.time_s + p.time_error_s, 1e3 * (p.height_m + p.height_error_m));
            chart
                .draw_series(peaks.iter().map(|p| Cross::new(place(p), 5, colour.stroke_width(2))))?
                .label(name)
                .legend(move |(x, y)| Cross::new((x + 10, y), 5, colour.stroke_width(2)));
        }
        legend(&mut chart, SeriesLabelPosition::UpperLeft)?;
        Ok(())
    })
}
