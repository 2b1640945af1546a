//! Profiles of a camera's recording, frame by frame and without waiting for real time.

use crate::replay::payload;
use crate::{BagError, Recording};
use meniscus::runtime::ProfileSensor;
use meniscus::surface::{Config, SurfaceProfile};
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_platform::clock::NoClock;

/// Frames in an hour.
const LONGEST: usize = 216_000;

/// Returns the profile of every frame interval of a camera's recording, from its first pair of images on; `None` where
/// there was no pair or no liquid was seen. At most an hour is read.
///
/// # Errors
/// [`BagError`], when the recording cannot be read to its end.
pub fn observe_images(recording: Recording, config: Config) -> Result<Vec<Option<SurfaceProfile>>, BagError> {
    let size = recording.calibration.size;
    let (width, height) = config.image_size();
    // Two images of each: a stream may lag by a frame.
    let (mut depth, mut infrared) = (vec![0; 4 * width * height], vec![0; 2 * width * height]);
    let mut sensor = ProfileSensor::new(config, &mut depth, &mut infrared);
    let (mut seen, mut first) = (Vec::new(), None);
    for image in recording.images {
        let image = image?;
        let Some(observation) = sensor.accept(image.stream, &payload(&image, size), &mut NoClock) else {
            continue;
        };
        let captured = observation.stamp.captured;
        let since_s = captured.since(*first.get_or_insert(captured)) as f64 * 1e-6;
        let frame = (since_s / FRAME_INTERVAL_S).round() as usize;
        if frame >= LONGEST {
            break;
        }
        if frame >= seen.len() {
            seen.resize(frame + 1, None);
        }
        seen[frame] = observation.profile.ok();
    }
    Ok(seen)
}
