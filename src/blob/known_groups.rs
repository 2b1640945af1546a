//! Field groups that a model is valid for.

use super::LoadError;
use crate::latent::decoder::Selection;
use serde::{Deserialize, Serialize};

/// One group of the estimate, in the order of the decoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FieldGroup {
    /// Positions q of the tracers.
    Position,
    /// Velocities v.
    Velocity,
    /// Internal energy e.
    InternalEnergy,
    /// Normal stresses sigma.
    NormalStress,
    /// Shear stresses tau.
    ShearStress,
    /// The 21 heights of the surface.
    Surface,
}

impl FieldGroup {
    /// All groups, in the order of the decoder.
    pub const ALL: [Self; 6] = [
        Self::Position,
        Self::Velocity,
        Self::InternalEnergy,
        Self::NormalStress,
        Self::ShearStress,
        Self::Surface,
    ];

    /// Bit of the group in [`KnownGroups::bits`].
    const fn bit(self) -> u8 {
        1 << self as u8
    }
}

/// Set of the field groups whose errors are known for the blob's liquid, as a bit set.
///
/// A model corrected from camera images alone has seen nothing but the surface of its liquid. Its other groups still come
/// from the liquid that it was trained on, and a consumer has to distinguish the two. [`super::Header::known`] gives the set
/// of a model.
///
/// ```
/// use meniscus::blob::{FieldGroup, KnownGroups};
///
/// let known = KnownGroups::NONE.with(FieldGroup::Surface);
/// assert!(known.contains(FieldGroup::Surface) && !known.contains(FieldGroup::ShearStress));
/// assert_eq!(known.bits(), 0b10_0000);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct KnownGroups(u8);

impl KnownGroups {
    /// Every group: all blobs before format version 4, and every model that was trained on its own liquid.
    pub const ALL: Self = Self(0b11_1111);
    /// No group.
    pub const NONE: Self = Self(0);
    /// The surface and the positions of the tracers: what a correction from the free surface teaches.
    ///
    /// Measured on water that was corrected from two recordings, errors on a third: q 18 %, v 48 %, e 180 %, sigma 1970 %, tau
    /// 100000 %. The surface fixes where the liquid is. The layers at the wall, and with them the velocity between the surface
    /// points, the stress and the heat, depend on a viscosity that the decoder has of another liquid.
    pub const KINEMATICS: Self = Self::NONE.with(FieldGroup::Position).with(FieldGroup::Surface);

    /// The set with `group` added.
    #[must_use]
    pub const fn with(self, group: FieldGroup) -> Self {
        Self(self.0 | group.bit())
    }

    /// Whether `group` is known.
    #[must_use]
    pub const fn contains(self, group: FieldGroup) -> bool {
        self.0 & group.bit() != 0
    }

    /// The groups that are in both sets.
    #[must_use]
    pub const fn both(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    /// The field groups of the set, for the decoder.
    #[must_use]
    pub fn selection(self) -> Selection {
        let groups = FieldGroup::ALL.into_iter().enumerate();
        let known = groups.filter(|(_, group)| self.contains(*group));
        known.fold(Selection::NONE, |selection, (index, _)| selection.with(index))
    }

    /// Whether the slosh energy is known: its kinetic part is the sum over the velocities.
    #[must_use]
    pub const fn slosh_energy(self) -> bool {
        self.contains(FieldGroup::Velocity)
    }

    /// Whether heat, entropy and dissipation are known: they are sums over the internal energy.
    #[must_use]
    pub const fn heat(self) -> bool {
        self.contains(FieldGroup::InternalEnergy)
    }

    /// Bit 0 for q, then v, e, sigma, tau, and bit 5 for the surface.
    #[must_use]
    pub const fn bits(self) -> u8 {
        self.0
    }

    /// Refuses bits of groups that do not exist.
    ///
    /// # Errors
    /// [`LoadError::HeaderValue`].
    pub(super) fn check(self) -> Result<(), LoadError> {
        if self.0 & !Self::ALL.0 == 0 {
            return Ok(());
        }
        Err(LoadError::HeaderValue { field: "known_groups", value: f64::from(self.0) })
    }
}

impl Default for KnownGroups {
    fn default() -> Self {
        Self::ALL
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn six_groups_make_the_whole_set() {
        let all = FieldGroup::ALL.into_iter().fold(KnownGroups::NONE, KnownGroups::with);
        assert_eq!(all, KnownGroups::ALL);
        for group in FieldGroup::ALL {
            assert!(KnownGroups::ALL.contains(group) && !KnownGroups::NONE.contains(group));
        }
    }

    #[test]
    fn a_total_is_known_with_the_group_that_it_is_a_sum_of() {
        assert!(KnownGroups::ALL.slosh_energy() && KnownGroups::ALL.heat());
        assert!(!KnownGroups::KINEMATICS.slosh_energy() && !KnownGroups::KINEMATICS.heat());
        let velocity = KnownGroups::KINEMATICS.with(FieldGroup::Velocity);
        assert!(velocity.slosh_energy() && !velocity.heat());
        assert_eq!(velocity.both(KnownGroups::KINEMATICS), KnownGroups::KINEMATICS);
    }

    #[test]
    fn bits_of_no_group_are_refused() {
        assert_eq!(KnownGroups::ALL.check(), Ok(()));
        let refusal = LoadError::HeaderValue { field: "known_groups", value: 64.0 };
        assert_eq!(KnownGroups(64).check(), Err(refusal));
    }
}
