//! Folders of recordings: a setup, and for each recording a measurement and a motion.
//!
//! ```text
//! DIR/setup.toml          glass, liquid, what is measured          (see docs/formats.md)
//! DIR/NAME.profile.csv    profiles of the camera, as `meniscus record` writes them; or
//! DIR/NAME.peak.csv       time_s,peak_height_above_rest_mm
//! DIR/NAME.motion.csv     the motion of the glass, as `meniscus simulate --motion` takes it; or
//! DIR/NAME.pose.csv       t;x;y;z;qx;qy;qz;qw without heading, m, robot poses
//! ```

use super::predict::Known;
use super::record::{Channel, InputSource, Quantity, Record};
use crate::motion_table::{moved, peaks, poses, profiles};
use serde::Deserialize;
use std::path::Path;

/// Acceleration from which the glass counts as moved, m/s2.
const MOVED_M_S2: f64 = 0.02;

/// Frames of rest without which the noise is not known.
pub const LEAST_REST: usize = 8;

/// Shifts between the clocks of camera and motion that are looked for, s, and the least that is refused: more
/// than any latency or delay that is an effect.
const CLOCKS_S: f64 = 3.0;
const APART_S: f64 = 0.25;

/// A folder of recordings of one liquid.
#[derive(Clone, Debug)]
pub struct Folder {
    /// What is known.
    pub known: Known,
    /// Whether every recording has a clock of its own.
    pub own_clocks: bool,
    /// The recordings, by name.
    pub records: Vec<Record>,
    /// What was left out, and why.
    pub left_out: Vec<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Setup {
    radius_m: f64,
    fill_m: f64,
    density_kg_m3: f64,
    viscosity_pa_s: f64,
    #[serde(default)]
    own_clocks: bool,
    #[serde(default = "one")]
    tilt_told: f64,
    #[serde(default = "one")]
    vertical_told: f64,
}

fn one() -> f64 {
    1.0
}

/// Reads the folder at `path`. A recording that cannot be used is left out, and said so.
///
/// # Errors
/// In words: when the setup is not there or wrong, or no recording can be used.
pub fn load(path: &Path) -> Result<Folder, String> {
    let file = path.join("setup.toml");
    let text = std::fs::read_to_string(&file)
        .map_err(|e| format!("{}: {e}; docs/formats.md says what it holds", file.display()))?;
    let setup: Setup =
        toml::from_str(&text).map_err(|e| format!("{} is not a setup: {}", file.display(), e.message()))?;
    for (name, value, range) in [
        ("radius_m", setup.radius_m, 0.005..=0.5),
        ("fill_m", setup.fill_m, 0.005..=1.0),
        ("density_kg_m3", setup.density_kg_m3, 100.0..=20_000.0),
        ("viscosity_pa_s", setup.viscosity_pa_s, 1e-5..=100.0),
    ] {
        if !range.contains(&value) {
            return Err(format!(
                "{}: {name} = {value} is out of range: {} to {}",
                file.display(),
                range.start(),
                range.end()
            ));
        }
    }
    let known = Known {
        radius_m: setup.radius_m,
        fill_m: setup.fill_m,
        density_kg_m3: setup.density_kg_m3,
        viscosity_pa_s: setup.viscosity_pa_s,
        told: [setup.tilt_told, setup.vertical_told],
    };
    let mut names: Vec<String> = std::fs::read_dir(path)
        .map_err(|e| format!("{}: {e}", path.display()))?
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter_map(|name| {
            name.strip_suffix(".profile.csv").or_else(|| name.strip_suffix(".peak.csv")).map(String::from)
        })
        .collect();
    names.sort();
    names.dedup();
    let (mut records, mut left_out) = (Vec::new(), Vec::new());
    for name in names {
        match recording(path, &name, known.fill_m) {
            Ok(record) => records.push(record),
            Err(why) => left_out.push(why),
        }
    }
    if records.is_empty() {
        let why = if left_out.is_empty() {
            String::from("there is no NAME.profile.csv or NAME.peak.csv in it")
        } else {
            left_out.join("; ")
        };
        return Err(format!("no recording in {} can be used: {why}", path.display()));
    }
    Ok(Folder { known, own_clocks: setup.own_clocks, records, left_out })
}

fn recording(folder: &Path, name: &str, fill_m: f64) -> Result<Record, String> {
    let read = |end: &str| {
        let path = folder.join(format!("{name}.{end}.csv"));
        std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))
    };
    let peak = folder.join(format!("{name}.peak.csv"));
    let (interval_s, channels) = if peak.exists() {
        peaks(&read("peak")?).map_err(|why| format!("{}: {why}", peak.display()))?
    } else {
        profiles(&read("profile")?, fill_m).map_err(|why| format!("{name}.profile.csv: {why}"))?
    };
    let frames = channels[0].value.len();
    let seconds = frames as f64 * interval_s;
    let pose = folder.join(format!("{name}.pose.csv"));
    let (drive, length_s) = if pose.exists() {
        poses(&read("pose")?).map_err(|why| format!("{}: {why}", pose.display()))?
    } else {
        let path = folder.join(format!("{name}.motion.csv"));
        moved(&path, seconds)?
    };
    same_clock(name, interval_s, &channels, &drive)?;
    // A glass that has come to rest may be left out of a motion; one that still moves may not.
    let end = ((length_s * drive.rate_hz) as usize).min(drive.along_m_s2.len());
    let last = &drive.along_m_s2[end.saturating_sub(6)..end];
    let ends_moving = last.iter().flatten().any(|a| a.abs() > 0.2);
    if length_s < seconds - 0.5 && ends_moving {
        return Err(format!(
            "{name}: the motion ends at {length_s:.2} s while the glass moves, the recording at {seconds:.2} s: \
             give both over the same time and on the same clock"
        ));
    }
    for channel in &channels {
        let seen: Vec<f64> = channel.value.iter().flatten().copied().collect();
        let (least, largest) = seen.iter().fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(*x), b.max(*x)));
        let same = channel.quantity != Quantity::Place && largest - least <= 0.0;
        if seen.len() < frames / 3 || same {
            return Err(format!(
                "{name}: the {} {}",
                channel.quantity.words(),
                if same {
                    "never changes, not even by noise: is this a measurement?"
                } else {
                    "was hardly ever seen"
                }
            ));
        }
    }
    let moves = |t: f64| {
        let (along, tilted, lift, _) = drive.at(t);
        along.iter().chain(&tilted).any(|a| a.abs() > MOVED_M_S2) || lift.abs() > MOVED_M_S2
    };
    let rest_frames = (0..frames).take_while(|n| !moves(*n as f64 * interval_s + 0.5 * interval_s)).count();
    if rest_frames < LEAST_REST {
        return Err(format!(
            "{name}: the glass rests for only {rest_frames} frames at the start; {LEAST_REST} are needed to learn \
             the noise: begin the recording half a second before the motion"
        ));
    }
    if rest_frames == frames {
        return Err(format!("{name}: the glass never moves; a motion is needed to see any effect"));
    }
    Ok(Record { name: name.into(), interval_s, channels, drive, rest_frames })
}

/// Refuses a recording in which the glass is seen to move at another time than its motion says.
fn same_clock(name: &str, interval_s: f64, channels: &[Channel], drive: &InputSource) -> Result<(), String> {
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
    let steps = (CLOCKS_S / interval_s) as i32;
    let tried = (-steps..=steps).map(|n| f64::from(n) * interval_s).map(|late| (apart(late), late));
    match tried.min_by(|a, b| a.0.total_cmp(&b.0)) {
        Some((cost, late)) if late.abs() > APART_S && cost < 0.1 * apart(0.0) => Err(format!(
            "{name}: the glass is seen to move {:.2} s {} than its motion says: give both on the same clock, from the \
             first frame on",
            late.abs(),
            if late > 0.0 { "later" } else { "earlier" }
        )),
        _ => Ok(()),
    }
}
