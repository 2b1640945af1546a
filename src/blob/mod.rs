//! The weight blob: checked once, read in place ever after. `firmware-config/SPEC.md` has the bytes.

mod embedded_effects;
mod error;
mod header;
mod load;
mod shapes;

pub use embedded_effects::{Lens, Named, NamedEffect, no_place};
pub use error::LoadError;
pub use header::{Header, MAGIC, MAX_SECTIONS, Section, Tensor, VERSION};
pub use load::{ALIGNMENT, CRC, Model, PREFIX_LEN};
