//! Law of flow that is fitted.

use serde::{Deserialize, Serialize};

/// Law of flow that is fitted to the recordings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Law {
    /// Whatever the recordings show: a constant viscosity unless another law fits clearly better.
    #[default]
    Auto,
    /// Constant viscosity.
    Newtonian,
    /// `tau = k rate^n`.
    Power,
    /// `tau = tau0 + k rate`.
    Bingham,
    /// `tau = tau0 + k rate^n`.
    HerschelBulkley,
}

impl Law {
    /// Effects that the law adds to a constant viscosity, by name.
    pub(super) fn effects(self) -> &'static [&'static str] {
        match self {
            Self::Auto | Self::Newtonian => &[],
            Self::Power => &["shear_thinning"],
            Self::Bingham => &["yield_stress"],
            Self::HerschelBulkley => &["shear_thinning", "yield_stress"],
        }
    }

    /// Laws that are tried, the simplest first.
    pub(super) fn candidates(self) -> &'static [Self] {
        match self {
            Self::Auto => &[Self::Power, Self::Bingham, Self::HerschelBulkley],
            Self::Newtonian => &[],
            Self::Power => &[Self::Power],
            Self::Bingham => &[Self::Bingham],
            Self::HerschelBulkley => &[Self::HerschelBulkley],
        }
    }

    /// Name for people.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::Auto => "whatever the recordings show",
            Self::Newtonian => "a constant viscosity",
            Self::Power => "a power law",
            Self::Bingham => "a yield stress with a constant viscosity",
            Self::HerschelBulkley => "a yield stress with a power law",
        }
    }
}
