//! Section of the page on a drawn law: both curves with their bands, the gap, and the recording that would help.

use crate::findings::Findings;
use crate::law::band::{Band, CONFIDENCE};
use crate::law::draw::Drawn;
use crate::workflow;
use meniscus_report::plot::PictureError;
use meniscus_report::{Chart, Mark, Report, Series};

/// Adds the section, where a law was tried.
///
/// # Errors
/// [`PictureError`], when a curve has no number to draw.
pub(super) fn law(report: &mut Report, outcome: &workflow::Report) -> Result<(), PictureError> {
    let drawn = match &outcome.law {
        None => return Ok(()),
        Some(Err(why)) => {
            report.heading("No law is drawn");
            report.prose(&format!("No name fits, and no force is drawn either: {why}."));
            return Ok(());
        }
        Some(Ok(drawn)) => drawn,
    };
    report.heading("Law without a name");
    report.prose(&format!(
        "{} It acts in the reduced model: the force stores energy, the drag makes heat and is never negative, and both laws of \
         GENERIC stay exact. The bands hold the whole curve with a confidence of {:.0} %. BIC is {:.0} lower than without a force; the \
         misfit with the law is {:.2}.",
        drawn.sentence(),
        100.0 * CONFIDENCE,
        drawn.gain,
        drawn.misfit
    ));
    let near = drawn.nearest.as_ref();
    let force = Axes {
        caption: "Force on the first mode by the height of its crest.",
        x: "height, mm",
        scale: 1e3,
        least_n: f64::NEG_INFINITY,
    };
    curve(report, &drawn.bands.force, &force, near.map(|n| (n.name, n.force_n.as_slice())))?;
    let drag = Axes {
        caption: "Drag on the first mode in a cycle, by the largest rate of that cycle.",
        x: "rate, m/s",
        scale: 1.0,
        least_n: 0.0,
    };
    curve(report, &drawn.bands.drag, &drag, near.map(|n| (n.name, n.drag_n.as_slice())))?;
    held_out(report, &outcome.findings, drawn)?;
    suggestion(report, drawn, outcome.findings.rules.decisive_separation);
    Ok(())
}

/// Labels of a curve, the scale of its abscissa, and the least value that it can have.
struct Axes {
    least_n: f64,
    caption: &'static str,
    x: &'static str,
    scale: f64,
}

/// Adds one curve with its band and the curve of the nearest formula.
fn curve(
    report: &mut Report,
    band: &Band,
    axes: &Axes,
    near: Option<(&'static str, &[f64])>,
) -> Result<(), PictureError> {
    let points = |of: &dyn Fn(usize) -> f64| -> Vec<(f64, f64)> {
        band.at.iter().enumerate().map(|(i, at)| (axes.scale * at, 1e3 * of(i))).collect()
    };
    let middle = points(&|i| band.value[i]);
    let low = points(&|i| (band.value[i] - band.half[i]).max(axes.least_n));
    let high = points(&|i| band.value[i] + band.half[i]);
    let formula = near.map(|(name, curve)| (name, points(&|i| curve[i])));
    let mut series = vec![
        Series { name: "band, lower end", points: &low, mark: Mark::Line, colour: 2 },
        Series { name: "band, upper end", points: &high, mark: Mark::Line, colour: 2 },
        Series { name: "drawn law", points: &middle, mark: Mark::Line, colour: 0 },
    ];
    if let Some((name, points)) = &formula {
        series.push(Series { name, points, mark: Mark::Line, colour: 1 });
    }
    report.chart(&Chart { caption: axes.caption, x: axes.x, y: "mN", series: &series })
}

/// Adds the errors on the held-out recording.
fn held_out(report: &mut Report, findings: &Findings, drawn: &Drawn) -> Result<(), PictureError> {
    let (Some(gap), Some(law)) = (findings.gap.as_ref().map(|measured| measured.gap), &drawn.gap) else {
        return Ok(());
    };
    let rows = [
        ("untouched", gap.untouched),
        ("nuisances fitted again", gap.refitted),
        ("black-box correction", gap.black_box),
        ("with the drawn law", law.law_m),
    ];
    let rows: Vec<_> = rows.map(|(name, m)| vec![name.into(), format!("{:.3}", 1e3 * m)]).into();
    report.table(&["model on the held-out recording", "error, mm"], &rows);
    let column = |which: usize| -> Vec<(f64, f64)> {
        law.curves.iter().map(|row| (row[0], 1e3 * row[which])).collect()
    };
    let [measured, untouched, with] = [1, 2, 3].map(column);
    let series = [
        Series { name: "measured", points: &measured, mark: Mark::Dots, colour: 0 },
        Series { name: "untouched", points: &untouched, mark: Mark::Line, colour: 2 },
        Series { name: "with the drawn law", points: &with, mark: Mark::Line, colour: 1 },
    ];
    let caption = "Slope of the surface of the held-out recording, with the drawn law.";
    report.chart(&Chart { caption, x: "t, s", y: "mm", series: &series })
}

/// Adds the recording that would help.
fn suggestion(report: &mut Report, drawn: &Drawn, decisive: f64) {
    let Some(suggestion) = &drawn.suggestion else { return };
    let [one, two] = &suggestion.between;
    report.prose(&if suggestion.hopeful() {
        format!(
            "Record {}: it separates {one} from {two} by {:.1} times the noise ({decisive} is enough) and takes {:.0} s.",
            suggestion.motion, suggestion.separation, suggestion.seconds
        )
    } else {
        format!("No motion that was considered separates {one} from {two}: both predict the same.")
    });
}
