//! The study as one HTML file.

use super::Outcome;
use super::conditions::Condition;
use meniscus_report::html::{Chart, Mark, Report, Series};
use meniscus_report::plot::PictureError;

/// Columns of the table.
const HEAD: [&str; 11] = [
    "scenes of",
    "which",
    "scenes",
    "profiles",
    "points seen",
    "rms, mm",
    "bias, mm",
    "95 %, mm",
    "worst, mm",
    "inside",
    "+- mm",
];
/// Steps of the curves, and their end, mm.
const STEPS: usize = 120;
const END_MM: f64 = 3.0;

/// The report: table, shares of points below an error, checks, what is not covered.
///
/// # Errors
/// [`PictureError`], when there is no point to draw.
pub fn html(outcome: &Outcome, command: &str) -> Result<String, PictureError> {
    let mut report = Report::new("The surface seen by a rendered camera", command);
    report.prose(
        "Errors are of the points that were seen, against the true contact line. 'inside' is the share of the points \
         inside their stated interval, '+- mm' its mean half width. Refraction, the meniscus and the smear of stereo \
         matching are not rendered, so that no figure contains them.",
    );
    let number = |value: f64| if value.is_finite() { format!("{value:.3}") } else { "-".into() };
    let row = |row: &super::Row| -> Vec<String> {
        let figures =
            [row.points_seen, row.rms_mm, row.bias_mm, row.p95_mm, row.worst_mm, row.coverage, row.half_mm];
        let head =
            [row.group.into(), row.name.clone(), format!("{}", row.scenes), format!("{}", row.profiles)];
        head.into_iter().chain(figures.map(number)).collect()
    };
    report.table(&HEAD, &outcome.rows.iter().map(row).collect::<Vec<_>>());
    let share = |keep: &dyn Fn(Condition) -> bool| -> Vec<(f64, f64)> {
        let kept = outcome.scenes.iter().filter(|judged| keep(judged.case.condition));
        let sizes: Vec<f64> =
            kept.flat_map(|judged| &judged.points).map(|point| point.error_mm.abs()).collect();
        let at = |step: usize| {
            let error = END_MM * step as f64 / STEPS as f64;
            let below = sizes.iter().filter(|size| **size <= error).count();
            (error, 100.0 * below as f64 / sizes.len() as f64)
        };
        (0..=STEPS).map(at).collect()
    };
    let noise = [Condition::Nominal, Condition::DoubleNoise];
    let curves = [
        ("the camera's noise", share(&|condition| condition == Condition::Nominal), 1),
        ("twice that", share(&|condition| condition == Condition::DoubleNoise), 2),
        ("holes, foam, glare, a finger", share(&|condition| !noise.contains(&condition)), 4),
    ];
    let series: Vec<Series<'_>> = curves
        .iter()
        .map(|(name, points, colour)| Series { name, points, mark: Mark::Line, colour: *colour })
        .collect();
    report.chart(&Chart {
        caption: "Share of the points whose error is below that of the abscissa.",
        x: "error of the height, mm",
        y: "points, %",
        series: &series,
    })?;
    report.checks(&outcome.checks);
    for trouble in &outcome.unrecovered {
        report.prose(&format!("Not as it must be: {trouble}"));
    }
    if let Err(why) = &outcome.golden {
        report.prose(why);
    }
    Ok(report.html())
}
