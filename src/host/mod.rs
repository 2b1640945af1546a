//! Storey 2: the machine beside the camera.
#![allow(clippy::disallowed_methods, reason = "only storey 1 must compute the same bits on every platform")]

pub(in crate::host) extern crate std;

pub mod allocations;
#[cfg(feature = "bags")]
pub mod bag;
pub mod buffer;
pub mod camera;
pub mod checks;
pub mod clock;
pub mod files;
pub mod flash;
#[cfg(feature = "foxglove")]
pub mod foxglove;
pub mod handoff;
pub mod large_pages;
pub mod link;
pub mod live;
pub mod look;
pub mod page;
pub mod publish;
pub mod realtime;
pub mod recognise;
pub mod report;
pub mod setup;
pub mod told;
pub mod usb;
pub mod view;
pub mod wide;

/// `std` and its prelude, by name: the crate is `no_std`, so each file of this storey opens with
/// `use crate::host::prelude::*;`.
pub(in crate::host) mod prelude {
    pub(in crate::host) use super::std::{self, format, prelude::rust_2024::*, vec};
}
