//! The whole way from a pair of images to a profile.

use super::apart;
use super::binarise::Threshold;
use super::config::Config;
use super::depth::place;
use super::edge_points::{Edge, Samples};
use super::glass::{self, Silhouette, Tracked};
use super::hidden;
use super::outcome::{ExtractionError, Tally};
use super::profile::SurfaceProfile;
use super::refraction::GlassWall;
use super::region::{Grey, Region};
use super::resample::{Points, resample};
use super::settings::Liquid;
use super::trace::trace;
use super::wall_sample::{Glass, at_stated_distance};
use crate::usb::frame::{DepthFrame, OutlineFrame, Stamp};
use heapless::Vec;

/// Thickest wall that is measured rather than stated, metres: drinking glasses have 1 to 4 mm.
const THICKEST_MEASURED_M: f32 = 0.0045;

/// Fewest edge points that make a profile.
const LEAST_COLUMNS: usize = 20;
/// Rows between the lowest edge point and the rows that place the glass.
const CLEARANCE_ROWS: usize = 4;

/// Memory between frames, and the room in which the stages work (about 6 kB; no allocation).
///
/// ```
/// use meniscus::surface::{Config, Settings, ExtractionState};
///
/// let config = Config::new(Settings::default())?;
/// let state = ExtractionState::new();
/// // Before the glass is found the whole search range is looked at, and no more.
/// let region = state.region(&config);
/// assert!(region.left > 0 && region.right < 640 && region.top < region.bottom);
/// # Ok::<(), meniscus::surface::ConfigError>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct ExtractionState {
    axis_m: Option<f32>,
    silhouette_m: Option<f32>,
    edge: Edge,
    samples: Samples,
    tally: Tally,
    offset_m: Option<f32>,
}

impl ExtractionState {
    /// Nothing seen yet.
    #[must_use]
    pub const fn new() -> Self {
        let tally = Tally {
            profiles: 0,
            not_seen: 0,
            holes: 0,
            not_the_wall: 0,
            covered: 0,
            apart: 0,
            behind: 0,
            saturated: 0,
        };
        Self {
            axis_m: None,
            silhouette_m: None,
            edge: Vec::new(),
            samples: Vec::new(),
            tally,
            offset_m: None,
        }
    }

    /// Returns the measured distance of the wall less the one in the settings, in the last frame
    /// that gave a profile, metres; a lasting value means that the camera stands elsewhere.
    #[must_use]
    pub fn wall_offset_m(&self) -> Option<f32> {
        self.offset_m
    }

    /// The pixels of the outline's image that the next [`extract`] may look at.
    #[must_use]
    pub fn region(&self, config: &Config) -> Region {
        Region::around(config, self.axis_m).with_rim(config.image_size())
    }

    /// Returns the counters of the stages.
    #[must_use]
    pub fn tally(&self) -> Tally {
        self.tally
    }
}

/// Extracts the profile from a pair of images of one instant. Time and number are
/// [`Config::stamp_of`] the pair.
///
/// ```
/// use meniscus::surface::{Config, ExtractionError, Settings, ExtractionState, extract};
/// use meniscus::usb::frame::{DepthFrame, OutlineFrame, Stamp};
///
/// let config = Config::new(Settings::default())?;
/// let (width, height) = config.image_size();
/// let (depth, outline) = (vec![0; 2 * width * height], vec![128; width * height]);
/// let stamp = Stamp::default();
/// let depth = DepthFrame { bytes: &depth, width, height, stamp };
/// let outline = OutlineFrame { bytes: &outline, width, height, stamp };
///
/// // A grey wall without a glass gives no profile, and the reason.
/// let mut state = ExtractionState::new();
/// assert_eq!(extract(&config, &mut state, depth, outline), Err(ExtractionError::NoContrast));
/// assert_eq!(state.tally().not_seen, 1);
/// # Ok::<(), meniscus::surface::ConfigError>(())
/// ```
///
/// # Errors
/// [`ExtractionError`] says which stage found nothing; the glass is then searched in the whole range again.
pub fn extract(
    config: &Config,
    state: &mut ExtractionState,
    depth: DepthFrame<'_>,
    outline: OutlineFrame<'_>,
) -> Result<SurfaceProfile, ExtractionError> {
    extract_from(config, state, Some(depth), outline)
}

/// Extracts the profile from the image of the outline alone, of a camera that has no depth image.
///
/// The wall is taken to be at [`Settings::camera_distance_m`](super::Settings), and what stands before the glass is not
/// distinguished from the liquid.
///
/// ```
/// use meniscus::surface::{Config, ExtractionError, ExtractionState, Settings, extract_outline};
/// use meniscus::usb::frame::{OutlineFrame, Stamp};
///
/// let config = Config::new(Settings::default())?;
/// let (width, height) = config.image_size();
/// let grey = vec![128; width * height];
/// let outline = OutlineFrame { bytes: &grey, width, height, stamp: Stamp::default() };
/// let profile = extract_outline(&config, &mut ExtractionState::new(), outline);
/// assert_eq!(profile, Err(ExtractionError::NoContrast));
/// # Ok::<(), meniscus::surface::ConfigError>(())
/// ```
///
/// # Errors
/// Those of [`extract`], but for the ones of the depth image.
pub fn extract_outline(
    config: &Config,
    state: &mut ExtractionState,
    outline: OutlineFrame<'_>,
) -> Result<SurfaceProfile, ExtractionError> {
    extract_from(config, state, None, outline)
}

fn extract_from(
    config: &Config,
    state: &mut ExtractionState,
    depth: Option<DepthFrame<'_>>,
    outline: OutlineFrame<'_>,
) -> Result<SurfaceProfile, ExtractionError> {
    let profile = attempt(config, state, depth, outline);
    let counter = match profile {
        Ok(profile) => {
            state.axis_m = profile.glass_x_m;
            &mut state.tally.profiles
        }
        Err(_) => {
            state.axis_m = None;
            &mut state.tally.not_seen
        }
    };
    *counter = counter.saturating_add(1);
    profile
}

fn attempt(
    config: &Config,
    state: &mut ExtractionState,
    depth: Option<DepthFrame<'_>>,
    outline: OutlineFrame<'_>,
) -> Result<SurfaceProfile, ExtractionError> {
    let lens = &config.settings.intrinsics;
    let pixels = lens.width.saturating_mul(lens.height);
    let size = [lens.width, lens.height];
    let depth_fits = depth.is_none_or(|depth| {
        [depth.width, depth.height] == size && depth.bytes.len() == pixels.saturating_mul(2)
    });
    if [outline.width, outline.height] != size || outline.bytes.len() != pixels || !depth_fits {
        return Err(ExtractionError::WrongSize);
    }
    let image = Grey { bytes: outline.bytes, width: outline.width };
    let region = Region::around(config, state.axis_m);
    if region.left >= region.right || region.top >= region.bottom {
        return Err(ExtractionError::RegionEmpty);
    }
    let threshold = Threshold::of(image, region, config.settings.liquid)
        .filter(|threshold| threshold.contrast >= config.settings.least_contrast)
        .ok_or(ExtractionError::NoContrast)?;
    // An edge must have half the contrast of the classes to be one.
    let least = 0.5 * threshold.contrast;

    let tracked = Tracked {
        axis_m: state.axis_m,
        radius_m: state.silhouette_m,
        offset_m: state.offset_m.unwrap_or(0.0),
    };
    let body =
        glass::find(config, image, region, &threshold, tracked).ok_or(ExtractionError::GlassNotFound)?;
    let clear = config.settings.liquid == Liquid::Clear;
    let trace = if clear { super::clear::trace } else { trace };
    let saturated = trace(config, image, body, &threshold, least, &mut state.edge);
    if state.edge.len() < LEAST_COLUMNS {
        return Err(ExtractionError::TooFewColumns);
    }
    let lowest = state.edge.iter().map(|point| point.row).fold(0.0, f32::max) as usize;
    let rows = (lowest.saturating_add(CLEARANCE_ROWS), config.foot_rows.1);
    let Silhouette { axis_m, radius_m } =
        glass::axis(config, image, body, rows, least).ok_or(ExtractionError::GlassNotFound)?;
    state.silhouette_m = radius_m.or(state.silhouette_m);
    // Wider than any wall that is guessed: this is not the glass that was stated.
    let beyond_m = state.silhouette_m.map_or(0.0, |radius_m| radius_m - config.settings.radius_m);
    if config.settings.wall_m.is_none() && beyond_m > THICKEST_MEASURED_M {
        return Err(ExtractionError::GlassNotFound);
    }
    let glass = Glass { axis_m, wall: GlassWall::of(config, state.silhouette_m) };
    // Stereo sees anything behind or before a clear liquid, but not its wall.
    let looked_at = depth.filter(|_| !clear);
    let wall = match looked_at {
        Some(depth) => place(config, depth, glass, &state.edge, &mut state.samples, &mut state.tally)?,
        None => at_stated_distance(config, glass, &state.edge, &mut state.samples),
    };
    if state.samples.len() < LEAST_COLUMNS {
        return Err(ExtractionError::TooFewColumns);
    }
    hidden::take_back(config, &mut state.samples);
    // A point that was moved down wrongly is no other thing's, so these moves are taken back first.
    apart::drop_apart(config, &mut state.samples, &mut state.tally);
    if state.samples.len() < LEAST_COLUMNS {
        return Err(ExtractionError::TooFewColumns);
    }
    hidden::allow(config, &mut state.samples);
    state.offset_m = Some(wall.offset_m);
    if 2 * saturated >= state.edge.len() {
        state.tally.saturated = state.tally.saturated.saturating_add(1);
    }
    let Points { height_m, variance_m2, valid } = resample(config, &state.samples, wall.scatter_m);
    if !valid.contains(&true) {
        return Err(ExtractionError::TooFewColumns);
    }
    let stamp = depth.map_or(outline.stamp, |depth| config.stamp_of(depth.stamp, outline.stamp));
    let Stamp { sequence, captured } = stamp;
    Ok(SurfaceProfile { height_m, variance_m2, valid, glass_x_m: Some(axis_m), sequence, captured })
}

#[cfg(test)]
mod tests;
