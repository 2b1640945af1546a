//! Particles, their kernel and their neighbours: the sums that everything else is made of.
//!
//! | file | content |
//! |---|---|
//! | `state` | position, velocity, volume, pressure of a particle; the liquid |
//! | `kernel` | smoothing kernel and its slope |
//! | `neighbours` | pairs within the support of the kernel, and sums over them in a fixed order |
//! | `rows` | a list of lists in two arrays |
//! | `grid` | cells, searched for what is near |
//! | `lanes` | rows of eight numbers turned into columns, by vector instructions |
//! | `blocks` | neighbours of a particle side by side, for vector instructions |
//! | `tensor` | symmetric tensors as six numbers |

pub(crate) mod blocks;
mod grid;
mod kernel;
pub(crate) mod lanes;
mod neighbours;
mod rows;
mod state;
pub(crate) mod tensor;

pub(crate) use grid::Box3;
pub(crate) use kernel::{Kernel, SMOOTHING};
pub(crate) use neighbours::{IMAGE_SKIN, Neighbours, distance2};
pub(crate) use rows::{CHUNKS, LIGHT, PIECE, Rows};
pub(crate) use state::{Fluid, Particle, retain};
