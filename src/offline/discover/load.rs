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
use super::record::{Channel, Drive, Quantity, Record, channels};
use crate::host::bag::profiles_from_csv;
use crate::offline::motion::Motion;
use crate::offline::prelude::*;
use crate::units::{FRAME_INTERVAL_S, GRAVITY_M_S2};
use serde::Deserialize;
use std::path::Path;

/// Samples of a drive a second.
const RATE_HZ: f64 = 240.0;

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

/// The channels of a table of profiles, frame by frame from the first.
fn profiles(text: &str, fill_m: f64) -> Result<(f64, Vec<Channel>), String> {
    let profiles = profiles_from_csv(text).map_err(|error| format!("{error}"))?;
    let first = profiles.first().ok_or("it is empty")?.captured.0;
    let frame = |us: u64| ((us - first) as f64 * 1e-6 / FRAME_INTERVAL_S).round() as usize;
    let frames = frame(profiles.last().map_or(first, |p| p.captured.0)) + 1;
    if !(30..=36_000).contains(&frames) {
        return Err(format!("it spans {frames} frames; 30 to 36000 can be used"));
    }
    let mut slots = vec![None; frames];
    for profile in profiles {
        slots[frame(profile.captured.0)] = Some(profile);
    }
    Ok((FRAME_INTERVAL_S, channels(&slots, fill_m)))
}

/// The channel of a table of peak heights.
pub(super) fn peaks(text: &str) -> Result<(f64, Vec<Channel>), String> {
    let mut rows: Vec<(f64, f64)> = Vec::new();
    for (line, content) in text.lines().enumerate().map(|(i, l)| (i + 1, l.trim())) {
        if content.is_empty() || (line == 1 && content.starts_with("time_s")) {
            continue;
        }
        let pair =
            content.split_once(',').and_then(|(t, z)| Some((t.trim().parse().ok()?, z.trim().parse().ok()?)));
        let (t, z): (f64, f64) = pair.ok_or_else(|| {
            format!("line {line}: expected 'time_s,peak_height_above_rest_mm', found '{content}'")
        })?;
        if !t.is_finite() || !z.is_finite() || rows.last().is_some_and(|(last, _)| t <= *last) {
            return Err(format!(
                "line {line}: '{content}' is not finite, or its time does not come after the last"
            ));
        }
        rows.push((t, z));
    }
    if rows.len() < 30 {
        return Err(format!("{} rows; at least 30 are needed", rows.len()));
    }
    let interval_s = (rows[rows.len() - 1].0 - rows[0].0) / (rows.len() - 1) as f64;
    if !(1e-3..0.1).contains(&interval_s) {
        return Err(format!("{interval_s:.4} s between rows; 0.001 to 0.1 s can be used"));
    }
    let value = rows.iter().map(|(_, z)| Some(1e-3 * z)).collect();
    Ok((interval_s, vec![Channel { quantity: Quantity::Peak, value }]))
}

/// The drive of a motion file, and how long it is.
fn moved(path: &Path, seconds: f64) -> Result<(Drive, f64), String> {
    let motion = Motion::parse(&path.to_string_lossy(), seconds).map_err(|error| format!("{error}"))?;
    let text = std::fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))?;
    let time = |line: &str| line.split(',').next().and_then(|t| t.trim().parse::<f64>().ok());
    let first_s = text.lines().find_map(time).unwrap_or(0.0);
    if first_s > seconds {
        return Err(format!(
            "{}: it starts at {first_s:.2} s, after the end of the recording at {seconds:.2} s: its time has to start \
             with the recording's first frame",
            path.display()
        ));
    }
    let length_s = text.lines().rev().find_map(time).unwrap_or(0.0);
    Ok((drive_of(&motion, seconds), length_s))
}

/// Refuses a recording in which the glass is seen to move at another time than its motion says.
fn same_clock(name: &str, interval_s: f64, channels: &[Channel], drive: &Drive) -> Result<(), String> {
    let Some(place) = channels.iter().find(|channel| channel.quantity == Quantity::Place) else {
        return Ok(());
    };
    let seen: Vec<(f64, f64)> = place
        .value
        .iter()
        .zip(0..)
        .filter_map(|(x, n)| x.map(|x| (f64::from(n) * interval_s, x)))
        .collect();
    let (least, largest) = drive.place_m.iter().fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(*x), b.max(*x)));
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

/// The drive of `motion` over `seconds`.
#[must_use]
pub fn drive_of(motion: &Motion, seconds: f64) -> Drive {
    let samples = (seconds * RATE_HZ).ceil() as usize + 2;
    let at = |n: usize| n as f64 / RATE_HZ;
    let of = |n: usize| {
        let k = motion.kinematics(at(n));
        let [ax, az] = k.acceleration_m_s2;
        let (sin, cos) = k.tilt_rad.sin_cos();
        // Towards +x inclined: gravity pulls along the surface towards +x.
        ([-ax, 0.0], [(GRAVITY_M_S2 + az) * sin - ax * (cos - 1.0), 0.0], az)
    };
    let all: Vec<_> = (0..samples).map(of).collect();
    Drive {
        rate_hz: RATE_HZ,
        along_m_s2: all.iter().map(|a| a.0).collect(),
        tilted_m_s2: all.iter().map(|a| a.1).collect(),
        lift_m_s2: all.iter().map(|a| a.2).collect(),
        place_m: (0..samples).map(|n| motion.position(at(n))).collect(),
    }
}

/// The drive of a table of robot poses, and how long it is.
///
/// With the axis n of the glass in the room and the specific force `f = -a - g e_z`, the liquid feels
/// `f - (f.n) n` along its surface and `-f.n` across it. A turn of the glass about its axis leaves the
/// liquid where it is.
pub(super) fn poses(text: &str) -> Result<(Drive, f64), String> {
    let mut rows: Vec<[f64; 8]> = Vec::new();
    for (line, content) in text.lines().enumerate().map(|(i, l)| (i + 1, l.trim())) {
        if content.is_empty() {
            continue;
        }
        let numbers: Vec<f64> = content.split(';').map_while(|n| n.trim().parse().ok()).collect();
        let row: [f64; 8] = numbers
            .try_into()
            .map_err(|_| format!("line {line}: expected 't;x;y;z;qx;qy;qz;qw', found '{content}'"))?;
        if row.iter().any(|x| !x.is_finite()) {
            return Err(format!("line {line}: '{content}' is not finite"));
        }
        rows.push(row);
    }
    if rows.len() < 50 {
        return Err(format!("{} poses; at least 50 are needed", rows.len()));
    }
    let length_s = rows[rows.len() - 1][0] - rows[0][0];
    let pose_hz = (rows.len() - 1) as f64 / length_s;
    // The second difference over 20 ms: finer ones are the robot's rounding.
    let reach = ((0.02 * pose_hz).round() as usize).max(1);
    let h = reach as f64 / pose_hz;
    let row = |n: isize| &rows[n.clamp(0, rows.len() as isize - 1) as usize];
    let second = |n: isize, c: usize| {
        (row(n + reach as isize)[c] - 2.0 * row(n)[c] + row(n - reach as isize)[c]) / (h * h)
    };
    let axis = |n: isize| {
        let [_, _, _, _, x, y, z, w] = *row(n);
        let norm = x * x + y * y + z * z + w * w;
        [2.0 * (x * z + w * y) / norm, 2.0 * (y * z - w * x) / norm, 1.0 - 2.0 * (x * x + y * y) / norm]
    };
    let samples = (length_s * RATE_HZ) as usize + 1;
    let mut drive = Drive {
        rate_hz: RATE_HZ,
        along_m_s2: Vec::new(),
        tilted_m_s2: Vec::new(),
        lift_m_s2: Vec::new(),
        place_m: Vec::new(),
    };
    for sample in 0..samples {
        let n = (sample as f64 / RATE_HZ * pose_hz).round() as isize;
        let a = [2, 3].map(|c| second(n, c - 1));
        let up = second(n, 3);
        let [nx, ny, nz] = axis(n);
        let along = [-a[0], -a[1]];
        let across = along[0] * nx + along[1] * ny - (GRAVITY_M_S2 + up) * nz;
        drive.along_m_s2.push(along);
        drive.tilted_m_s2.push([-across * nx, -across * ny]);
        drive.lift_m_s2.push(up);
        drive.place_m.push(row(n)[1] - rows[0][1]);
    }
    Ok((drive, length_s))
}
