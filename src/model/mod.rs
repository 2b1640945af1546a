//! The weight blob: checked once, read in place ever after.

mod header;

pub use header::{Header, MAGIC, Section, Tensor, VERSION};
