//! Storey 3: what needs time, not a deadline: the simulator, recordings, the rendered camera, training.
#![allow(clippy::disallowed_methods, reason = "only storey 1 must compute the same bits on every platform")]

pub(in crate::offline) extern crate std;

pub mod adopt;
pub mod baseline;
pub mod bench;
pub mod camera;
pub mod deadline;
pub mod discover;
#[cfg(feature = "train")]
pub mod evaluate;
pub mod experiment;
pub mod export;
pub mod film;
pub mod import;
pub mod liquids;
pub mod motion;
pub mod panels;
pub mod quantize;
pub mod recognise;
pub mod recording;
pub mod repeat;
pub mod replay;
pub mod scene;
pub mod score;
pub mod sph;
pub mod study;
#[cfg(feature = "train")]
pub mod train;
pub mod usb;
pub mod validate;
pub mod viewers;
pub mod watching;

/// `std` and its prelude, by name: the crate is `no_std`, so each file of this storey opens with
/// `use crate::offline::prelude::*;`.
pub(in crate::offline) mod prelude {
    pub(in crate::offline) use super::std::{self, format, prelude::rust_2024::*, vec};
}
