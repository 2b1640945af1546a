//! Observations of a recording by a simulated camera, frame by frame and without waiting for real time.
//!
//! ```text
//! recording --renderer--> Z16 + Y8 --wire--> payloads --runtime::ProfileSensor--> profile (or "not seen")
//! ```
//! The path is that of `meniscus run`; only the clock is missing. The result is all that a
//! correction may see: the free surface and the position of the glass.

use super::camera::{START, SimulatedCamera};
use crate::render::SceneSettings;
use meniscus::blob::Model;
use meniscus::runtime::{Estimate, Estimator, InputSource, Memory, ProfileSensor, Turn, TurnInput};
use meniscus::surface::{Config, ConfigError, SurfaceProfile};
use meniscus::units::{FRAME_INTERVAL_S, Micros};
use meniscus_data::recording::Recording;
use meniscus_data::recording::frame_of;
use meniscus_hil::FaultList;
use meniscus_platform::clock::NoClock;
use meniscus_service::timed_turn::TimedTurn;

/// Noise of the disparity that makes 2 mm of depth at 0.4 m, pixels rms: `s = dz f B / z^2`.
pub const DISPARITY_RMS_PX: f64 = 0.24;

/// The profile of every frame of `recording` as a camera sees it under `scene`; `None` where there was
/// no frame or no liquid was seen.
///
/// # Errors
/// [`ConfigError`], when the glass or the camera of `scene` cannot be.
pub fn sightings(
    recording: &Recording,
    scene: SceneSettings,
) -> Result<Vec<Option<SurfaceProfile>>, ConfigError> {
    let config = Config::new(scene.camera)?;
    let (width, height) = config.image_size();
    let (mut depth, mut infrared) = (vec![0; 2 * width * height], vec![0; width * height]);
    let mut sensor = ProfileSensor::new(config, &mut depth, &mut infrared);
    let mut seen = vec![None; recording.frames()];
    SimulatedCamera::new(recording, scene, FaultList::default()).send_all(|stream, payload| {
        if let Some(observation) = sensor.accept(stream, payload, &mut NoClock)
            && let Some(place) = seen.get_mut(frame_of(observation.stamp.captured, START))
        {
            *place = observation.profile.ok();
        }
    });
    Ok(seen)
}

/// Returns profiles without a camera: every point seen, the position of the glass known.
#[must_use]
pub fn perfect(recording: &Recording) -> Vec<Option<SurfaceProfile>> {
    let profile = |frame: usize| {
        let mut profile = SurfaceProfile {
            height_m: [0.0; meniscus::surface::POINTS],
            variance_m2: [0.0; meniscus::surface::POINTS],
            valid: [true; meniscus::surface::POINTS],
            glass_x_m: Some(recording.glass_x_m[frame] as f32),
            sequence: frame as u32,
            captured: time_of(frame),
        };
        profile.height_m.copy_from_slice(recording.profile(frame));
        Some(profile)
    };
    (0..recording.frames()).map(profile).collect()
}

/// The turns of `model` over `seen`, as a run would log them.
#[must_use]
pub fn turns(model: &Model<'_>, seen: &[Option<SurfaceProfile>]) -> Vec<TimedTurn> {
    turns_with(model, seen, |_| InputSource::Tracked, |_, _, _| {})
}

/// The same with the motion of each frame from `drive`; after each turn `look` gets its frame, what the
/// estimator remembers, and the estimate.
pub fn turns_with(
    model: &Model<'_>,
    seen: &[Option<SurfaceProfile>],
    drive: impl Fn(usize) -> InputSource,
    mut look: impl FnMut(usize, &Memory, &Estimate),
) -> Vec<TimedTurn> {
    let estimator = Estimator::new(model);
    let mut memory = Memory::default();
    let turn = |(frame, profile): (usize, &Option<SurfaceProfile>)| {
        let input = TurnInput { profile: profile.as_ref(), source: drive(frame), surface_us: 0 };
        let estimate = estimator.turn(&mut memory, input, &mut NoClock, &mut []);
        look(frame, &memory, &estimate);
        let turn = Turn { time: time_of(frame), stamp: None, profile: profile.map(Ok), estimate };
        TimedTurn::untimed(turn)
    };
    seen.iter().enumerate().map(turn).collect()
}

/// Capture time of a frame.
fn time_of(frame: usize) -> Micros {
    Micros(START.0 + (frame as f64 * FRAME_INTERVAL_S * 1e6).round() as u64)
}
