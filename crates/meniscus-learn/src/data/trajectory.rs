//! Recordings in the coordinates of the latents: true trajectories, and what a filter is given of them.

use meniscus::latent::generic::Latent;

/// One observed trajectory: states, the port that led to each, energies in units of H.
#[derive(Clone, Debug)]
pub(crate) struct Path {
    /// States.
    pub(crate) x: Vec<Latent>,
    /// Ports; `u[n]` acts between frames n - 1 and n.
    pub(crate) u: Vec<f64>,
    /// Kinetic plus potential energy over the energy scale.
    pub(crate) energy: Vec<f64>,
    /// Heat since the first frame over the energy scale.
    pub(crate) heat: Vec<f64>,
}

/// Readings of the encoder and ports of the camera over one recording, with the true latents.
#[derive(Clone, Debug)]
pub(crate) struct Track {
    /// Latents as the encoder reads them.
    pub(crate) y: Vec<Latent>,
    /// Ports as the camera measures them.
    pub(crate) u: Vec<f64>,
    /// Port values of each instant as the encoder reads them.
    pub(crate) port: Vec<f64>,
    /// True latents.
    pub(crate) truth: Vec<Latent>,
}
