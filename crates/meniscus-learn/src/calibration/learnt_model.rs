//! Everything that a training has learnt, before it is a blob.

use crate::data::dataset::Frame;
use crate::networks::autoencoder::Autoencoder;
use crate::networks::encoder::Encoder;
use crate::networks::heat::Heat;
use crate::operators::linear::Linear;
use crate::operators::reference_step::{Dynamics, Square};

/// Bases, networks, operators and gain of one training.
#[derive(Debug)]
pub(crate) struct LearntModel {
    /// Bases and scales.
    pub(crate) frame: Frame,
    /// Joint autoencoder, in the coordinates of energy.
    pub(crate) autoencoder: Autoencoder,
    /// Pattern of the internal energy.
    pub(crate) heat: Heat,
    /// GRU encoder.
    pub(crate) encoder: Encoder,
    /// Operators of the exact step.
    pub(crate) dynamics: Dynamics,
    /// Linear map with known motion, the baseline.
    pub(crate) linear: Linear,
    /// Preconditioner of the implicit step.
    pub(crate) preconditioner: Square,
    /// Constant gain, which a correction learns through.
    pub(crate) gain: Square,
}
