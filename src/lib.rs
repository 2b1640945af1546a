//! Camera-side core of Meniscus: from USB payloads of a depth camera to the full state of a sloshing liquid.
//!
//! The crate is `no_std` and allocates nothing, panics nowhere, reads no clock and does no I/O. `ARCHITECTURE.md`
//! shows the crates around it.
//!
//! # One 60 Hz turn
//!
//! ```text
//! USB payloads --usb::uvc::Assembler--> DepthFrame, OutlineFrame --surface--> SurfaceProfile --push--> latent::window
//!                                                                                                    | latent::encoder (GRU)
//!                       heights, position of the glass --.          latents and input, as read <-----+
//! output <-- Estimate <-- Field <--latent::decoder-- Latent <--filter::kalman-- Latent <--latent::generic (step)-- Latent
//!                                                                               '--> audit: work, heat, dE, dS
//! ```
//!
//! # Modules, lowest first
//!
//! | module | purpose |
//! |---|---|
//! | [`math`], [`real`], [`units`] | functions with the same bits on every platform; precision; time and length types |
//! | [`usb`] | UVC payloads and D400 tables to whole frames, every loss counted |
//! | [`depth_filters`] | the reference depth filters, bit for bit |
//! | [`surface`] | images to 21 surface heights with variance |
//! | [`reduced`] | the reduced slosh model and the effects it knows |
//! | [`latent`] | window, encoder, GENERIC step, decoder |
//! | [`uncertainty`] | error model, discrepancy, cross-axis mode |
//! | [`blob`] | the weight blob, checked once and read in place |
//! | [`filter`] | the Kalman filter over the latents |
//! | [`runtime`] | the turn, its modes, deadline, health and forecast |
//! | [`identify`] | which of several known liquids it is |
//!
//! A module imports only modules above it in this table, and [`identify`] is imported by none.
//!
//! # Rules
//!
//! 1. Weights are `&self`, memory is `&mut` state, results go into the caller's buffer.
//! 2. Bytes are checked once, in [`usb`] and in [`blob`]; after that nothing can be malformed.
//! 3. Clock, randomness and I/O are arguments. Time comes from the frame.
//! 4. Units go in types across modules, in name suffixes (`_m`, `_us`) locally.
//! 5. Every bound has a mode and a counter in [`runtime::health`] for when it is missed.
//! 6. The formula stands above the code, in the same letters, with its source.
#![no_std]

pub mod blob;
pub mod depth_filters;
pub mod filter;
pub mod identify;
pub mod latent;
pub mod math;
pub mod real;
pub mod reduced;
pub mod runtime;
mod square_root;
pub mod surface;
pub mod uncertainty;
pub mod units;
pub mod usb;
