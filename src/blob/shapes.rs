//! The shape that each tensor must have, given what the header says.

use super::{Header, Tensor};
use crate::latent::decoder::{ENERGY_GROUP, GROUP_COMPONENTS, MAX_COEFFICIENTS, MAX_HEATED, MAX_TRUNK};
use crate::latent::encoder::{GRU_LAYERS, READINGS};
use crate::latent::generic::{LATENTS, LAW_NUMBERS, MAX_HIDDEN};
use crate::latent::nn::HIDDEN;
use crate::latent::window::FEATURES;
use crate::surface::POINTS;
use crate::uncertainty::error_factors::ErrorFactors;
use crate::uncertainty::error_model::SPREAD_GROUPS;

/// Allowed sizes of a dimension.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Dim {
    /// Exactly this.
    Is(usize),
    /// From one to this.
    UpTo(usize),
    /// One of these.
    OneOf([usize; ErrorFactors::SIZES.len()]),
}

impl Dim {
    /// Whether `n` will do.
    pub(super) fn allows(self, n: usize) -> bool {
        match self {
            Self::Is(exact) => n == exact,
            Self::UpTo(most) => (1..=most).contains(&n),
            Self::OneOf(sizes) => sizes.contains(&n),
        }
    }
}

/// Index of the surface among the decoded groups.
pub(super) const SURFACE_GROUP: usize = 5;

/// Rows and columns of a tensor; `None` for an index that no model has.
pub(super) fn shape(tensor: Tensor, header: &Header) -> Option<(Dim, Dim)> {
    use Dim::{Is, OneOf, UpTo};
    let gates = Is(3 * HIDDEN);
    let layer = |index: u8| usize::from(index) < GRU_LAYERS;
    Some(match tensor {
        Tensor::GruInput(0) => (gates, Is(FEATURES)),
        Tensor::GruInput(index) | Tensor::GruHidden(index) if layer(index) => (gates, Is(HIDDEN)),
        Tensor::GruInputBias(index) | Tensor::GruHiddenBias(index) if layer(index) => (gates, Is(1)),
        Tensor::HeadWeight => (Is(READINGS), Is(HIDDEN)),
        Tensor::HeadBias => (Is(READINGS), Is(1)),
        Tensor::Port => (Is(LATENTS), Is(1)),
        Tensor::SkewLower => (Is(LATENTS * (LATENTS - 1) / 2), Is(1)),
        Tensor::FrictionFactor => (Is(LATENTS * (LATENTS + 1) / 2), Is(1)),
        Tensor::EnergyLinear | Tensor::Preconditioner | Tensor::Gain => (Is(LATENTS), Is(LATENTS)),
        Tensor::Transition | Tensor::ProcessSpread | Tensor::ReadingSpread => (Is(LATENTS), Is(LATENTS)),
        Tensor::SurfaceSlope => (Is(POINTS), Is(LATENTS)),
        Tensor::GroupSlope => (Is(SPREAD_GROUPS * LATENTS), Is(LATENTS)),
        Tensor::SurfaceMisfit => (Is(POINTS), Is(1)),
        Tensor::GroupMisfit => (Is(SPREAD_GROUPS), Is(1)),
        Tensor::Reach => (OneOf(ErrorFactors::SIZES), Is(1)),
        Tensor::ModeMap => (Is(4), Is(LATENTS)),
        Tensor::FrictionLaw => (Is(LAW_NUMBERS), Is(1)),
        Tensor::EnergyIn => (UpTo(MAX_HIDDEN), Is(LATENTS)),
        Tensor::EnergyBias | Tensor::EnergyWeight => (UpTo(MAX_HIDDEN), Is(1)),
        Tensor::TrunkLinear => (UpTo(MAX_COEFFICIENTS), Is(LATENTS)),
        Tensor::TrunkPort => (UpTo(MAX_COEFFICIENTS), Is(1)),
        Tensor::TrunkWeight(0) => (UpTo(MAX_TRUNK), Is(LATENTS)),
        Tensor::TrunkWeight(1) => (UpTo(MAX_TRUNK), UpTo(MAX_TRUNK)),
        Tensor::TrunkWeight(2) => (UpTo(MAX_COEFFICIENTS), UpTo(MAX_TRUNK)),
        Tensor::TrunkBias(0 | 1) => (UpTo(MAX_TRUNK), Is(1)),
        Tensor::TrunkBias(2) => (UpTo(MAX_COEFFICIENTS), Is(1)),
        Tensor::GroupRest(group) => (Is(numbers(group, header)?), Is(1)),
        Tensor::GroupBasis(group) if usize::from(group) == ENERGY_GROUP => {
            (Is(numbers(group, header)?), UpTo(MAX_HEATED))
        }
        Tensor::GroupBasis(group) => (Is(numbers(group, header)?), UpTo(MAX_COEFFICIENTS)),
        _ => return None,
    })
}

/// Numbers in a decoded group.
fn numbers(group: u8, header: &Header) -> Option<usize> {
    let group = usize::from(group);
    if group == SURFACE_GROUP {
        return Some(POINTS);
    }
    GROUP_COMPONENTS.get(group)?.checked_mul(usize::try_from(header.particles).ok()?)
}
