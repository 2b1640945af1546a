//! Profiles of path-traced scenes against their contact lines.

use super::degrade::{Faults, degrade};
use super::set::{TracedScene, settings};
use crate::camera_study::judge::Point;
use meniscus::surface::{
    Config, ConfigError, ExtractionError, ExtractionState, POINTS, Settings, Tally, extract,
};
use meniscus::units::Micros;
use meniscus::usb::frame::{DepthFrame, OutlineFrame, Stamp};

/// Noisy frames that are made of each render.
pub const FRAMES: u64 = 4;

/// Reading of a scene, or of several frames.
#[derive(Clone, Debug)]
pub struct Read {
    /// Name of the scene, or of the last frame.
    pub name: String,
    /// Frames that gave a profile.
    pub profiles: u32,
    /// All points seen, with their errors.
    pub points: Vec<Point>,
    /// Mean error of the glass position, millimetres.
    pub axis_bias_mm: f64,
    /// Counters of the stages.
    pub tally: Tally,
    /// Why the last frame without a profile had none.
    pub not_seen: Option<ExtractionError>,
}

/// Reads [`FRAMES`] frames of a scene under these faults; `adjust` changes the reader's settings.
///
/// # Errors
/// [`ConfigError`], when `adjust` makes settings that no reader takes.
pub fn read_scene(
    scene: &TracedScene,
    faults: &Faults,
    adjust: &dyn Fn(Settings) -> Settings,
) -> Result<Read, ConfigError> {
    read_frames(adjust(settings(&scene.truth)), std::iter::repeat_n(scene, FRAMES as usize), faults)
}

/// Reads frames one after the other with the same settings, as a camera's of one glass.
///
/// # Errors
/// [`ConfigError`], when no reader takes the settings.
pub fn read_frames<'s>(
    settings: Settings,
    frames: impl IntoIterator<Item = &'s TracedScene>,
    faults: &Faults,
) -> Result<Read, ConfigError> {
    let config = Config::new(settings)?;
    let (width, height) = config.image_size();
    let mut state = ExtractionState::new();
    let (mut name, mut points, mut axes, mut not_seen) = (String::new(), Vec::new(), Vec::new(), None);
    for (frame, scene) in (0..).zip(frames) {
        name.clone_from(&scene.truth.name);
        let pair = degrade(scene, width, faults, frame);
        let stamp = Stamp { sequence: frame as u32, captured: Micros(frame * 16_667) };
        let depth = DepthFrame { bytes: &pair.depth, width, height, stamp };
        let infrared = OutlineFrame { bytes: &pair.infrared, width, height, stamp };
        match extract(&config, &mut state, depth, infrared) {
            Ok(profile) => {
                axes.extend(profile.glass_x_m.map(|x_m| 1e3 * f64::from(x_m) - scene.truth.axis_mm));
                points.extend((0..POINTS).filter_map(|i| {
                    let half_mm = 1e3 * f64::from(profile.interval_m(i)?);
                    let error_mm = 1e3 * f64::from(profile.height_m[i]) - scene.truth.contact_line_mm[i];
                    Some(Point { error_mm, half_mm })
                }));
            }
            Err(why) => not_seen = Some(why),
        }
    }
    let axis_bias_mm = axes.iter().sum::<f64>() / axes.len() as f64;
    let tally = state.tally();
    Ok(Read { name, profiles: tally.profiles, points, axis_bias_mm, tally, not_seen })
}
