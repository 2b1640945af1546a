//! Attacks on the program, by class. `cargo xtask trust` runs them and makes `docs/trust.md` of them.
//!
//! The first line of a test's documentation is the promise that the test attacks; the lines behind it say how.

#[path = "../support/server.rs"]
#[allow(dead_code, reason = "each test takes what it needs of it")]
mod server;

#[path = "../support/optional.rs"]
mod optional;

mod bombs;
mod disk;
mod files;
mod motion;
mod servers;
mod support;
