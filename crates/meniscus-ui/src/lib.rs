//! Views of a run: live page, Foxglove, terminal, pictures.

pub mod figure_parts;
#[cfg(feature = "foxglove")]
pub mod foxglove;
mod listener;
pub mod page;
pub mod picture;
pub mod terminal;
mod wrapped;
