//! The study as one HTML file.

use super::{LiquidResult, Study};
use meniscus_report::checks::Check;
use meniscus_report::plot::PictureError;
use meniscus_report::{Chart, Mark, Report, Series};

/// The report: table of the liquids, error over time of each, checks.
///
/// # Errors
/// [`PictureError`], when a liquid has no curve to draw.
pub fn html(study: &Study, checks: &[Check], command: &str) -> Result<String, PictureError> {
    let mut report = Report::new("Correction from the free surface", command);
    report.prose(
        "Errors on recordings that nothing was chosen by, depth noise 2 mm, before and after correction. max and mean: \
         of the height; slosh: of its distance from rest, where a flat surface scores 100 %; forecast: the slosh 0.25 s \
         ahead, the motion of the glass planned. Water, butter and blood are moved along a line and learnt from four \
         recordings; the others are moved as by a hand, with a tenth of the travel across the line, and learnt \
         from one.",
    );
    let percent = |x: f64| format!("{:.2}", 100.0 * x);
    let row = |one: &LiquidResult| -> Vec<String> {
        let [before, after] = [&one.before, &one.after].map(|trial| &trial.score.estimate);
        let forecast = [&one.before, &one.after].map(|trial| trial.planned.forecast[0]);
        let pairs = [
            [before.max, after.max],
            [before.mean(), after.mean()],
            [before.slosh_rel(), after.slosh_rel()],
            forecast,
        ];
        let name = String::from(one.course.name);
        std::iter::once(name).chain(pairs.into_iter().flatten().map(percent)).collect()
    };
    report.table(
        &[
            "liquid",
            "max before, %",
            "after",
            "mean before, %",
            "after",
            "slosh before, %",
            "after",
            "forecast before, %",
            "after",
        ],
        &study.results.iter().map(row).collect::<Vec<_>>(),
    );
    for one in &study.results {
        let [before, after] = [&one.before, &one.after].map(|trial| trial.score.curves[0].as_slice());
        report.heading(one.course.name);
        report.chart(&Chart {
            caption: "Mean error of the height over the profile.",
            x: "time, s",
            y: "error, %",
            series: &[
                Series { name: "before", points: before, mark: Mark::Line, colour: 0 },
                Series { name: "after", points: after, mark: Mark::Line, colour: 1 },
            ],
        })?;
    }
    report.heading("Checks");
    report.checks(checks);
    Ok(report.html())
}
