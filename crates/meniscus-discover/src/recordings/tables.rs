//! The tables of a folder of recordings: profiles, peak heights, motions, poses.

use super::error::{RecordingError, TableError};
use super::record::{Channel, Drive, Quantity, channels};
use meniscus::units::{FRAME_INTERVAL_S, GRAVITY_M_S2};
use meniscus_data::motion::Motion;
use meniscus_data::profiles::profiles_from_csv;
use std::path::Path;

/// Samples of a drive per second.
const RATE_HZ: f64 = 240.0;

/// Fewest rows or frames of a measurement: half a second at 60 Hz.
const LEAST_ROWS: usize = 30;

/// Most frames of a measurement: ten minutes at 60 Hz.
const MOST_FRAMES: usize = 36_000;

/// Fewest poses of a motion.
const LEAST_POSES: usize = 50;

/// Returns the interval, s, and the channels of a table of profiles, frame by frame from the first.
pub(super) fn profiles(text: &str, fill_m: f64) -> Result<(f64, Vec<Channel>), TableError> {
    let profiles = profiles_from_csv(text)?;
    let first = profiles.first().ok_or(TableError::Empty)?.captured.0;
    let frame = |us: u64| ((us - first) as f64 * 1e-6 / FRAME_INTERVAL_S).round() as usize;
    let frames = frame(profiles.last().map_or(first, |p| p.captured.0)) + 1;
    let range = (LEAST_ROWS, MOST_FRAMES);
    if !(range.0..=range.1).contains(&frames) {
        return Err(TableError::Span { frames, range });
    }
    let mut slots = vec![None; frames];
    for profile in profiles {
        slots[frame(profile.captured.0)] = Some(profile);
    }
    Ok((FRAME_INTERVAL_S, channels(&slots, fill_m)))
}

/// Returns the interval, s, and the channel of a table of peak heights.
pub(crate) fn peaks(text: &str) -> Result<(f64, Vec<Channel>), TableError> {
    let mut rows: Vec<(f64, f64)> = Vec::new();
    for (line, content) in text.lines().enumerate().map(|(i, l)| (i + 1, l.trim())) {
        if content.is_empty() || (line == 1 && content.starts_with("time_s")) {
            continue;
        }
        let pair =
            content.split_once(',').and_then(|(t, z)| Some((t.trim().parse().ok()?, z.trim().parse().ok()?)));
        let (t, z): (f64, f64) = pair.ok_or_else(|| TableError::Columns {
            line,
            expected: "time_s,peak_height_above_rest_mm",
            found: content.into(),
        })?;
        if !t.is_finite() || !z.is_finite() || rows.last().is_some_and(|(last, _)| t <= *last) {
            return Err(TableError::Sequence { line, found: content.into() });
        }
        rows.push((t, z));
    }
    if rows.len() < LEAST_ROWS {
        return Err(TableError::TooShort { rows: rows.len(), unit: "rows", least: LEAST_ROWS });
    }
    let interval_s = (rows[rows.len() - 1].0 - rows[0].0) / (rows.len() - 1) as f64;
    let range_s = (1e-3, 0.1);
    if !(range_s.0..range_s.1).contains(&interval_s) {
        return Err(TableError::Interval { interval_s, range_s });
    }
    let value = rows.iter().map(|(_, z)| Some(1e-3 * z)).collect();
    Ok((interval_s, vec![Channel { quantity: Quantity::Peak, value }]))
}

/// Returns the drive of a motion file and its length, s.
pub(super) fn moved(path: &Path, seconds: f64) -> Result<(Drive, f64), RecordingError> {
    let motion = Motion::parse(&path.to_string_lossy(), seconds)?;
    let first_s = motion.start_s();
    if first_s > seconds {
        return Err(RecordingError::MotionStartsLate {
            path: path.into(),
            starts_s: first_s,
            ends_s: seconds,
        });
    }
    Ok((drive_of(&motion, seconds), motion.end_s()))
}

/// Returns the drive of `motion` over `seconds`.
#[must_use]
pub fn drive_of(motion: &Motion, seconds: f64) -> Drive {
    let samples = (seconds * RATE_HZ).ceil() as usize + 2;
    let at = |n: usize| n as f64 / RATE_HZ;
    let of = |n: usize| {
        let k = motion.kinematics(at(n));
        let [ax, ay, az] = k.acceleration_m_s2;
        let (sin, cos) = k.tilt_rad.sin_cos();
        // Towards +x inclined: gravity pulls along the surface towards +x.
        ([-ax, -ay], [(GRAVITY_M_S2 + az) * sin - ax * (cos - 1.0), 0.0], az)
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

/// Returns the drive of a table of robot poses and its length, s.
///
/// With the axis n of the glass in the room and the specific force `f = -a - g e_z`, the liquid feels
/// `f - (f.n) n` along its surface and `-f.n` across it. A turn of the glass about its axis leaves the
/// liquid where it is.
pub(crate) fn poses(text: &str) -> Result<(Drive, f64), TableError> {
    let mut rows: Vec<[f64; 8]> = Vec::new();
    for (line, content) in text.lines().enumerate().map(|(i, l)| (i + 1, l.trim())) {
        if content.is_empty() {
            continue;
        }
        let numbers: Vec<f64> = content.split(';').map_while(|n| n.trim().parse().ok()).collect();
        let row: [f64; 8] = numbers.try_into().map_err(|_| TableError::Columns {
            line,
            expected: "t;x;y;z;qx;qy;qz;qw",
            found: content.into(),
        })?;
        if row.iter().any(|x| !x.is_finite()) {
            return Err(TableError::NotFinite { line, found: content.into() });
        }
        rows.push(row);
    }
    if rows.len() < LEAST_POSES {
        return Err(TableError::TooShort { rows: rows.len(), unit: "poses", least: LEAST_POSES });
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
