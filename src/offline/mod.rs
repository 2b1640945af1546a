//! Storey 3: what needs time, not a deadline: the simulator, recordings, the rendered camera, training.
#![allow(clippy::disallowed_methods, reason = "only storey 1 must compute the same bits on every platform")]

pub(in crate::offline) extern crate std;

#[cfg(feature = "studies")]
pub mod adopt;
pub mod baseline;
#[cfg(feature = "studies")]
pub mod bench;
pub mod camera;
#[cfg(feature = "studies")]
pub mod deadline;
#[cfg(feature = "studies")]
pub mod discover;
#[cfg(feature = "train")]
pub mod evaluate;
#[cfg(feature = "studies")]
pub mod experiment;
pub mod export;
#[cfg(feature = "studies")]
pub mod film;
pub mod import;
#[cfg(feature = "studies")]
pub mod liquids;
#[cfg(feature = "studies")]
pub mod motion;
pub mod panels;
#[cfg(feature = "studies")]
pub mod quantize;
#[cfg(feature = "studies")]
pub mod recognise;
pub mod recording;
pub mod repeat;
#[cfg(feature = "bags")]
pub mod replay;
pub mod scene;
pub mod score;
#[cfg(feature = "studies")]
pub mod sph;
#[cfg(feature = "studies")]
pub mod study;
#[cfg(feature = "train")]
pub mod train;
pub mod usb;
#[cfg(feature = "studies")]
pub mod validate;
#[cfg(feature = "studies")]
pub mod viewers;
pub mod watching;

/// `std` and its prelude, by name: the crate is `no_std`, so each file of this storey opens with
/// `use crate::offline::prelude::*;`.
pub(in crate::offline) mod prelude {
    pub(in crate::offline) use super::std::{self, format, prelude::rust_2024::*, vec};
}
