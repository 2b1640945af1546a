//! Liquid of the recordings of a correction: what the simulated camera sees of it, and whether it is the model's own.
//!
//! A correction to the model's own liquid leaves every field group known, one to another liquid the surface and the positions.
//! Recordings of the simulator are of the model's liquid if name, density and effects are those of the source recordings.

use super::Sightings;
use meniscus::blob::Header;
use meniscus::surface::ConfigError;
use meniscus_data::recording::{Provenance, Recording};
use meniscus_virtual::observe_recording::sightings;
use meniscus_virtual::render::SceneSettings;

/// Largest relative difference of two densities of one liquid.
const SAME_DENSITY: f64 = 0.01;

/// Seed of the first look at a source recording less the seed of the correction.
pub const SOURCE_SEED: u64 = 1000;

/// Returns the profiles that the simulated camera, with a disparity noise of `noise_px`, sees of `all`, with seeds from `first` on.
///
/// # Errors
/// [`ConfigError`], when the camera cannot see a glass.
pub fn looks(all: &[Recording], noise_px: f64, first: u64) -> Result<Vec<Sightings>, ConfigError> {
    let seen = |(k, recording): (u64, &Recording)| {
        let scene = SceneSettings {
            disparity_rms_px: noise_px,
            seed: first + k,
            ..SceneSettings::of(&recording.glass)
        };
        sightings(recording, scene)
    };
    (0..).zip(all).map(seen).collect()
}

/// Returns whether a recording of the simulator shows the liquid of a model of `header` with recordings `source` of its own.
#[must_use]
pub fn is_own(new: &Provenance, header: &Header, source: &[Recording]) -> bool {
    let alike = |own: &Recording| {
        let own = &own.provenance;
        own.liquid == new.liquid
            && is_same_density(own.density_kg_m3, new.density_kg_m3)
            && own.effects == new.effects
    };
    new.liquid == header.liquid.as_str() && source.iter().all(alike)
}

/// Returns whether two densities are those of one liquid.
#[must_use]
pub fn is_same_density(a: f64, b: f64) -> bool {
    (a / b - 1.0).abs() <= SAME_DENSITY
}

/// Returns the name of a corrected model's liquid: `new`, and where it is another one, that of the model it comes from.
#[must_use]
pub fn corrected_name(new: &str, header: &Header, same_liquid: bool) -> String {
    if same_liquid { new.into() } else { format!("{new} from {}", header.liquid) }
}
