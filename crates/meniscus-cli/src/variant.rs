//! Variants of the estimator by their names.

use clap::ValueEnum;
use meniscus::blob::Variant;

/// Variant of the estimator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum VariantName {
    /// Surface and full field, in double precision.
    Full,
    /// Surface alone, in single precision.
    Small,
}

impl From<VariantName> for Variant {
    fn from(name: VariantName) -> Self {
        match name {
            VariantName::Full => Self::Full,
            VariantName::Small => Self::Small,
        }
    }
}
