//! Runs of the measured water: reading, and the error of a model on them.

use super::error::StudyError;
use crate::baseline::predict::predict;
use crate::recordings::error::TableError;
use crate::recordings::record::Record;
use crate::recordings::stated::{CALLIPERS_M, Known};
use crate::recordings::tables::{peaks, poses};
use meniscus::reduced::effects::Active;
use std::path::Path;

/// Returns water in the cylinder of R = 49 mm, 78 mm deep.
pub(super) fn known(motion_share: [f64; 2]) -> Known {
    Known {
        radius_m: 0.049,
        radius_error_m: CALLIPERS_M,
        fill_m: 0.078,
        density_kg_m3: 998.0,
        viscosity_pa_s: 1.0e-3,
        motion_share,
    }
}

/// Part of a run that is used.
#[derive(Clone, Copy)]
pub(super) struct Cut {
    /// Longest duration, s.
    pub(super) seconds: f64,
    /// Duration after the motion, s.
    pub(super) after_s: f64,
}

/// Reads the runs in `folder` whose names start with one of `starts`; there is at least one.
pub(super) fn runs(folder: &Path, starts: &[&str], cut: Cut) -> Result<Vec<Record>, StudyError> {
    let heights = folder.join("heights");
    let mut names: Vec<String> = std::fs::read_dir(&heights)
        .map_err(|cause| StudyError::Read { path: heights.clone(), cause })?
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter(|name| starts.iter().any(|start| name.starts_with(start)))
        .collect();
    if names.is_empty() {
        let starts = starts.iter().map(|start| String::from(*start)).collect();
        return Err(StudyError::NoRuns { folder: heights, starts });
    }
    names.sort();
    names.iter().map(|name| run(folder, name, cut)).collect()
}

/// Reads one run.
fn run(folder: &Path, name: &str, cut: Cut) -> Result<Record, StudyError> {
    let text = |kind: &str| {
        let path = folder.join(kind).join(name);
        std::fs::read_to_string(&path).map_err(|cause| StudyError::Read { path, cause })
    };
    let in_table = |fault: TableError| StudyError::Table { run: name.into(), fault };
    let (interval_s, mut channels) = peaks(&text("heights")?).map_err(in_table)?;
    let (drive, length_s) = poses(&text("motions")?).map_err(in_table)?;
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
    // Downward spikes are lost measurements: the highest point does not fall by 3 mm within a frame and back.
    let spike = |i: usize| {
        let near = |j: usize| value.get(j).copied().flatten().unwrap_or(0.0);
        i > 0 && near(i - 1) - near(i) > 3e-3 && near(i + 1) - near(i) > 3e-3
    };
    channels[0].value = (0..kept).map(|i| value[i].filter(|_| !spike(i))).collect();
    Ok(Record { name: name.trim_end_matches(".csv").into(), interval_s, channels, drive, rest_frames: 30 })
}

/// Returns the root mean square error of the model while the glass moves and two seconds after, m.
fn rms(record: &Record, known: &Known, theta: &[f64], lag: f64, active: &[Active]) -> f64 {
    let expected = predict(record, known, theta, lag, active);
    let pairs = record.channels[0].value.iter().zip(&expected[0]).skip(record.rest_frames);
    let (sum, count) = pairs.fold((0.0, 0.0), |(s, n), (y, e)| match y {
        Some(y) => (s + (y - e) * (y - e), n + 1.0),
        None => (s, n),
    });
    (sum / f64::max(count, 1.0)).sqrt()
}

/// Returns the smallest error over the lag near the alignment, m.
pub(super) fn best_rms(record: &Record, known: &Known, theta: &[f64], active: &[Active]) -> f64 {
    (-30..=30).map(|i| rms(record, known, theta, 0.01 * f64::from(i), active)).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_set_without_the_runs_of_a_question_is_refused() {
        let fixture = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/fixtures/antisloshing");
        let cut = Cut { seconds: 14.0, after_s: 3.0 };
        let count = |starts: &[&str]| runs(&fixture, starts, cut).map(|runs| runs.len());
        assert_eq!(count(&["Tilt_LE", "Tilt_RD"]).expect("it has tilt runs"), 6);
        let refused = count(&["LE_3D", "RD_3D", "TRD_3D"]).expect_err("it has no 3D runs").to_string();
        assert!(refused.contains("no run in it is called LE_3D..., RD_3D..., TRD_3D..."), "{refused}");
    }
}
