//! Measured recordings: profiles of the free surface and the motion of the glass, of a camera or of the simulator.

use crate::error::RelearnError;
use meniscus::blob::CRC;
use meniscus::surface::SurfaceProfile;
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_data::glass::{Glass, WallShape};
use meniscus_data::motion::Motion;
use meniscus_data::profiles::profiles_from_csv;
use meniscus_data::recording::Recording;
use meniscus_discover::recordings::load::RecordingSet;
use meniscus_discover::recordings::record::{Quantity, Record, channels};
use meniscus_discover::recordings::stated::Known;
use meniscus_discover::recordings::tables::drive_of;
use meniscus_virtual::observe_recording::sightings;
use meniscus_virtual::render::SceneSettings;
use std::path::Path;

/// Disparity noise with which the camera sees a recording of the simulator, pixels rms: that of a D435.
const DISPARITY_RMS_PX: f64 = 0.08;

/// Acceleration above which the glass counts as moved, m/s2.
const MOVED_M_S2: f64 = 0.02;

/// Shortest time from the first motion to the end, s: three periods of the slosh in a small glass.
const SHORTEST_S: f64 = 1.0;

/// Smallest root mean square of the slope, m: some times the noise of an averaged profile.
const STILL_M: f64 = 3e-4;

/// Measured recording.
#[derive(Clone, Debug)]
pub struct MeasuredRecording {
    /// Profiles, frame by frame.
    pub profiles: Vec<Option<SurfaceProfile>>,
    /// Channels and motion, as discovery uses them.
    pub record: Record,
    /// Checksum of the profiles.
    pub checksum: u32,
}

impl MeasuredRecording {
    /// Recording of the simulator as a simulated camera sees it, with the true motion; `seed` draws the camera's noise.
    ///
    /// # Errors
    /// [`RelearnError::Unusable`] or [`RelearnError::Camera`].
    pub fn seen(name: &str, recording: &Recording, seed: u64) -> Result<Self, RelearnError> {
        let scene =
            SceneSettings { disparity_rms_px: DISPARITY_RMS_PX, seed, ..SceneSettings::of(&recording.glass) };
        let profiles = sightings(recording, scene)?;
        let samples: Vec<(f64, f64)> =
            (0..).map(|n| f64::from(n) * FRAME_INTERVAL_S).zip(recording.glass_x_m.iter().copied()).collect();
        let motion = Motion::sampled(&samples)
            .ok_or_else(|| unusable(name, "it has fewer than two frames: give a longer recording"))?;
        let seconds = recording.frames() as f64 * FRAME_INTERVAL_S;
        let record = Record {
            name: name.into(),
            interval_s: FRAME_INTERVAL_S,
            channels: channels(&profiles, recording.glass.fill_m),
            drive: drive_of(&motion, seconds),
            rest_frames: 0,
        };
        Self::new(profiles, record)
    }

    /// Recordings of `set`, which was read from `folder`, with the profiles of their tables.
    ///
    /// # Errors
    /// [`RelearnError::Unusable`].
    pub fn of_set(folder: &Path, set: &RecordingSet) -> Result<Vec<Self>, RelearnError> {
        let one = |record: &Record| {
            let path = folder.join(format!("{}.profile.csv", record.name));
            let text = std::fs::read_to_string(&path).map_err(|_| {
                unusable(
                    &record.name,
                    "a model is learnt from profiles: it needs a .profile.csv, not peak heights",
                )
            })?;
            let all = profiles_from_csv(&text).map_err(|error| unusable(&record.name, &error.to_string()))?;
            let first = all.first().map_or(0, |profile| profile.captured.0);
            let mut profiles = vec![None; record.frames()];
            for profile in all {
                let time_s = profile.captured.0.saturating_sub(first) as f64 * 1e-6;
                if let Some(slot) = profiles.get_mut((time_s / FRAME_INTERVAL_S).round() as usize) {
                    *slot = Some(profile);
                }
            }
            Self::new(profiles, record.clone())
        };
        set.records.iter().map(one).collect()
    }

    /// Glass of the recordings of `known` with a rim at `rim_m`.
    #[must_use]
    pub fn glass(known: &Known, rim_m: f64) -> Glass {
        Glass { radius_m: known.radius_m, fill_m: known.fill_m, rim_m, wall: WallShape::UPRIGHT }
    }

    /// Checks what was measured, and counts the frames before the motion.
    fn new(profiles: Vec<Option<SurfaceProfile>>, mut record: Record) -> Result<Self, RelearnError> {
        let name = record.name.clone();
        let frames = record.frames();
        let moves = |frame: usize| {
            let (along, ..) = record.drive.at((frame as f64 + 0.5) * record.interval_s);
            along.iter().any(|a| a.abs() > MOVED_M_S2)
        };
        record.rest_frames = (0..frames).take_while(|frame| !moves(*frame)).count();
        let moving_s = (frames - record.rest_frames) as f64 * record.interval_s;
        if moving_s < SHORTEST_S {
            let fault = format!(
                "it shows the liquid for {moving_s:.2} s after the glass begins to move, {SHORTEST_S} s are needed: give \
                 a longer recording"
            );
            return Err(unusable(&name, &fault));
        }
        let slope = record.channels.iter().find(|channel| channel.quantity == Quantity::Slope);
        let values: Vec<f64> =
            slope.iter().flat_map(|c| c.value.iter().skip(record.rest_frames)).flatten().copied().collect();
        if values.len() < (frames - record.rest_frames) / 2 {
            let seen = values.len();
            let fault =
                format!("the surface is seen in only {seen} of {frames} frames: check the camera's position");
            return Err(unusable(&name, &fault));
        }
        let rms = (values.iter().map(|x| x * x).sum::<f64>() / values.len().max(1) as f64).sqrt();
        if rms < STILL_M {
            let fault = format!(
                "the surface tilts by only {:.2} mm rms, {:.1} mm are needed: move the glass further or faster",
                1e3 * rms,
                1e3 * STILL_M
            );
            return Err(unusable(&name, &fault));
        }
        let mut digest = CRC.digest();
        for profile in profiles.iter().flatten() {
            profile.height_m.iter().for_each(|height| digest.update(&height.to_le_bytes()));
        }
        let checksum = digest.finalize();
        Ok(Self { profiles, record, checksum })
    }
}

fn unusable(recording: &str, fault: &str) -> RelearnError {
    RelearnError::Unusable { recording: recording.into(), fault: fault.into() }
}
