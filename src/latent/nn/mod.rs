//! Dense and recurrent layers over packed weights: weights `&self`, memory `&mut`, results into the
//! caller's buffer.
//!
//! What the laws stand on (H, L, D, the port, the gain) is a [`Matrix`], which is `f32` and nothing else.
//! What may be stored coarser (GRU, decoder trunk, bases) is a [`Weights`]: `f32`, `bf16` or `i8`. A coarser
//! model can therefore be less accurate, and cannot break a law.

mod cpu_width;
mod dense;
mod dtype;
mod gru;
mod int8;
mod kernels;
mod matrix;
mod packing;
mod weights;

#[cfg(target_arch = "x86_64")]
pub use cpu_width::allow_avx2;
pub use cpu_width::is_wide;
pub use cpu_width::{Kernel, widest};
pub use dense::{Dense, relu};
pub use dtype::{Element, bf16_of, f32_of};
pub use gru::{Gru, HIDDEN};
pub use matrix::{Matrix, Vector};
pub use packing::{PANEL, packed_index, packed_len};
pub use weights::{Weights, bf16_index, section_len};
