//! Attacks on the program, by class. `cargo xtask trust` runs them and makes `docs/trust.md` of them.
//!
//! The first line of a test's documentation is the promise that the test attacks; the lines behind it say how.

#[path = "../support/server.rs"]
#[allow(dead_code, reason = "each test takes what it needs of it")]
mod server;

#[path = "../support/optional.rs"]
mod optional;
#[path = "../support/resealed.rs"]
mod resealed;

mod boards;
mod bombs;
mod camera;
mod databases;
mod datagrams;
mod devices;
mod encryption;
mod held_page;
mod interrupted;
mod links;
mod meet;
mod models;
mod motion;
mod names;
mod origins;
mod pages;
mod rivals;
mod signatures;
mod sockets;
mod support;
mod terminals;
mod unit;
