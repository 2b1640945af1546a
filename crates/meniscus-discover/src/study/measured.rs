//! Measured water in a moved cylinder (Di Leva et al. 2022): a part of the recorded motion is withheld from the model and
//! has to be found. The data are read in place and are no part of the project.

use super::error::StudyError;
use super::measured_runs::{Cut, aligned, best_rms, known, runs};
use crate::baseline::calibrate::Calibration;
use crate::baseline::group::Group;
use crate::baseline::predict::SHARED;
use crate::decision::settings::Settings;
use crate::decision::thresholds::Thresholds;
use crate::findings::Findings;
use crate::recordings::record::Record;
use crate::workflow::discover;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Deviation of each recording's own clock after alignment, s.
const CLOCK_S: f64 = 0.02;

/// Outcome of one question to the measured data.
#[derive(Clone, Debug)]
pub struct MeasuredCase {
    /// Findings on the runs that were fitted.
    pub findings: Findings,
    /// Errors of all runs.
    pub result: MeasuredResult,
}

/// Verdict on one question, and the errors before and after.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MeasuredResult {
    /// Withheld part of the motion, and the runs.
    pub title: String,
    /// The verdict in a sentence.
    pub sentence: String,
    /// Names of the verdict.
    pub names: Vec<String>,
    /// Name, root mean square error before and after, m, of each run.
    pub runs: Vec<(String, f64, f64)>,
}

impl MeasuredResult {
    /// Returns the mean error over the runs before and after, mm.
    #[must_use]
    pub fn means_mm(&self) -> [f64; 2] {
        let n = self.runs.len().max(1) as f64;
        let mean = |of: &dyn Fn(&(String, f64, f64)) -> f64| 1e3 * self.runs.iter().map(of).sum::<f64>() / n;
        [mean(&|run| run.1), mean(&|run| run.2)]
    }
}

/// One of the questions that are put to the measurements.
struct Question<'a> {
    title: &'static str,
    /// Beginnings of the names of the runs.
    starts: &'a [&'static str],
    /// Shares of inclination and vertical acceleration that enter the model.
    share: [f64; 2],
    /// Shares under which a run may be aligned in time.
    alignments: &'a [[f64; 2]],
    /// Part of each run that is used.
    cut: Cut,
    /// Whether there are references.
    references: bool,
}

/// Judges the first `questions` of four on the data in `folder`.
///
/// They are: inclination withheld on the tilt runs, vertical acceleration withheld on the 3D runs, the same on the 2D
/// runs, and nothing withheld on the 2D runs with their long decays and without references, whose answer is not known.
/// Recordings are cut to `seconds`, decays to twice as much.
///
/// # Errors
/// [`StudyError`], when a file cannot be read or a fit fails.
pub fn judge_measured(
    folder: &Path,
    settings: &Settings,
    seconds: f64,
    questions: usize,
) -> Result<Vec<MeasuredCase>, StudyError> {
    let settings = Settings { own_clocks_s: Some(CLOCK_S), ..settings.clone() };
    let plain = Calibration::blind(&[], CLOCK_S);
    let all = [[1.0, 1.0], [0.0, 1.0], [1.0, 0.0]];
    let moving = Cut { seconds, after_s: 3.0 };
    let decaying = Cut { seconds: 2.0 * seconds, after_s: 20.0 };
    let load = |starts: &[&str], shares: &[[f64; 2]], cut: Cut| -> Result<Vec<Record>, StudyError> {
        Ok(runs(folder, starts, cut)?.iter().map(|r| aligned(r, &plain.mean, shares)).collect())
    };
    // Untilted and horizontal: the references, one group a path.
    let flat = ["LE_2D", "RD_2D", "TRD_2D"];
    let mut groups = Vec::new();
    for start in flat {
        groups.push(Group::new(known([1.0, 1.0]), load(&[start], &all[..1], moving)?, Some(CLOCK_S))?);
    }
    let references: Vec<&Group> = groups.iter().collect();
    let vertical = [all[0], all[2]];
    let list = [
        Question {
            title: "inclination withheld, tilt runs (LE, RD)",
            starts: &["Tilt_LE", "Tilt_RD"],
            share: [0.0, 1.0],
            alignments: &all[..2],
            cut: moving,
            references: true,
        },
        Question {
            title: "vertical acceleration withheld, 3D runs",
            starts: &["LE_3D", "RD_3D", "TRD_3D"],
            share: [1.0, 0.0],
            alignments: &vertical,
            cut: moving,
            references: true,
        },
        Question {
            title: "vertical acceleration withheld, 2D runs",
            starts: &flat,
            share: [1.0, 0.0],
            alignments: &all[..1],
            cut: moving,
            references: true,
        },
        Question {
            title: "nothing withheld, 2D runs with their free decays, no references",
            starts: &flat,
            share: [1.0, 1.0],
            alignments: &all[..1],
            cut: decaying,
            references: false,
        },
    ];
    let judged = list.iter().take(questions).map(|question| {
        let records = load(question.starts, question.alignments, question.cut)?;
        let against = if question.references { references.as_slice() } else { &[] };
        judge(question, &records, against, &settings)
    });
    judged.collect()
}

/// Judges one question on `records`.
fn judge(
    question: &Question<'_>,
    records: &[Record],
    references: &[&Group],
    settings: &Settings,
) -> Result<MeasuredCase, StudyError> {
    let known = known(question.share);
    // Half of the runs, evenly spread, are fitted; every run is scored.
    let few: Vec<Record> = records.iter().step_by(records.len().div_ceil(6)).cloned().collect();
    // Three groups in other motions are too few for thresholds, so the gain alone decides.
    let any = f64::INFINITY;
    let limits = Thresholds { gain: 20.0, chi2: any, clean_chi2: any, ..Thresholds::default() };
    let findings = discover(&few, known, references, &limits, settings)?;
    let (verdict, chosen) = (&findings.assessment.verdict, findings.assessment.chosen());
    let theta = &findings.calibration.mean;
    let scored = |record: &Record| {
        let before = best_rms(record, &known, theta, &[]);
        let after = best_rms(record, &known, &chosen.theta[..SHARED], &chosen.active);
        (record.name.clone(), before, after)
    };
    let result = MeasuredResult {
        title: question.title.into(),
        sentence: verdict.sentence(),
        names: verdict.names().iter().map(|name| String::from(*name)).collect(),
        runs: records.iter().map(scored).collect(),
    };
    Ok(MeasuredCase { findings, result })
}
