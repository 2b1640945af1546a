//! The study as pictures: error over time before and after, and the errors of the crests.
//!
//! All liquids of a picture share the axes, so that their panels can be compared.

use super::{LiquidResult, Peak, percent};
use meniscus_numerics::statistics::median;
use meniscus_report::plot::{BLUE, FONT, GREY, ORANGE, PictureError, legend, prepare_font};
use plotters::coord::Shift;
use plotters::prelude::*;
use std::path::Path;

/// Width of a picture, height of its title and of one liquid in it, pixels.
const SIZE: (u32, u32, u32) = (1200, 44, 240);

/// Range of the error over time, per cent; the upper end is higher where an error is.
const ERROR: (f64, f64) = (0.01, 5.0);

/// A row of a picture.
type Row<'a> = DrawingArea<BitMapBackend<'a>, Shift>;

/// Draws a title and a row for each of `results`.
fn draw(
    path: &Path,
    title: &str,
    results: &[&LiquidResult],
    each: impl Fn(&LiquidResult, &Row<'_>) -> Result<(), PictureError>,
) -> Result<(), PictureError> {
    prepare_font();
    let (width, band, height) = SIZE;
    let rows = results.len().max(1);
    let area = BitMapBackend::new(path, (width, band + height * rows as u32)).into_drawing_area();
    area.fill(&WHITE)?;
    let (top, rest) = area.split_vertically(band);
    top.margin(12, 0, 0, 0).titled(title, (FONT, 24))?;
    for (result, part) in results.iter().zip(rest.split_evenly((rows, 1))) {
        each(result, &part)?;
    }
    Ok(area.present()?)
}

/// Mean error of the height over time, before and after correction, a row a liquid, on common axes.
///
/// # Errors
/// [`PictureError`], when the file cannot be written.
pub fn curves_png(results: &[LiquidResult], path: &Path) -> Result<(), PictureError> {
    let all: Vec<_> = results.iter().collect();
    let pairs = results.iter().flat_map(|result| {
        let curves = [&result.before, &result.after].map(|trial| &trial.score.curves[0]);
        curves[0].iter().zip(curves[1])
    });
    let lower: Vec<f64> = pairs.map(|(before, after)| f64::from(u8::from(after.1 < before.1))).collect();
    let share = 100.0 * lower.iter().sum::<f64>() / lower.len().max(1) as f64;
    let both = results.iter().flat_map(|result| [&result.before, &result.after]);
    let most = both.flat_map(|trial| &trial.score.curves[0]).map(|(_, error)| *error).fold(ERROR.1, f64::max);
    let title = format!(
        "Mean error of the height over the profile: correction lowers it in {share:.0} % of the frames"
    );
    draw(path, &title, &all, |result, area| {
        let curves = [&result.before.score.curves[0], &result.after.score.curves[0]];
        let means = [&result.before, &result.after].map(|trial| percent(trial.score.estimate.mean()));
        let caption =
            format!("{}: {:.2} % before, {:.2} % after, in the mean", result.course.name, means[0], means[1]);
        let end = curves[0].last().map_or(1.0, |point| point.0);
        let mut chart = ChartBuilder::on(area)
            .caption(caption, (FONT, 18))
            .margin(8)
            .x_label_area_size(34)
            .y_label_area_size(60)
            .build_cartesian_2d(0.0..end, (ERROR.0..most).log_scale())?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .x_desc("time, s")
            .y_desc("error of the height, %")
            .y_label_formatter(&|error| format!("{error}"))
            .draw()?;
        for (curve, colour, name) in [(curves[0], ORANGE, "before"), (curves[1], BLUE, "after")] {
            let points = curve.iter().map(|(time, error)| (*time, error.max(ERROR.0)));
            chart
                .draw_series(LineSeries::new(points, colour.stroke_width(2)))?
                .label(name)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], colour.stroke_width(3)));
        }
        legend(&mut chart, SeriesLabelPosition::UpperRight)?;
        Ok(())
    })
}

/// Error of each crest over its true height, before and after, a row for each liquid with crests, on common axes.
///
/// # Errors
/// [`PictureError`], when the file cannot be written.
pub fn peaks_png(results: &[LiquidResult], path: &Path) -> Result<(), PictureError> {
    let crested: Vec<_> = results.iter().filter(|result| !result.before.peaks.is_empty()).collect();
    let both = |result: &LiquidResult| [result.before.peaks.clone(), result.after.peaks.clone()].concat();
    let all: Vec<Peak> = crested.iter().flat_map(|result| both(result)).collect();
    let highest = 1e3 * all.iter().map(|peak| peak.height_m).fold(0.005, f64::max);
    let too_low = all.iter().filter(|peak| peak.height_error_m < 0.0).count();
    let title =
        format!("Error of each crest over its height: {too_low} of {} estimates are too low", all.len());
    let worst = 1e3 * all.iter().map(|peak| peak.height_error_m.abs()).fold(0.0005, f64::max);
    draw(path, &title, &crested, |result, area| {
        let errors = [&result.before, &result.after].map(|trial| {
            1e3 * median(trial.peaks.iter().map(|peak| peak.height_error_m)).unwrap_or(f64::NAN)
        });
        let caption = format!(
            "{}: {} crests, median error {:+.2} mm before, {:+.2} mm after",
            result.course.name,
            result.before.peaks.len(),
            errors[0],
            errors[1]
        );
        let mut chart = ChartBuilder::on(area)
            .caption(caption, (FONT, 18))
            .margin(8)
            .x_label_area_size(34)
            .y_label_area_size(60)
            .build_cartesian_2d(0.0..1.05 * highest, -1.1 * worst..1.1 * worst)?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .x_desc("true height of the crest above the fill, mm")
            .y_desc("estimate less truth, mm")
            .draw()?;
        chart.draw_series(LineSeries::new([(0.0, 0.0), (1.05 * highest, 0.0)], GREY.stroke_width(2)))?;
        for (trial, colour, name) in [(&result.before, ORANGE, "before"), (&result.after, BLUE, "after")] {
            let place = |peak: &Peak| (1e3 * peak.height_m, 1e3 * peak.height_error_m);
            chart
                .draw_series(trial.peaks.iter().map(|p| Cross::new(place(p), 5, colour.stroke_width(2))))?
                .label(name)
                .legend(move |(x, y)| Cross::new((x + 10, y), 5, colour.stroke_width(2)));
        }
        legend(&mut chart, SeriesLabelPosition::LowerLeft)?;
        Ok(())
    })
}
