//! The weight blob: checked once, read in place ever after. `firmware-config/SPEC.md` has the bytes.

mod assemble;
mod effect_embedding;
mod effect_validity;
mod embedded_effects;
mod error;
mod filter_config;
mod format;
mod header;
mod known_groups;
mod load;
mod observation_model;
mod read_header;
mod shapes;
mod store;
mod variant;

pub use embedded_effects::{EmbeddedEffect, EmbeddedEffects};
pub use error::LoadError;
pub use filter_config::{FilterConfig, ScaleBounds};
pub use format::{MAGIC, MAX_SECTIONS, OLDEST_VERSION, Section, Tensor, VERSION};
pub use header::{BEFORE, Extension, Header};
pub use known_groups::{FieldGroup, KnownGroups};
pub use load::Model;
pub use observation_model::ObservationModel;
pub use read_header::{CRC, PREFIX_LEN};
pub use store::ALIGNMENT;
pub use variant::Variant;
