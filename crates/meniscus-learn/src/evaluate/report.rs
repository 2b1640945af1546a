//! The study as a report: table of the liquids, error over time, crests, checks.

use super::{LiquidResult, Peak, Study, Trial, percent};
use meniscus_numerics::statistics::median;
use meniscus_report::checks::Check;
use meniscus_report::plot::PictureError;
use meniscus_report::{Chart, Mark, Report, Series};

/// Columns of the table of liquids.
const COLUMNS: [&str; 14] = [
    "liquid",
    "max before, %",
    "after",
    "mean before, %",
    "after",
    "slosh before, %",
    "after",
    "forecast before, %",
    "after",
    "one frame ago, %",
    "crest height before, mm",
    "after",
    "crest time before, ms",
    "after",
];

/// Returns the report of `study`; `curves.png` and `peaks.png` lie beside it (see [`super::curves_png`]).
///
/// # Errors
/// [`PictureError`], when a liquid has no curve to draw.
pub fn report(study: &Study, checks: &[Check], command: &str) -> Result<Report, PictureError> {
    let mut report = Report::new("Correction from the free surface", command);
    report.prose(
        "All recordings are held-out, with 2 mm of depth noise. \"Before\" is the model without correction. Max and mean are \
         errors relative to the height, |z - estimate| / z. Slosh is the slosh-relative error, |z - estimate| / |z - rest|; a \
         flat surface has 100 %. Forecast is the slosh-relative error 0.25 s ahead with the motion of the glass planned: it \
         shows how well the model knows the liquid, where the estimate follows the heights of any. One frame ago is the \
         error of the last frame in the place of the estimate. Crests have the median absolute error of height and time.",
    );
    report.prose(
        "Water, butter and blood are moved along a line and learnt from four recordings. The others are moved as by a hand, \
         with a tenth of the travel across the line, and learnt from one.",
    );
    report.table(&COLUMNS, &study.results.iter().map(row).collect::<Vec<_>>());
    report.heading("Error over time");
    report.picture(
        "curves.png",
        "mean error of the height over time, before and after correction, a row for each liquid",
    );
    for result in &study.results {
        add_curves(&mut report, result)?;
    }
    report.heading("Crests");
    report.prose("Liquids without a crest are not drawn.");
    report.picture(
        "peaks.png",
        "error of each crest over its height, before and after correction, a row for each liquid",
    );
    report.heading("Checks");
    report.checks(checks);
    Ok(report)
}

/// Cells of one liquid, in the order of [`COLUMNS`].
fn row(result: &LiquidResult) -> Vec<String> {
    let trials = [&result.before, &result.after];
    let [before, after] = trials.map(|trial| &trial.score.estimate);
    let [planned_before, planned_after] = trials.map(|trial| trial.planned.forecast[0]);
    let errors = [
        before.max,
        after.max,
        before.mean(),
        after.mean(),
        before.slosh_rel(),
        after.slosh_rel(),
        planned_before,
        planned_after,
        result.before.score.persistence.slosh_rel(),
    ];
    let heights = trials.map(|trial| crest_error(trial, |peak| peak.height_error_m, 2));
    let times = trials.map(|trial| crest_error(trial, |peak| peak.time_error_s, 0));
    let errors = errors.map(|error| format!("{:.2}", percent(error)));
    std::iter::once(result.course.name.into()).chain(errors).chain(heights).chain(times).collect()
}

/// Median absolute error of the crests in thousandths of its unit, or "none" without a crest.
fn crest_error(trial: &Trial, error: fn(&Peak) -> f64, decimals: usize) -> String {
    if trial.peaks.is_empty() {
        return "none".into();
    }
    let middle = median(trial.peaks.iter().map(|peak| error(peak).abs())).unwrap_or(f64::NAN);
    format!("{:.decimals$}", 1e3 * middle)
}

/// Adds the error of one liquid over time, before and after correction.
fn add_curves(report: &mut Report, result: &LiquidResult) -> Result<(), PictureError> {
    let [before, after] = [&result.before, &result.after].map(|trial| trial.score.curves[0].as_slice());
    report.chart(&Chart {
        caption: &format!("{}: mean error of the height over the profile.", result.course.name),
        x: "time, s",
        y: "error, %",
        series: &[
            Series { name: "before", points: before, mark: Mark::Line, colour: 0 },
            Series { name: "after", points: after, mark: Mark::Line, colour: 1 },
        ],
    })
}
