//! Networks between data and latents: autoencoder, encoder with its camera noise, pattern of the internal energy.

pub(crate) mod autoencoder;
pub(crate) mod base;
pub(crate) mod encoded;
pub(crate) mod encoder;
pub(crate) mod heat;
pub(crate) mod noise;
pub(crate) mod sparse;
