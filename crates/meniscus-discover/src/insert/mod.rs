//! Insertion of effects into the models that a discovery did not fit: the flashed model and the simulator.
//!
//! | file | purpose |
//! |---|---|
//! | `map` | the first mode in latent space, fitted to decoded roll-outs |
//! | `latent` | a recording as the flashed model rolls it out, its motion known |
//! | `course` | a motion, and the particle simulator's answer to it |
//! | `simulator` | interface of a simulator of the glass, and the particle simulator |
//! | `simulated` | the same recording, simulated again with the effect |
//!
//! [`insert`] writes the list of effects into a blob. The loader derives from it the changes of the step, see
//! [`meniscus::latent::generic::Slots`].

mod course;
pub mod latent;
mod map;
pub mod simulated;
pub mod simulator;

pub use map::{MapError, Mapped, map};

use meniscus::blob::{EmbeddedEffect, EmbeddedEffects, LoadError, Model, Tensor};
use meniscus::latent::generic::{LATENTS, ModeMap};
use meniscus::latent::nn::Element;
use meniscus::reduced::Rheology;
use meniscus::reduced::effects::{Active, MOST};
use meniscus_data::blob_file::read::parts;
use meniscus_data::blob_file::write::{ExportError, Part, stored};
use meniscus_platform::files::AlignedBytes;

/// Reason why no effect was inserted.
#[derive(Clone, Debug, PartialEq)]
pub enum InsertError {
    /// The model is refused, or refuses the effects.
    Load(LoadError),
    /// The new blob could not be written down.
    Export(ExportError),
    /// The model's first mode was not found in its latents.
    Map(MapError),
    /// More effects than a model has room for.
    Many(usize),
}

impl std::fmt::Display for InsertError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Load(error) => write!(f, "{error}"),
            Self::Export(error) => write!(f, "{error}"),
            Self::Map(error) => write!(f, "{error}"),
            Self::Many(count) => write!(f, "{count} effects: a model has room for {MOST}"),
        }
    }
}

impl std::error::Error for InsertError {}

/// Returns the rheology of a liquid of the simulator for the reduced model.
#[must_use]
pub fn resistance(rheology: &meniscus_data::liquids::Rheology) -> Rheology {
    Rheology {
        index: rheology.index,
        yield_pa: rheology.yield_stress,
        ..Rheology::newtonian(rheology.consistency)
    }
}

/// Liquid that a model was trained on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrainedLiquid {
    /// Density, kg/m3.
    pub density_kg_m3: f64,
    /// Rheology.
    pub rheology: Rheology,
}

/// A model with effects.
#[derive(Clone, Debug)]
pub struct Inserted {
    /// The blob.
    pub blob: Vec<u8>,
    /// Map of the first mode in latent space, and the share that it explains.
    pub mapped: Mapped,
}

/// Returns `blob`, trained on `liquid`, with `effects` instead of those that it had; an empty list removes them. The blob
/// must lie as in flash, on a boundary of 64 bytes.
///
/// # Errors
/// [`InsertError`].
pub fn insert(blob: &[u8], liquid: TrainedLiquid, effects: &[Active]) -> Result<Inserted, InsertError> {
    let TrainedLiquid { density_kg_m3, rheology } = liquid;
    let (mut header, mut all) = parts(blob).map_err(InsertError::Load)?;
    let elements: Vec<(Tensor, Element)> = header.sections.iter().map(|s| (s.tensor, s.element)).collect();
    let element = |tensor| elements.iter().find(|(t, _)| *t == tensor).map_or(Element::F32, |(_, e)| *e);
    // The map is the plain model's, whatever it held before.
    header.embedded = None;
    header.model_version = header.model_version.saturating_add(1);
    all.retain(|part| part.tensor != Tensor::ModeMap);
    let plain = stored(header.clone(), &all, element).map_err(InsertError::Export)?;
    let plain = AlignedBytes::copy(&plain);
    let mapped = map(&Model::load(&plain).map_err(InsertError::Load)?).map_err(InsertError::Map)?;
    if effects.is_empty() {
        return Ok(Inserted { blob: plain.to_vec(), mapped });
    }
    let mut list = heapless::Vec::<EmbeddedEffect, MOST>::new();
    for effect in effects {
        let name = effect.entry.name.try_into().map_err(|_| InsertError::Export(ExportError::Header))?;
        list.push(EmbeddedEffect { name, values: effect.values })
            .map_err(|_| InsertError::Many(effects.len()))?;
    }
    header.embedded = Some(EmbeddedEffects { density_kg_m3, liquid: rheology, effects: list });
    let ModeMap { height, rate, along_height, along_rate } = mapped.map;
    let rows = [height, rate, along_height, along_rate];
    let values: Vec<f32> = rows.iter().flat_map(|row| row.iter().map(|x| *x as f32)).collect();
    all.push(Part { tensor: Tensor::ModeMap, rows: rows.len(), columns: LATENTS, values });
    let blob = stored(header, &all, element).map_err(InsertError::Export)?;
    Model::load(&AlignedBytes::copy(&blob)).map_err(InsertError::Load)?;
    Ok(Inserted { blob, mapped })
}
