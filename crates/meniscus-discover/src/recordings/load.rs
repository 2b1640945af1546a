//! Folders of recordings: a setup, and for each recording a measurement and a motion.
//!
//! ```text
//! DIR/setup.toml          glass, liquid, what is measured          (see docs/formats.md)
//! DIR/NAME.profile.csv    profiles of the camera, as `meniscus record` writes them; or
//! DIR/NAME.gauges.csv     time_s,height_mm@x=-30mm,...   heights at a few places of the wall; or
//! DIR/NAME.peak.csv       time_s,peak_height_above_rest_mm
//! DIR/NAME.motion.csv     the motion of the glass, as `meniscus simulate --motion` takes it; or
//! DIR/NAME.pose.csv       t;x;y;z;qx;qy;qz;qw without heading, m, robot poses
//! ```

use super::error::{LoadError, RecordingError, TableError};
use super::gauges;
use super::record::{Channel, Drive, Quantity, Record};
use super::stated::{CALLIPERS_M, Known};
use super::tables::{moved, peaks, poses, profiles};
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// Acceleration above which the glass counts as moved, m/s2.
const MOVED_M_S2: f64 = 0.02;

/// Fewest frames of rest from which the noise can be learnt.
pub const LEAST_REST: usize = 8;

/// Largest shift between the clocks of camera and motion that is searched, s, and the smallest that is refused: more
/// than any latency or delay that is an effect.
const MAX_SHIFT_S: f64 = 3.0;
const MIN_SHIFT_S: f64 = 0.25;

/// Endings of the files of a measurement.
const MEASURED: [&str; 3] = [".profile.csv", ".gauges.csv", ".peak.csv"];

/// Recordings of one liquid in one glass.
#[derive(Debug)]
pub struct RecordingSet {
    /// Glass and liquid as stated.
    pub known: Known,
    /// Whether every recording has a clock of its own.
    pub own_clocks: bool,
    /// Recordings, by name.
    pub records: Vec<Record>,
    /// Reasons for which recordings were left out.
    pub left_out: Vec<RecordingError>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Setup {
    radius_m: f64,
    #[serde(default = "callipers")]
    radius_error_m: f64,
    fill_m: f64,
    density_kg_m3: f64,
    viscosity_pa_s: f64,
    #[serde(default)]
    own_clocks: bool,
    #[serde(default = "one", alias = "tilt_told")]
    tilt_share: f64,
    #[serde(default = "one", alias = "vertical_told")]
    vertical_share: f64,
}

fn one() -> f64 {
    1.0
}

fn callipers() -> f64 {
    CALLIPERS_M
}

/// Reads the folder at `path`. A recording that cannot be used is left out, with its reason.
///
/// # Errors
/// [`LoadError`], when the setup is missing or wrong, or no recording can be used.
pub fn load(path: &Path) -> Result<RecordingSet, LoadError> {
    let setup = read_setup(&path.join("setup.toml"))?;
    let known = Known {
        radius_m: setup.radius_m,
        radius_error_m: setup.radius_error_m,
        fill_m: setup.fill_m,
        density_kg_m3: setup.density_kg_m3,
        viscosity_pa_s: setup.viscosity_pa_s,
        motion_share: [setup.tilt_share, setup.vertical_share],
    };
    let listed = std::fs::read_dir(path).map_err(|cause| LoadError::List { path: path.into(), cause })?;
    let mut names: Vec<String> = listed
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter_map(|name| MEASURED.iter().find_map(|ending| name.strip_suffix(ending)).map(String::from))
        .collect();
    names.sort();
    names.dedup();
    let (mut records, mut left_out) = (Vec::new(), Vec::new());
    for name in names {
        match recording(path, &name, &known) {
            Ok(record) => records.push(record),
            Err(reason) => left_out.push(reason),
        }
    }
    if records.is_empty() {
        return Err(LoadError::NoRecording { path: path.into(), left_out });
    }
    Ok(RecordingSet { known, own_clocks: setup.own_clocks, records, left_out })
}

/// Reads the references at `path`: a folder of recordings of a known liquid, or a folder of such folders.
///
/// # Errors
/// [`LoadError`], when there is no such folder or one of them cannot be used.
pub fn load_references(path: &Path) -> Result<Vec<RecordingSet>, LoadError> {
    if path.join("setup.toml").exists() {
        return Ok(vec![load(path)?]);
    }
    let listed = std::fs::read_dir(path).map_err(|cause| LoadError::List { path: path.into(), cause })?;
    let mut folders: Vec<PathBuf> = listed
        .filter_map(|entry| entry.ok().map(|entry| entry.path()))
        .filter(|folder| folder.join("setup.toml").exists())
        .collect();
    folders.sort();
    if folders.is_empty() {
        return Err(LoadError::NoReferences { path: path.into() });
    }
    folders.iter().map(|folder| load(folder)).collect()
}

/// Reads and checks setup.toml.
fn read_setup(path: &Path) -> Result<Setup, LoadError> {
    let text =
        std::fs::read_to_string(path).map_err(|cause| LoadError::ReadSetup { path: path.into(), cause })?;
    let line = |error: &toml::de::Error| {
        let start = error.span().map_or(0, |span| span.start.min(text.len()));
        1 + text[..start].matches('\n').count()
    };
    let setup: Setup = toml::from_str(&text).map_err(|error| {
        let fault = format!("line {}: {}", line(&error), error.message());
        LoadError::Setup { path: path.into(), fault }
    })?;
    for (name, value, range) in [
        ("radius_m", setup.radius_m, 0.005..=0.5),
        ("radius_error_m", setup.radius_error_m, 1e-6..=0.01),
        ("fill_m", setup.fill_m, 0.005..=1.0),
        ("density_kg_m3", setup.density_kg_m3, 100.0..=20_000.0),
        ("viscosity_pa_s", setup.viscosity_pa_s, 1e-5..=100.0),
    ] {
        if !range.contains(&value) {
            let range = (*range.start(), *range.end());
            return Err(LoadError::OutOfRange { path: path.into(), name, value, range });
        }
    }
    Ok(setup)
}

/// Reads the recording `name` of `folder`.
fn recording(folder: &Path, name: &str, known: &Known) -> Result<Record, RecordingError> {
    let (interval_s, channels) = measurement(folder, name, known)?;
    let frames = channels[0].value.len();
    let seconds = frames as f64 * interval_s;
    let pose = folder.join(format!("{name}.pose.csv"));
    let (drive, length_s) = if pose.exists() {
        poses(&read(&pose)?).map_err(|fault| in_table(&pose.display().to_string(), fault))?
    } else {
        moved(&folder.join(format!("{name}.motion.csv")), seconds)?
    };
    same_clock(name, interval_s, &channels, &drive)?;
    // A glass that has come to rest may be left out of a motion; one that still moves may not.
    let end = ((length_s * drive.rate_hz) as usize).min(drive.along_m_s2.len());
    let last = &drive.along_m_s2[end.saturating_sub(6)..end];
    let ends_moving = last.iter().flatten().any(|a| a.abs() > 0.2);
    if length_s < seconds - 0.5 && ends_moving {
        return Err(RecordingError::MotionEndsEarly {
            recording: name.into(),
            motion_s: length_s,
            recording_s: seconds,
        });
    }
    channels.iter().try_for_each(|channel| measured(name, channel))?;
    let moves = |t: f64| {
        let (along, tilted, lift, _) = drive.at(t);
        along.iter().chain(&tilted).any(|a| a.abs() > MOVED_M_S2) || lift.abs() > MOVED_M_S2
    };
    let rest_frames = (0..frames).take_while(|n| !moves(*n as f64 * interval_s + 0.5 * interval_s)).count();
    if rest_frames < LEAST_REST {
        return Err(RecordingError::NoRest {
            recording: name.into(),
            frames: rest_frames,
            least: LEAST_REST,
        });
    }
    if rest_frames == frames {
        return Err(RecordingError::NoMotion { recording: name.into() });
    }
    Ok(Record { name: name.into(), interval_s, channels, drive, rest_frames })
}

/// Returns the interval of the frames, s, and the channels of the recording `name`.
fn measurement(folder: &Path, name: &str, known: &Known) -> Result<(f64, Vec<Channel>), RecordingError> {
    let peak = folder.join(format!("{name}.peak.csv"));
    if peak.exists() {
        return peaks(&read(&peak)?).map_err(|fault| in_table(&peak.display().to_string(), fault));
    }
    let points = folder.join(format!("{name}.gauges.csv"));
    if points.exists() {
        return gauges::read(&read(&points)?, known.radius_m, known.fill_m)
            .map_err(|fault| in_table(&points.display().to_string(), fault));
    }
    let file = format!("{name}.profile.csv");
    profiles(&read(&folder.join(&file))?, known.fill_m).map_err(|fault| in_table(&file, fault))
}

fn read(path: &Path) -> Result<String, RecordingError> {
    std::fs::read_to_string(path).map_err(|cause| RecordingError::Read { path: path.into(), cause })
}

fn in_table(file: &str, fault: TableError) -> RecordingError {
    RecordingError::Table { file: file.into(), fault }
}

/// Refuses a channel that is missing in most frames, or never changes.
fn measured(recording: &str, channel: &Channel) -> Result<(), RecordingError> {
    let (recording, name) = (String::from(recording), channel.quantity.words());
    let values: Vec<f64> = channel.value.iter().flatten().copied().collect();
    let (least, largest) = values.iter().fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(*x), b.max(*x)));
    // A glass may stand still in the image.
    if channel.quantity != Quantity::Place && largest - least <= 0.0 {
        return Err(RecordingError::Constant { recording, channel: name });
    }
    let frames = channel.value.len();
    if values.len() < frames / 3 {
        return Err(RecordingError::HardlySeen { recording, channel: name, seen: values.len(), frames });
    }
    Ok(())
}

/// Refuses a recording in which the tracked glass moves at another time than its motion file.
fn same_clock(
    name: &str,
    interval_s: f64,
    channels: &[Channel],
    drive: &Drive,
) -> Result<(), RecordingError> {
    let Some(place) = channels.iter().find(|channel| channel.quantity == Quantity::Place) else {
        return Ok(());
    };
    let seen: Vec<(f64, f64)> =
        place.value.iter().zip(0..).filter_map(|(x, n)| x.map(|x| (f64::from(n) * interval_s, x))).collect();
    let (least, largest) =
        drive.place_m.iter().fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(*x), b.max(*x)));
    if largest - least < 1e-3 {
        return Ok(());
    }
    let apart = |late: f64| seen.iter().map(|(t, x)| (x - drive.at(t - late).3).powi(2)).sum::<f64>();
    let steps = (MAX_SHIFT_S / interval_s) as i32;
    let tried = (-steps..=steps).map(|n| f64::from(n) * interval_s).map(|late| (apart(late), late));
    match tried.min_by(|a, b| a.0.total_cmp(&b.0)) {
        Some((cost, late_s)) if late_s.abs() > MIN_SHIFT_S && cost < 0.1 * apart(0.0) => {
            Err(RecordingError::OtherClock { recording: name.into(), late_s })
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests;
