//! Pictures: one move planned and by minimum jerk, and all moves of a study.

use super::carry::Trace;
use super::draw::StudyLiquid;
use super::judge::Outcome;
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_report::plot::{BLUE, FONT, GREY, ORANGE, PictureError, VERMILION, legend, prepare_font};
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use std::path::Path;

/// Width and height, pixels.
const SIZE: (u32, u32) = (1100, 760);
const STUDY_SIZE: (u32, u32) = (1100, 490);

/// A curve of a picture over the frames: name, values, colour.
type Curve<'a> = (&'a str, Vec<f64>, RGBColor);

/// Draws one move: the glass above, the highest point of the surface below, with the limit.
///
/// # Errors
/// [`PictureError`], when the file cannot be written.
pub fn move_png(
    title: &str,
    limit_m: f64,
    traces: &[(&str, &Trace)],
    path: &Path,
) -> Result<(), PictureError> {
    prepare_font();
    let area = BitMapBackend::new(path, SIZE).into_drawing_area();
    area.fill(&WHITE)?;
    let (upper, lower) = area.margin(10, 0, 0, 0).titled(title, (FONT, 20))?.split_vertically(320);
    let colours = [BLUE, ORANGE, GREY];
    let of = |values: &dyn Fn(&Trace) -> Vec<f64>| -> Vec<Curve<'_>> {
        traces.iter().zip(colours).map(|((name, one), colour)| (*name, values(one), colour)).collect()
    };
    curves(&upper, "", "position of the glass, mm", &of(&|one| scaled(&one.position_m)), None)?;
    let limit_mm = Some(1e3 * limit_m);
    curves(&lower, "time, s", "highest point over rest, mm", &of(&|one| scaled(&one.highest_m)), limit_mm)?;
    area.present()?;
    Ok(())
}

/// Metres in millimetres.
fn scaled(values_m: &[f64]) -> Vec<f64> {
    values_m.iter().map(|value| 1e3 * value).collect()
}

/// Draws curves over time, with a dashed limit.
fn curves(
    area: &DrawingArea<BitMapBackend<'_>, plotters::coord::Shift>,
    x: &str,
    y: &str,
    curves: &[Curve<'_>],
    limit: Option<f64>,
) -> Result<(), PictureError> {
    let longest = curves.iter().map(|(_, values, _)| values.len()).max().unwrap_or(1);
    let end_s = longest as f64 * FRAME_INTERVAL_S;
    let values = || curves.iter().flat_map(|(_, values, _)| values.iter().copied()).chain(limit);
    let (least, most) = (values().fold(0.0, f64::min), values().fold(0.0, f64::max));
    let mut chart = ChartBuilder::on(area)
        .margin(10)
        .x_label_area_size(40)
        .y_label_area_size(64)
        .build_cartesian_2d(0.0..end_s, least..1.3 * most)?;
    chart.configure_mesh().x_desc(x).y_desc(y).light_line_style(WHITE).draw()?;
    for (name, values, colour) in curves {
        let colour = *colour;
        let points = values.iter().enumerate().map(|(n, value)| (n as f64 * FRAME_INTERVAL_S, *value));
        chart
            .draw_series(LineSeries::new(points, colour.stroke_width(3)))?
            .label(*name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 24, y)], colour.stroke_width(3)));
    }
    if let Some(limit) = limit {
        chart
            .draw_series(DashedLineSeries::new(
                [(0.0, limit), (end_s, limit)],
                8,
                6,
                VERMILION.stroke_width(2),
            ))?
            .label("limit")
            .legend(|(x, y)| DashedPathElement::new([(x, y), (x + 24, y)], 8, 6, VERMILION.stroke_width(2)));
    }
    legend(&mut chart, SeriesLabelPosition::UpperRight)?;
    Ok(())
}

/// Draws all moves: crest over limit, and crest over that of minimum jerk in the same time, over the duration.
///
/// # Errors
/// [`PictureError`], when there is no move or the file cannot be written.
pub fn study_png(outcomes: &[Outcome], path: &Path) -> Result<(), PictureError> {
    if outcomes.is_empty() {
        return Err(PictureError("no move was carried out".into()));
    }
    prepare_font();
    let area = BitMapBackend::new(path, STUDY_SIZE).into_drawing_area();
    area.fill(&WHITE)?;
    let title = "Planned moves in the simulator: crests beside the limit, and beside minimum jerk";
    let (left, right) =
        area.margin(10, 0, 0, 0).titled(title, (FONT, 20))?.split_horizontally(STUDY_SIZE.0 / 2);
    let limit = |one: &Outcome| one.crest_m / one.of.request.limit_m;
    dots(&left, "crest over the limit", outcomes, limit, ("limit", 1.0))?;
    let rival = |one: &Outcome| one.crest_m / one.minimum_jerk_m;
    dots(&right, "crest over minimum jerk in the same time", outcomes, rival, ("target", 0.5))?;
    area.present()?;
    Ok(())
}

/// A dot for each move over its duration, and the line `mark`, by name and height.
fn dots(
    area: &DrawingArea<BitMapBackend<'_>, plotters::coord::Shift>,
    y: &str,
    outcomes: &[Outcome],
    of: impl Fn(&Outcome) -> f64,
    mark: (&str, f64),
) -> Result<(), PictureError> {
    let longest = outcomes.iter().map(|one| one.arrival_s).fold(0.0, f64::max);
    let most = outcomes.iter().map(&of).fold(1.0, f64::max);
    let mut chart = ChartBuilder::on(area)
        .margin(12)
        .x_label_area_size(44)
        .y_label_area_size(60)
        .build_cartesian_2d(0.0..1.1 * longest, 0.0..1.25 * most)?;
    chart.configure_mesh().x_desc("travel time, s").y_desc(y).light_line_style(WHITE).draw()?;
    for (liquid, colour) in StudyLiquid::ALL.into_iter().zip([BLUE, ORANGE]) {
        let points =
            outcomes.iter().filter(|one| one.of.liquid == liquid).map(|one| (one.arrival_s, of(one)));
        chart
            .draw_series(points.map(|point| Circle::new(point, 5, colour.filled())))?
            .label(liquid.name())
            .legend(move |(x, y)| Circle::new((x + 12, y), 5, colour.filled()));
    }
    let (name, height) = mark;
    let line = [(0.0, height), (1.1 * longest, height)];
    chart
        .draw_series(DashedLineSeries::new(line, 8, 6, VERMILION.stroke_width(2)))?
        .label(name)
        .legend(|(x, y)| DashedPathElement::new([(x, y), (x + 24, y)], 8, 6, VERMILION.stroke_width(2)));
    legend(&mut chart, SeriesLabelPosition::UpperLeft)?;
    Ok(())
}
