//! Variants of the estimator: how much of a turn a processor has time for.

use super::{FieldGroup, KnownGroups};
use crate::real::Precision;

/// Variant of the estimator on a model.
///
/// The stages of a turn are the same code in both. What a variant leaves out counts as not known, as if the model did not cover
/// it: no output shows it.
///
/// ```
/// # #[repr(align(64))]
/// # struct Aligned<T: ?Sized>(T);
/// # static BLOB: &Aligned<[u8]> =
/// #     &Aligned(*include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/models/glycerine.blob")));
/// use meniscus::blob::{FieldGroup, Model, Variant};
/// use meniscus::runtime::Estimator;
///
/// let mut model = Model::load(&BLOB.0)?;
/// assert!(Estimator::new(&model).field_len() > 0);
/// model.header.variant = Variant::Small;
/// assert_eq!(Estimator::new(&model).field_len(), 0);
/// assert!(!model.header.known().contains(FieldGroup::Velocity));
/// # Ok::<(), meniscus::blob::LoadError>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Variant {
    /// Surface and full field, in double precision.
    #[default]
    Full,
    /// Surface alone, in single precision: for a microcontroller without a unit for double precision.
    Small,
}

impl Variant {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Full, Self::Small];

    /// Returns the name of the variant, as a person writes it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Full => "full",
            Self::Small => "small",
        }
    }

    /// Returns the precision in which it computes.
    #[must_use]
    pub const fn precision(self) -> Precision {
        match self {
            Self::Full => Precision::Double,
            Self::Small => Precision::Single,
        }
    }

    /// Returns the field groups that it estimates.
    #[must_use]
    pub const fn groups(self) -> KnownGroups {
        match self {
            Self::Full => KnownGroups::ALL,
            Self::Small => KnownGroups::NONE.with(FieldGroup::Surface),
        }
    }
}
