//! A picture of each decay: what the simulator did, what was fitted to it, what theory says.

use super::fit::fit;
use super::{Fit, Ringing};
use meniscus_report::plot::{BLUE, FONT, GREY, ORANGE, PictureError, prepare_font};
use plotters::prelude::*;
use std::path::Path;

/// Width and height, pixels.
const SIZE: (u32, u32) = (1200, 600);

/// Returns the oscillation that theory predicts for `ringing`: theory fixes frequency and decay; amplitude and phase are those that suit the series best.
pub(super) fn expected(ringing: &Ringing) -> Fit {
    let near = fit(&ringing.series, ringing.theory, &[]);
    Fit { tone: ringing.theory, amplitude: near.map_or(ringing.fit.amplitude, |near| near.amplitude) }
}

/// Writes the picture of `ringing` as a PNG file.
///
/// # Errors
/// [`PictureError`], when the file cannot be written.
pub fn decay_png(ringing: &Ringing, path: &Path) -> Result<(), PictureError> {
    prepare_font();
    let area = BitMapBackend::new(path, SIZE).into_drawing_area();
    area.fill(&WHITE)?;
    let end = ringing.series.last().map_or(0.1, |point| point.0);
    let mut chart = ChartBuilder::on(&area)
        .caption(format!("first mode, {}", ringing.name), (FONT, 26))
        .margin(12)
        .x_label_area_size(44)
        .y_label_area_size(64)
        .build_cartesian_2d(0.0..end, -1.05..1.05)?;
    chart.configure_mesh().x_desc("time, s").y_desc("modal momentum, 1 at the start").draw()?;
    let theory = ringing.theory;
    let (fitted, sought) = (&ringing.fit, ringing.fit.tone);
    let expected = expected(ringing);
    let named = |what: &str, hz: f64, decay: f64| format!("{what}: {hz:.3} Hz, {decay:.2} /s");
    let at =
        |curve: &dyn Fn(f64) -> f64| ringing.series.iter().map(|(t, _)| (*t, curve(*t))).collect::<Vec<_>>();
    let curves = [
        (String::from("simulator"), ringing.series.clone(), GREY, 5),
        (named("fit", sought.hz, sought.decay), at(&|t| fitted.at(t)), BLUE, 2),
        (named("theory", theory.hz, theory.decay), at(&|t| expected.at(t)), ORANGE, 2),
    ];
    for (name, points, colour, width) in curves {
        chart
            .draw_series(LineSeries::new(points, colour.stroke_width(width)))?
            .label(name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 24, y)], colour.stroke_width(3)));
    }
    chart
        .configure_series_labels()
        .label_font((FONT, 16))
        .background_style(WHITE.mix(0.8))
        .border_style(GREY)
        .draw()?;
    area.present()?;
    Ok(())
}
