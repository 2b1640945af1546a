//! Measured water in a moved cylinder (Di Leva et al. 2022): what the motion files know is withheld from
//! the model, and has to be found. The data are read in place and are no part of the project.

use super::super::calibrate::Group;
use super::super::predict::{Known, SHARED, predict};
use super::super::record::Record;
use super::super::settings::Settings;
use super::super::thresholds::Thresholds;
use super::super::verdict::Decision;
use super::super::workflow::{Discovery, discover};
use crate::motion_table::{peaks, poses};
use meniscus::reduced::effects::Active;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Deviation of each recording's own clock after alignment, s.
const CLOCK_S: f64 = 0.02;

/// What one question to the measured data gave.
#[derive(Clone, Debug)]
pub struct Asked {
    /// The discovery.
    pub discovery: Discovery,
    /// What is told of it.
    pub told: Told,
}

/// What is told of one question.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Told {
    /// What was withheld and on which runs.
    pub title: String,
    /// The verdict in a sentence.
    pub sentence: String,
    /// The names in it.
    pub names: Vec<String>,
    /// Name, root mean square error before and after, m, of each run.
    pub runs: Vec<(String, f64, f64)>,
}

impl Told {
    /// Mean error over the runs before and after, mm.
    #[must_use]
    pub fn means_mm(&self) -> [f64; 2] {
        let n = self.runs.len().max(1) as f64;
        let mean = |of: &dyn Fn(&(String, f64, f64)) -> f64| 1e3 * self.runs.iter().map(of).sum::<f64>() / n;
        [mean(&|run| run.1), mean(&|run| run.2)]
    }
}

/// Water in the cylinder of R = 49 mm, 78 mm deep; `told` of inclination and vertical acceleration.
fn known(told: [f64; 2]) -> Known {
    Known { radius_m: 0.049, fill_m: 0.078, density_kg_m3: 998.0, viscosity_pa_s: 1.0e-3, told }
}

/// How much of a run is looked at.
#[derive(Clone, Copy)]
struct Cut {
    /// At most, s.
    seconds: f64,
    /// After the motion, s.
    after_s: f64,
}

/// The runs in `folder` whose names start with one of `starts`.
fn runs(folder: &Path, starts: &[&str], cut: Cut) -> Result<Vec<Record>, String> {
    let mut names: Vec<String> = std::fs::read_dir(folder.join("heights"))
        .map_err(|e| format!("{}: {e}", folder.display()))?
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter(|name| starts.iter().any(|start| name.starts_with(start)))
        .collect();
    names.sort();
    names.iter().map(|name| run(folder, name, cut)).collect()
}

fn run(folder: &Path, name: &str, cut: Cut) -> Result<Record, String> {
    let text = |kind: &str| {
        let path = folder.join(kind).join(name);
        std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))
    };
    let (interval_s, mut channels) = peaks(&text("heights")?).map_err(|why| format!("{name}: {why}"))?;
    let (drive, length_s) = poses(&text("motions")?).map_err(|why| format!("{name}: {why}"))?;
    // The clocks are not synchronised: where the wave stands highest, the glass moves. The recording is
    // cut to three seconds before that window and some after it.
    let heights: Vec<f64> = channels[0].value.iter().map(|z| z.unwrap_or(0.0)).collect();
    let frames = |s: f64| (s / interval_s).round() as usize;
    let window = frames(length_s).min(heights.len());
    let sum = |from: usize| heights[from..from + window].iter().map(|z| z * z).sum::<f64>();
    let last = heights.len() - window;
    // The earliest window that holds nearly all there is: decays are long, motions are short.
    let most = (0..=last).map(sum).fold(0.0, f64::max);
    let start = (0..=last).find(|from| sum(*from) > 0.98 * most).unwrap_or(0);
    let first = start.saturating_sub(frames(3.0));
    let kept = (window + frames(3.0 + cut.after_s)).min(frames(cut.seconds)).min(heights.len() - first);
    let value: Vec<Option<f64>> = channels[0].value[first..first + kept].to_vec();
    // Downward spikes are lost sights: the highest point does not fall by 3 mm within a frame and back.
    let spike = |i: usize| {
        let near = |j: usize| value.get(j).copied().flatten().unwrap_or(0.0);
        i > 0 && near(i - 1) - near(i) > 3e-3 && near(i + 1) - near(i) > 3e-3
    };
    channels[0].value = (0..kept).map(|i| value[i].filter(|_| !spike(i))).collect();
    Ok(Record { name: name.trim_end_matches(".csv").into(), interval_s, channels, drive, rest_frames: 30 })
}

/// `record` with its drive moved in time to where the model fits best under any of `tolds`; the glass
/// rests where the motion says nothing.
fn aligned(record: &Record, theta: &[f64], tolds: &[[f64; 2]]) -> Record {
    let shifted = |lag: f64| {
        let mut out = record.clone();
        let shift = (lag * record.drive.rate_hz).round() as isize;
        let samples = (record.frames() as f64 * record.interval_s * record.drive.rate_hz) as isize + 2;
        let n = record.drive.along_m_s2.len() as isize;
        let from = |i: isize| usize::try_from(i - shift).ok().filter(|j| (*j as isize) < n);
        let source = &record.drive;
        let pairs = |v: &[[f64; 2]]| (0..samples).map(|i| from(i).map_or([0.0; 2], |j| v[j])).collect();
        let numbers = |v: &[f64]| (0..samples).map(|i| from(i).map_or(0.0, |j| v[j])).collect();
        out.drive.along_m_s2 = pairs(&source.along_m_s2);
        out.drive.tilted_m_s2 = pairs(&source.tilted_m_s2);
        out.drive.lift_m_s2 = numbers(&source.lift_m_s2);
        out.drive.place_m = numbers(&source.place_m);
        out
    };
    let error = |lag: f64| {
        let moved = shifted(lag);
        tolds.iter().map(|told| rms(&moved, &known(*told), theta, 0.0, &[])).fold(f64::INFINITY, f64::min)
    };
    let search = |middle: f64, reach: f64, step: f64| {
        let n = (reach / step).round() as i32;
        (-n..=n)
            .into_par_iter()
            .map(|i| middle + step * f64::from(i))
            .map(|lag| (error(lag), lag))
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map_or(middle, |best| best.1)
    };
    let coarse = search(2.0, 4.0, 0.05);
    let mut out = shifted(search(coarse, 0.06, 0.01));
    let moves = |n: usize| out.drive.at(n as f64 * out.interval_s).0.iter().any(|a| a.abs() > 0.05);
    out.rest_frames = (0..out.frames()).take_while(|n| !moves(*n)).count().max(4);
    out
}

/// Root mean square error of the model while the glass moves and two seconds after, m.
fn rms(record: &Record, known: &Known, theta: &[f64], lag: f64, active: &[Active]) -> f64 {
    let expected = predict(record, known, theta, lag, active);
    let pairs = record.channels[0].value.iter().zip(&expected[0]).skip(record.rest_frames);
    let (sum, count) = pairs.fold((0.0, 0.0), |(s, n), (y, e)| match y {
        Some(y) => (s + (y - e) * (y - e), n + 1.0),
        None => (s, n),
    });
    (sum / f64::max(count, 1.0)).sqrt()
}

/// The smallest error over the lag near the alignment, m.
fn best_rms(record: &Record, known: &Known, theta: &[f64], active: &[Active]) -> f64 {
    (-30..=30).map(|i| rms(record, known, theta, 0.01 * f64::from(i), active)).fold(f64::INFINITY, f64::min)
}

/// Puts the first `questions` of four to the data in `folder`: tilt withheld on the tilt runs, vertical
/// acceleration withheld on the 3D runs, the same on the 2D runs, and nothing withheld on the 2D runs with their
/// long decays, which nobody knows the answer to: no references, theory alone. Recordings are cut to `seconds`, of
/// decays to twice as much.
///
/// # Errors
/// In words, when a file cannot be read or a fit fails.
pub fn ask_measured(
    folder: &Path,
    settings: &Settings,
    seconds: f64,
    questions: usize,
) -> Result<Vec<Asked>, String> {
    let settings = Settings { own_clocks_s: Some(CLOCK_S), ..settings.clone() };
    let plain = super::super::calibrate::Calibration::blind(&[], CLOCK_S);
    let all = [[1.0, 1.0], [0.0, 1.0], [1.0, 0.0]];
    let moving = Cut { seconds, after_s: 3.0 };
    let decaying = Cut { seconds: 2.0 * seconds, after_s: 20.0 };
    let load = |starts: &[&str], tolds: &[[f64; 2]], cut: Cut| -> Result<Vec<Record>, String> {
        Ok(runs(folder, starts, cut)?.iter().map(|r| aligned(r, &plain.mean, tolds)).collect())
    };
    // Untilted and horizontal: the references, one group a path.
    let mut groups = Vec::new();
    for start in ["LE_2D", "RD_2D", "TRD_2D"] {
        groups.push(Group::new(known([1.0, 1.0]), load(&[start], &all[..1], moving)?, Some(CLOCK_S))?);
    }
    let references: Vec<&Group> = groups.iter().collect();
    let flat = ["LE_2D", "RD_2D", "TRD_2D"];
    let mut out = Vec::new();
    let unknown: &[&Group] = &[];
    for (title, starts, told, tolds, (cut, known_by)) in [
        (
            "inclination withheld, tilt runs (LE, RD)",
            &["Tilt_LE", "Tilt_RD"][..],
            [0.0, 1.0],
            &all[..2],
            (moving, &references[..]),
        ),
        (
            "vertical acceleration withheld, 3D runs",
            &["LE_3D", "RD_3D", "TRD_3D"][..],
            [1.0, 0.0],
            &[all[0], all[2]][..],
            (moving, &references[..]),
        ),
        (
            "vertical acceleration withheld, 2D runs",
            &flat[..],
            [1.0, 0.0],
            &all[..1],
            (moving, &references[..]),
        ),
        (
            "nothing withheld, 2D runs with their free decays, no references",
            &flat[..],
            [1.0, 1.0],
            &all[..1],
            (decaying, unknown),
        ),
    ]
    .into_iter()
    .take(questions)
    {
        let records = load(starts, tolds, cut)?;
        // Half of the runs, evenly spread, are fitted; every run is scored.
        let few: Vec<Record> = records.iter().step_by(records.len().div_ceil(6)).cloned().collect();
        let any = f64::INFINITY;
        let limits = Thresholds { gain: 20.0, chi2: any, clean_chi2: any, ..Thresholds::default() };
        let discovery = discover(&few, known(told), known_by, &limits, &settings)?;
        let chosen = &discovery.verdict.chosen;
        let named = !matches!(discovery.verdict.decision, Decision::None);
        let theta = &discovery.calibration.mean;
        let scored = |record: &Record| {
            let before = best_rms(record, &known(told), theta, &[]);
            let active: &[Active] = if named { &chosen.active } else { &[] };
            let after = best_rms(record, &known(told), &chosen.theta[..SHARED], active);
            (record.name.clone(), before, after)
        };
        let said = if named { discovery.verdict.names.as_slice() } else { &[] };
        let told = Told {
            title: title.into(),
            sentence: discovery.verdict.sentence(),
            names: said.iter().map(|name| String::from(*name)).collect(),
            runs: records.iter().map(scored).collect(),
        };
        out.push(Asked { discovery, told });
    }
    Ok(out)
}
