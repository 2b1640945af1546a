//! Meniscus watches the free surface of a sloshing liquid and knows the whole liquid.
//!
//! # Three storeys; arrows point up only
//!
//! | storey | modules | may use |
//! |---|---|---|
//! | 1 camera side: `no_std`, no alloc, no panic, no clock, no I/O | everything but the two below | itself and `core` |
//! | 2 host, feature `host` | [`host`] | storey 1 and `std` |
//! | 3 offline, feature `offline` (simulator and studies: `studies`; training: `train`) | [`offline`] | storeys 1, 2 and `std` |
//!
//! # One 60 Hz turn
//!
//! ```text
//! USB payloads --uvc::Assembler--> DepthFrame, OutlineFrame --surface--> SurfaceProfile --push--> Window
//!                                                                                                    | encoder (GRU)
//!                              heights, place of the glass --.          latents, push, as it reads them <---+
//! output <-- Estimate <-- Field <--decoder-- Latent <--runtime::filter-- Latent <--generic::step-- Latent
//!                                                                                '--> audit: work, heat, dE, dS
//! ```
//!
//! # Rules
//!
//! 1. Weights are `&self`, memory is `&mut State`, results go into the caller's buffer.
//! 2. Bytes are checked once, in [`uvc`] and in [`model`]; after that nothing can be malformed.
//! 3. Clock, randomness and I/O are arguments. Time comes from the frame.
//! 4. Units go in types across modules, in name suffixes (`_m`, `_us`) locally.
//! 5. Every bound names what happens when it is missed: a mode and a counter in [`health`].
//! 6. The formula stands above the code, in the same letters, with its source.
#![no_std]

// Storey 1.
pub mod d4xx;
pub mod decoder;
pub mod discrepancy;
pub mod effects;
pub mod encoder;
pub mod filters;
pub mod frame;
pub mod generic;
pub mod health;
pub mod interval;
pub mod math;
pub mod model;
pub mod nn;
pub mod output;
pub mod recognise;
pub mod runtime;
pub mod slosh;
pub mod surface;
pub mod transverse;
pub mod units;
pub mod uvc;
pub mod window;

// Storey 2.
#[cfg(feature = "host")]
pub mod host;

// Storey 3.
#[cfg(feature = "offline")]
pub mod offline;
