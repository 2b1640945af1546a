//! The weight blob: checked once, read in place ever after. `firmware-config/SPEC.md` has the bytes.

mod embedded_effects;
mod error;
mod filter_config;
mod header;
mod known_groups;
mod load;
mod read_header;
mod shapes;

pub use embedded_effects::{EmbeddedEffect, EmbeddedEffects, ObservationModel, embedding_obstacle};
pub use error::LoadError;
pub use filter_config::{FilterConfig, ScaleBounds};
pub use header::{Extension, Header, MAGIC, MAX_SECTIONS, OLDEST_VERSION, Section, Tensor, VERSION};
pub use known_groups::{FieldGroup, KnownGroups};
pub use load::{ALIGNMENT, Model};
pub use read_header::{CRC, PREFIX_LEN};
