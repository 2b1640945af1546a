//! Layout of the filter's state vector.

use crate::latent::generic::LATENTS;
use nalgebra::{SMatrix, SVector};

/// Numbers of the state: the latents, then one for each [`StateIndex`].
pub(super) const STATES: usize = LATENTS + StateIndex::ALL.len();

/// Matrix on the state.
pub(super) type StateMatrix<R = f64> = SMatrix<R, STATES, STATES>;

/// Vector of the state, of a change of it, or of a measurement's slopes in it.
pub(super) type StateVector<R = f64> = SVector<R, STATES>;

/// Position of a number behind the latents.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(usize)]
pub(super) enum StateIndex {
    /// Input u of this instant.
    Input = LATENTS,
    /// Input of the instant before.
    InputLag1,
    /// Input of two instants before.
    InputLag2,
    /// Travel W of the glass in one turn.
    GlassTravel,
    /// Position X of the glass.
    GlassPosition,
    /// Cross-axis slosh Y.
    Lateral,
    /// Cross-axis slosh of the instant before.
    LateralLag,
}

impl StateIndex {
    /// All of them, in their order.
    pub(super) const ALL: [Self; 7] = [
        Self::Input,
        Self::InputLag1,
        Self::InputLag2,
        Self::GlassTravel,
        Self::GlassPosition,
        Self::Lateral,
        Self::LateralLag,
    ];

    /// Position in a [`StateVector`].
    pub(super) const fn index(self) -> usize {
        self as usize
    }

    /// Returns the state at position `index`; `None` for a latent.
    pub(super) fn at(index: usize) -> Option<Self> {
        Self::ALL.get(index.checked_sub(LATENTS)?).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_position_names_itself() {
        for (k, index) in StateIndex::ALL.into_iter().enumerate() {
            assert_eq!(index.index(), LATENTS + k);
            assert_eq!(StateIndex::at(index.index()), Some(index));
        }
        assert_eq!(StateIndex::at(LATENTS - 1), None);
        assert_eq!(StateIndex::at(STATES), None);
    }
}
