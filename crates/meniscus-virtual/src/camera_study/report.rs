//! The study as a report.

use super::Outcome;
use super::conditions::Condition;
use super::judge::Row;
use meniscus_report::plot::PictureError;
use meniscus_report::{Chart, Mark, Report, Series};

/// Steps of the curves.
const STEPS: usize = 120;

/// End of the curves, mm.
const END_MM: f64 = 3.0;

/// Returns the report: table, shares of points below an error, checks, and what is not covered. The pictures errors.png
/// and scenes.png lie beside it (see [`super::errors_png`], [`super::scenes_png`]).
///
/// # Errors
/// [`PictureError`], when there is no point to draw.
pub fn report(outcome: &Outcome, command: &str) -> Result<Report, PictureError> {
    let mut report = Report::new("The surface seen by a rendered camera", command);
    report.prose(
        "Errors are of the points that were seen, against the true contact line. 'inside' is the share of the points \
         inside their stated interval, '+- mm' its mean half width.",
    );
    report.table(&Row::HEAD, &outcome.rows.iter().map(Row::cells).collect::<Vec<_>>());
    add_shares(&mut report, outcome)?;
    report.picture("errors.png", "errors by condition");
    report.picture("scenes.png", "scenes");
    report.checks(&outcome.checks);
    if let Err(why) = &outcome.golden {
        report.prose(&format!("{why}."));
    }
    if let Some(why) = &outcome.traced_missing {
        report.prose(&format!("{why}."));
    }
    for trouble in &outcome.unrecovered {
        report.prose(&format!("Not as it must be: {trouble}"));
    }
    report.prose(
        "The scenes of the picture are rendered without refraction by the glass and without a meniscus. The path-traced ones \
         have both; nobody looked at them while the reader was written. In no figure is the smear of stereo matching at \
         steps in depth.",
    );
    Ok(report)
}

/// Adds the share of the points below an error, by condition.
fn add_shares(report: &mut Report, outcome: &Outcome) -> Result<(), PictureError> {
    let noise = [Condition::Nominal, Condition::DoubleNoise];
    let curves = [
        ("the camera's noise", shares(outcome, |condition| condition == Condition::Nominal), 1),
        ("twice that", shares(outcome, |condition| condition == Condition::DoubleNoise), 2),
        ("holes, foam, glare, a finger", shares(outcome, |condition| !noise.contains(&condition)), 4),
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
    })
}

/// Errors (mm) and the shares (%) of the points of the scenes that `keep` selects with at most that error.
fn shares(outcome: &Outcome, keep: impl Fn(Condition) -> bool) -> Vec<(f64, f64)> {
    let kept = outcome.scenes.iter().filter(|judged| keep(judged.case.condition));
    let sizes: Vec<f64> = kept.flat_map(|judged| &judged.points).map(|point| point.error_mm.abs()).collect();
    let at = |step: usize| {
        let error = END_MM * step as f64 / STEPS as f64;
        let below = sizes.iter().filter(|size| **size <= error).count();
        (error, 100.0 * below as f64 / sizes.len() as f64)
    };
    (0..=STEPS).map(at).collect()
}
