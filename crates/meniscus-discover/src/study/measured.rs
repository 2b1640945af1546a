//! Measured water in a moved cylinder (Di Leva et al. 2022): a part of the recorded motion is withheld from the model and
//! has to be found. The data are read in place and are no part of the project.

use super::error::StudyError;
use super::measured_runs::{Cut, best_rms, known, runs};
use crate::baseline::group::Group;
use crate::baseline::predict::SHARED;
use crate::decision::settings::Settings;
use crate::decision::thresholds::{Thresholds, thresholds};
use crate::findings::Findings;
use crate::recordings::record::Record;
use crate::workflow::clocks::{Aligned, AlignedClock, aligned};
use crate::workflow::discover;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Deviation of each recording's own clock after alignment, s.
const CLOCK_S: f64 = 0.02;

/// Times by which the motion of a run may begin after its cut, s.
const RANGE_S: (f64, f64) = (-2.0, 6.0);

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
    /// Runs whose clock is ambiguous, in words.
    #[serde(default)]
    pub left_out: Vec<String>,
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
    let moving = Cut { seconds, after_s: 3.0 };
    let decaying = Cut { seconds: 2.0 * seconds, after_s: 20.0 };
    let load = |starts: &[&str], share: [f64; 2], cut: Cut| -> Result<Aligned, StudyError> {
        Ok(aligned(&runs(folder, starts, cut)?, &known(share), RANGE_S))
    };
    // Untilted and horizontal: the references, one group a path.
    let flat = ["LE_2D", "RD_2D", "TRD_2D"];
    let mut groups = Vec::new();
    for start in flat {
        groups.push(Group::new(
            known([1.0, 1.0]),
            load(&[start], [1.0, 1.0], moving)?.records,
            Some(CLOCK_S),
        )?);
    }
    let references: Vec<&Group> = groups.iter().collect();
    let with = Judges { groups: &references, limits: thresholds(&references, &settings)? };
    let without = Judges { groups: &[], limits: thresholds(&[], &settings)? };
    let list = [
        Question {
            title: "inclination withheld, tilt runs (LE, RD)",
            starts: &["Tilt_LE", "Tilt_RD"],
            share: [0.0, 1.0],
            cut: moving,
            references: true,
        },
        Question {
            title: "vertical acceleration withheld, 3D runs",
            starts: &["LE_3D", "RD_3D", "TRD_3D"],
            share: [1.0, 0.0],
            cut: moving,
            references: true,
        },
        Question {
            title: "vertical acceleration withheld, 2D runs",
            starts: &flat,
            share: [1.0, 0.0],
            cut: moving,
            references: true,
        },
        Question {
            title: "nothing withheld, 2D runs with their free decays, no references",
            starts: &flat,
            share: [1.0, 1.0],
            cut: decaying,
            references: false,
        },
    ];
    let judged = list.iter().take(questions).map(|question| {
        let runs = load(question.starts, question.share, question.cut)?;
        judge(question, &runs, if question.references { &with } else { &without }, &settings)
    });
    judged.collect()
}

/// References and the thresholds that they set.
struct Judges<'a> {
    groups: &'a [&'a Group],
    limits: Thresholds,
}

/// Judges one question on `runs`, as the program judges a folder against references.
fn judge(
    question: &Question<'_>,
    runs: &Aligned,
    judges: &Judges<'_>,
    settings: &Settings,
) -> Result<MeasuredCase, StudyError> {
    let known = known(question.share);
    let records = &runs.records;
    // Half of the runs, evenly spread, are fitted; every run is scored.
    let few: Vec<Record> = records.iter().step_by(records.len().div_ceil(6)).cloned().collect();
    let findings = discover(&few, known, judges.groups, &judges.limits, settings)?;
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
        left_out: runs.clocks.iter().filter_map(AlignedClock::refusal).collect(),
    };
    Ok(MeasuredCase { findings, result })
}
