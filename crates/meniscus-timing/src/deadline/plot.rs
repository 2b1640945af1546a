//! Latencies of all runs in one picture, out to the rarest.

use super::{Outcome, Tally};
use meniscus_report::plot::{BLUE, FONT, GREEN, ORANGE, PURPLE, PictureError, prepare_font};
use plotters::prelude::*;
use std::path::Path;

/// Width and height, pixels.
const SIZE: (u32, u32) = (1400, 800);

/// Nines on the axis: to 99.9999 %.
const NINES: f64 = 6.0;

/// Writes, for every run, the latency that all but a share of its turns stayed within; broken lines are deadlines.
///
/// # Errors
/// [`PictureError`].
pub fn latencies_png(outcomes: &[Outcome], path: &Path) -> Result<(), PictureError> {
    prepare_font();
    let area = BitMapBackend::new(path, SIZE).into_drawing_area();
    area.fill(&WHITE)?;
    let highest = outcomes.iter().map(|outcome| outcome.tally.within_us(1.0)).fold(20_000.0, f64::max);
    let mut chart = ChartBuilder::on(&area)
        .caption(title(outcomes), (FONT, 24))
        .margin(16)
        .margin_right(60)
        .x_label_area_size(50)
        .y_label_area_size(80)
        .build_cartesian_2d(0.0..NINES, (0.3..1.5e-3 * highest).log_scale())?;
    let share = |nines: &f64| format!("{} %", 100.0 - 100.0 * 10f64.powf(-nines.round()));
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .x_labels(NINES as usize + 1)
        .x_label_formatter(&share)
        .x_desc("share of the turns")
        .y_desc("latency within which they ended, ms")
        .y_label_formatter(&|ms| format!("{ms}"))
        .label_style((FONT, 18))
        .draw()?;
    let mut rates: Vec<f64> = outcomes.iter().map(|outcome| outcome.run.rate_hz).collect();
    rates.sort_by(f64::total_cmp);
    rates.dedup();
    for outcome in outcomes {
        let place = rates.iter().position(|rate| *rate == outcome.run.rate_hz).unwrap_or(0);
        let colour = [BLUE, ORANGE, GREEN, PURPLE][place % 4];
        let width = if outcome.run.loads.is_empty() { 2 } else { 5 };
        let line = colour.stroke_width(width);
        chart
            .draw_series(LineSeries::new(curve(&outcome.tally), line))?
            .label(label(outcome))
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 30, y)], line));
        let deadline_ms = 1e-3 * outcome.run.deadline_us() as f64;
        let dashes = (0..60).step_by(2).map(|k| 0.1 * f64::from(k));
        chart.draw_series(
            dashes.map(|x| {
                PathElement::new([(x, deadline_ms), (x + 0.1, deadline_ms)], colour.stroke_width(1))
            }),
        )?;
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperLeft)
        .label_font((FONT, 20))
        .background_style(WHITE.mix(0.85))
        .legend_area_size(40)
        .draw()?;
    area.present().map_err(|error| PictureError(error.to_string()))
}

/// The message: how many turns of the slowest rate ended before their deadline.
fn title(outcomes: &[Outcome]) -> String {
    let slowest = outcomes.iter().min_by(|a, b| a.run.rate_hz.total_cmp(&b.run.rate_hz));
    slowest.map_or(String::from("Latency from the frame's last byte to its estimate"), |outcome| {
        let (hz, tally) = (outcome.run.rate_hz, &outcome.tally);
        let deadline_ms = 1e-3 * outcome.run.deadline_us() as f64;
        let missed = tally.missed();
        let frames = tally.frames;
        format!("{}: {missed} of {frames} frames late or lost (broken: deadlines; {deadline_ms:.1} ms at {hz} Hz)", outcome.run.name())
    })
}

/// The name of a run, and the share of the processors' time that the host of a virtual machine took, which can make an idle run slower than a
/// loaded one.
fn label(outcome: &Outcome) -> String {
    let stolen = outcome.stolen.map_or(String::new(), |share| format!("; host took {:.1} %", 100.0 * share));
    format!("{}{stolen}", outcome.run.name())
}

/// Nines and milliseconds, as far as there are turns to tell.
fn curve(tally: &Tally) -> Vec<(f64, f64)> {
    let most = (tally.latency_us.len().max(1) as f64).log10().min(NINES);
    let steps = (40.0 * most) as usize;
    (0..=steps)
        .map(|step| step as f64 / 40.0)
        .map(|nines| (nines, 1e-3 * tally.within_us(1.0 - 10f64.powf(-nines)).max(1.0)))
        .collect()
}
