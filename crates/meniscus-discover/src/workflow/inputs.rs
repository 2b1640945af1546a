//! Inputs of a discovery.

use super::error::DiscoverError;
use crate::decision::settings::Settings;
use crate::insert::simulated::Resolution;
use crate::insert::simulator::{GlassSimulator, Particles};
use crate::recordings::load::RecordingSet;
use crate::references::ReferenceSettings;
use crate::sizing::stage::SizingSettings;
use meniscus::reduced::effects::{Entry, LIBRARY, find};
use meniscus_platform::files::AlignedBytes;
use std::sync::atomic::AtomicBool;

/// Smallest particle spacing, mm.
const LEAST_SPACING_MM: f64 = 1.5;

/// Everything that a discovery needs.
pub struct Inputs {
    /// Recordings of the liquid in question.
    pub recordings: RecordingSet,
    /// Recordings of known liquids in the same glass; without them the model's own error counts as an effect.
    pub references: Vec<RecordingSet>,
    /// References by simulation where none are given; none leaves them out.
    pub simulated_references: Option<ReferenceSettings>,
    /// Choices that hold for all stages.
    pub settings: Settings,
    /// Flashed model into which the effects are inserted.
    pub model: Option<AlignedBytes>,
    /// Resolution at which the held-out recording is simulated without and with the effects.
    pub simulation: Option<Resolution>,
    /// Simulator of references, sizes and the held-out recording.
    pub simulator: Box<dyn GlassSimulator + Send>,
    /// Sizes by simulation; none leaves those of the reduced model.
    pub sizing: Option<SizingSettings>,
    /// Flag that ends the simulations.
    pub stop: Option<&'static AtomicBool>,
}

impl Inputs {
    /// Returns the inputs of `recordings` with default settings and nothing else.
    #[must_use]
    pub fn new(recordings: RecordingSet) -> Self {
        Self {
            recordings,
            references: Vec::new(),
            simulated_references: None,
            settings: Settings::default(),
            model: None,
            simulation: None,
            simulator: Box::new(Particles),
            sizing: None,
            stop: None,
        }
    }

    /// Refuses a particle spacing that does not fit the glass.
    ///
    /// # Errors
    /// [`DiscoverError::Spacing`].
    pub fn check(&self) -> Result<(), DiscoverError> {
        let simulated = self.simulation.map(|resolution| resolution.spacing_m);
        let sized = self.sizing.as_ref().map(|sizing| sizing.spacing_m);
        let largest_mm = 250.0 * self.recordings.known.radius_m;
        for spacing_mm in simulated.into_iter().chain(sized).map(|spacing_m| 1e3 * spacing_m) {
            if !(LEAST_SPACING_MM..=largest_mm).contains(&spacing_mm) {
                return Err(DiscoverError::Spacing { spacing_mm, least_mm: LEAST_SPACING_MM, largest_mm });
            }
        }
        Ok(())
    }
}

/// Returns the effects called `names`, or the whole library where `names` is empty.
///
/// # Errors
/// [`DiscoverError::NoSuchEffect`].
pub fn library(names: &[String]) -> Result<Vec<&'static Entry>, DiscoverError> {
    if names.is_empty() {
        return Ok(LIBRARY.iter().collect());
    }
    let entry =
        |name: &String| find(name.trim()).ok_or_else(|| DiscoverError::NoSuchEffect { name: name.clone() });
    names.iter().map(entry).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_effect_that_does_not_exist_is_refused_with_those_that_do() {
        let names = |text: &[&str]| text.iter().map(|name| String::from(*name)).collect::<Vec<_>>();
        assert_eq!(library(&[]).expect("all").len(), LIBRARY.len());
        let two = library(&names(&["viscosity", " foam"])).expect("both exist");
        assert_eq!(two.iter().map(|entry| entry.name).collect::<Vec<_>>(), ["viscosity", "foam"]);
        let refused = library(&names(&["stickiness"])).expect_err("no such effect").to_string();
        assert!(refused.contains("'stickiness'") && refused.contains("viscosity"), "{refused}");
    }
}
