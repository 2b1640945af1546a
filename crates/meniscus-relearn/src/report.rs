//! Report of a run: page, JSON and the crests of one held-out recording.

use crate::error::RelearnError;
use crate::folder::Folder;
use crate::judge::Judged;
use meniscus_platform::files::write_whole;
use meniscus_report::checks::Check;
use meniscus_report::{Chart, Mark, Report, Series};
use serde_json::Value;
use std::path::Path;

/// Everything that a report shows.
pub(crate) struct Content<'a> {
    /// Name of the liquid.
    pub(crate) liquid: &'a str,
    /// Command of the run.
    pub(crate) command: &'a str,
    /// Results in sentences, the first as the answer.
    pub(crate) sentences: &'a [String],
    /// Figures of the finished model.
    pub(crate) judged: &'a Judged,
    /// Figures beside them: the oracle's, and those of the simulations.
    pub(crate) beside: &'a [Check],
}

/// Writes the report of a run to `folder`.
///
/// # Errors
/// [`RelearnError`], when a file cannot be read or written.
pub(crate) fn write(folder: &Folder, content: &Content<'_>) -> Result<(), RelearnError> {
    let mut report = Report::new(&format!("Learned: {}", content.liquid), content.command);
    let (answer, others) = content.sentences.split_first().map_or(("", &[][..]), |(a, o)| (a.as_str(), o));
    report.answer(answer);
    others.iter().for_each(|sentence| report.prose(sentence));
    report.heading("Simulated recordings that no stage saw");
    report.prose(
        "Errors of q, v, e, sigma and tau are relative to their fluctuation, those of the surface to the slosh; root mean square \
         over the recordings, seen through the simulated camera with 2 mm of depth noise. Coverage is the share of the numbers \
         within their 90 % interval. Groups that the model does not know are absent.",
    );
    report.checks(&content.judged.checks);
    if !content.beside.is_empty() {
        report.heading("Beside them");
        report.checks(content.beside);
    }
    let [truth, estimate] = &content.judged.crests;
    if truth.len() > 1 {
        report.chart(&Chart {
            caption: "Crests of the first of these recordings: true, and as the model estimates them.",
            x: "s",
            y: "mm over the fill",
            series: &[
                Series { name: "true", points: truth, mark: Mark::Line, colour: 0 },
                Series { name: "estimated", points: estimate, mark: Mark::Dots, colour: 1 },
            ],
        })?;
    }
    stage(&mut report, "Training", &folder.trained_figures())?;
    stage(&mut report, "Correction on the measured recordings", &folder.corrected_figures())?;
    report.picture("learning-curves.png", "Learning curves of the training.");
    write_whole(&folder.page(), report.html().as_bytes())?;
    let all: Vec<&Check> = content.judged.checks.iter().chain(content.beside).collect();
    let json = serde_json::json!({ "liquid": content.liquid, "sentences": content.sentences, "checks": all });
    // Last, because its being there is what says that the stage is done.
    Ok(write_whole(&folder.report(), format!("{json:#}\n").as_bytes())?)
}

/// Adds the table of the figures of a stage, which lie in `path`, if it ran.
fn stage(report: &mut Report, heading: &str, path: &Path) -> Result<(), RelearnError> {
    let Ok(text) = std::fs::read_to_string(path) else { return Ok(()) };
    let malformed = |fault: String| RelearnError::Malformed { path: path.into(), fault };
    let figures: Value = serde_json::from_str(&text).map_err(|error| malformed(error.to_string()))?;
    let row = |check: &Value| {
        let word = |field: &str| check[field].as_str().unwrap_or_default().to_owned();
        let value = check["value"].as_f64().map_or("not measured".into(), |value| format!("{value:.3}"));
        vec![word("name"), value, word("unit")]
    };
    let rows: Vec<Vec<String>> = figures["checks"].as_array().into_iter().flatten().map(row).collect();
    report.heading(heading);
    report.table(&["figure", "value", "unit"], &rows);
    Ok(())
}
