//! Validation recordings as the rendered camera sees them.

use meniscus::surface::{ConfigError, SurfaceProfile};
use meniscus_data::recording::Recording;
use meniscus_virtual::observe_recording::{DISPARITY_RMS_PX, sightings};
use meniscus_virtual::render::SceneSettings;

/// A recording and the profiles that the camera saw of it.
pub(crate) type CameraView<'r> = (&'r Recording, Vec<Option<SurfaceProfile>>);

/// Returns `recordings` as the camera sees them with `times` the noise that estimates are judged by, 2 mm of depth.
///
/// # Errors
/// [`ConfigError`], when the glass of a recording cannot be seen.
pub(crate) fn camera_views(
    recordings: &[Recording],
    times: f64,
    seed: u64,
) -> Result<Vec<CameraView<'_>>, ConfigError> {
    let disparity_rms_px = times * DISPARITY_RMS_PX;
    let mut all = Vec::new();
    for recording in recordings {
        let scene = SceneSettings { disparity_rms_px, seed, ..SceneSettings::of(&recording.glass) };
        all.push((recording, sightings(recording, scene)?));
    }
    Ok(all)
}
