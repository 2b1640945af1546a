//! Format of a blob: its magic, its versions, and the tensors that it may list. `firmware-config/SPEC.md` has the bytes.

use crate::latent::nn::Element;
use serde::{Deserialize, Serialize};

/// First bytes of every blob.
pub const MAGIC: [u8; 8] = *b"MENISCUS";

/// Tensors that a blob may list.
pub const MAX_SECTIONS: usize = 64;

/// Format version that this build writes.
pub const VERSION: u32 = 4;

/// Oldest format version that this build reads. Version 3 has no [`super::Extension`]; its fields then have their defaults.
pub const OLDEST_VERSION: u32 = 3;

/// The tensors of a model. Shapes are `[rows, columns]`, little-endian in the blob, `f32` or coarser
/// ([`Element`]), packed in panels as [`crate::latent::nn::packed_index`] says; a vector has one column. N latents, U ports, F features a frame, P profile points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Tensor {
    /// GRU layer `0..3`, input weights `[78, F or 26]`, gates stacked in the order r, z, n.
    GruInput(u8),
    /// GRU layer `0..3`, recurrent weights `[78, 26]`.
    GruHidden(u8),
    /// GRU layer `0..3`, input bias `[78]`.
    GruInputBias(u8),
    /// GRU layer `0..3`, recurrent bias `[78]`.
    GruHiddenBias(u8),
    /// Linear head of the encoder `[N + U, 26]`: the latents, then the port value of this instant.
    HeadWeight,
    /// Bias of the head `[N + U]`.
    HeadBias,
    /// Strict lower triangle of the skew operator L, rows first `[N (N - 1) / 2]`.
    SkewLower,
    /// Lower triangle of C in D = C C^T, rows first `[N (N + 1) / 2]`.
    FrictionFactor,
    /// K in H(x) = |K x|^2 / 2 + ridges, `[N, N]`.
    EnergyLinear,
    /// W of the ridges w^2 [p(a) - p(b) - p'(b) (a - b)], a = W x + b, p(a) = sqrt(1 + a^2); `[ridges, N]`.
    EnergyIn,
    /// b `[ridges]`.
    EnergyBias,
    /// w `[ridges]`.
    EnergyWeight,
    /// Port matrix B `[N, U]`.
    Port,
    /// Preconditioner of the implicit step `[N, N]`; wrong values cost iterations, never a law.
    Preconditioner,
    /// Gain of the filter `[N, N]`.
    Gain,
    /// Linear part of the decoder trunk, latent to coefficients `[sum of ranks, N]`.
    TrunkLinear,
    /// Feed-through F of the port to the coefficients `[sum of ranks, U]`: the inertial pressure.
    TrunkPort,
    /// Trunk layer `0..3` weights, ReLU between.
    TrunkWeight(u8),
    /// Trunk layer `0..3` bias.
    TrunkBias(u8),
    /// Rest state of group `0..6` (q, v, e, sigma, tau, surface) in SI units, `[numbers]`.
    GroupRest(u8),
    /// Basis of the group, coefficients to SI units, `[numbers, rank]`; for e the first column is for the heat s in
    /// joules and each other for s times a coefficient.
    GroupBasis(u8),
    /// A of [`crate::uncertainty::error_model`]: the closed step linearised about rest `[N, N]`.
    Transition,
    /// Q: covariance of what the step misses, for a unit of w `[N, N]`.
    ProcessSpread,
    /// R: covariance of what the encoder misses, for a unit of w `[N, N]`.
    ReadingSpread,
    /// J: slope of the surface in the latents `[P, N]`, m.
    SurfaceSlope,
    /// J^T J of one number of q, v, sigma and tau, one above the other `[4 N, N]`, SI units.
    GroupSlope,
    /// Variance of what the decoder misses of each height, for a unit of w `[P]`, m2.
    SurfaceMisfit,
    /// The same of q, v, sigma and tau `[4]`, SI units squared.
    GroupMisfit,
    /// Floor of w, then k of the surface at three leads and of q, v, e, sigma, tau `[9]`; g behind them `[10]`.
    Reach,
    /// A, B, e_a and e_v of [`crate::latent::generic::ModeMap`] `[4, N]`, SI units; only with embedded effects.
    ModeMap,
    /// p1, e, y and n of [`crate::latent::generic::FrictionLaw`] `[4]`, H/s and 1; only of a liquid whose viscosity depends on the
    /// rate of shear.
    FrictionLaw,
}

/// Where a tensor lies in the blob.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Section {
    /// Which tensor.
    pub tensor: Tensor,
    /// Rows.
    pub rows: u32,
    /// Columns.
    pub columns: u32,
    /// Byte offset from the start of the blob, a multiple of 64.
    pub offset: u32,
    /// In what its weights are stored. Not part of the entry: it stands in the list behind the header, which a
    /// blob of `f32` alone has not.
    #[serde(skip)]
    pub element: Element,
}

impl Tensor {
    /// Whether the tensor may be stored coarser than `f32`: GRU, trunk and bases. Everything that the laws, the
    /// filter and the intervals stand on may not.
    #[must_use]
    pub fn may_be_coarse(self) -> bool {
        matches!(self, Self::GruInput(_) | Self::GruHidden(_) | Self::TrunkWeight(_) | Self::GroupBasis(_))
    }
}
