//! Dense and recurrent layers over packed weights: weights `&self`, memory `&mut`, results into the
//! caller's buffer.

mod gru;
mod matrix;

pub use gru::{Gru, HIDDEN};
pub use matrix::{Matrix, PANEL, Vector, packed_index, packed_len};
