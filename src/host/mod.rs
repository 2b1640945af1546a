//! Storey 2: the machine beside the camera.
#![allow(clippy::disallowed_methods, reason = "only storey 1 must compute the same bits on every platform")]

pub(in crate::host) extern crate std;

/// `std` and its prelude, by name: the crate is `no_std`, so each file of this storey opens with
/// `use crate::host::prelude::*;`.
pub(in crate::host) mod prelude {
    pub(in crate::host) use super::std::{self, eprintln, format, prelude::rust_2024::*, println, vec};
}
