//! The learned model: window of profiles, encoder, GENERIC step in 13 latents, decoder, and the layers they are made of.

pub mod decoder;
pub mod encoder;
pub mod generic;
pub(crate) mod linalg;
pub mod linearisation;
pub mod nn;
pub mod window;
