//! A picture of each decay: the simulator beside theory, and what is left between them.

use super::fit::fit;
use super::{Fit, Ringing, Tone};
use meniscus_report::plot::{BLUE, FONT, GREY, ORANGE, PictureError, legend, prepare_font};
use plotters::prelude::*;
use std::path::Path;

/// Width and height, pixels.
const SIZE: (u32, u32) = (1200, 720);

/// Time after which the difference from theory sets the scale, s: the wall layer has formed.
const FORMED_S: f64 = 0.05;

/// Returns the oscillation that theory predicts for `ringing`: theory fixes frequency and decay; amplitude and phase are those that suit the series best.
pub(super) fn expected(ringing: &Ringing) -> Fit {
    let near = fit(&ringing.series, ringing.theory, &[]);
    Fit { tone: ringing.theory, amplitude: near.map_or(ringing.fit.amplitude, |near| near.amplitude) }
}

/// Writes the picture of `ringing` as a PNG file: simulator and theory, and below what is left between them.
///
/// # Errors
/// [`PictureError`], when the file cannot be written.
pub fn decay_png(ringing: &Ringing, path: &Path) -> Result<(), PictureError> {
    prepare_font();
    let area = BitMapBackend::new(path, SIZE).into_drawing_area();
    area.fill(&WHITE)?;
    let end = ringing.series.last().map_or(0.1, |point| point.0);
    let (theory, found, expected) = (ringing.theory, ringing.fit.tone, expected(ringing));
    let left: Vec<_> =
        ringing.series.iter().map(|(t, value)| (*t, 100.0 * (value - expected.at(*t)))).collect();
    let formed = left.iter().filter(|(t, _)| *t >= FORMED_S).map(|(_, value)| value.abs());
    let reach = 1.2 * formed.fold(0.5, f64::max);
    // Above the curves there is room for their names.
    let (above, below) = area.split_vertically(SIZE.1 * 3 / 5);
    let mut chart = ChartBuilder::on(&above)
        .caption(
            format!("first mode, {}: within {:.1} % of the start after 50 ms", ringing.name, reach / 1.2),
            (FONT, 24),
        )
        .margin(12)
        .x_label_area_size(36)
        .y_label_area_size(70)
        .build_cartesian_2d(0.0..end, -1.05..1.6)?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .x_desc("time, s")
        .y_desc("modal momentum, 1 at the start")
        .draw()?;
    let named = |what: &str, tone: Tone| format!("{what}: {:.3} Hz, {:.3} /s", tone.hz, tone.decay);
    let drawn = ringing.series.iter().map(|(t, _)| (*t, expected.at(*t))).collect::<Vec<_>>();
    let curves =
        [(named("simulator", found), &ringing.series, GREY, 5), (named("theory", theory), &drawn, ORANGE, 2)];
    for (name, points, colour, width) in curves {
        chart
            .draw_series(LineSeries::new(points.iter().copied(), colour.stroke_width(width)))?
            .label(name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 24, y)], colour.stroke_width(3)));
    }
    legend(&mut chart, SeriesLabelPosition::UpperRight)?;
    let mut rest = ChartBuilder::on(&below)
        .margin(12)
        .x_label_area_size(36)
        .y_label_area_size(70)
        .build_cartesian_2d(0.0..end, -reach..reach)?;
    rest.configure_mesh()
        .light_line_style(TRANSPARENT)
        .x_desc("time, s")
        .y_desc("simulator less theory, %")
        .draw()?;
    let clipped = left.iter().map(|(t, value)| (*t, value.clamp(-reach, reach)));
    rest.draw_series(LineSeries::new(clipped, BLUE.stroke_width(2)))?;
    area.present()?;
    Ok(())
}
