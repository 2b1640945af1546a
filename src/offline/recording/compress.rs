//! A recording small enough to ship: each field group as a truncated singular value decomposition.

use super::{GROUP_COMPONENTS, STATE, group_range};
use crate::offline::prelude::*;

/// Rest state plus, for each group, `coefficients x modes`, truncated at a stated relative error.
#[derive(Clone, Debug)]
pub struct Factored {
    /// The reference that the product is added to, [`STATE`] numbers.
    pub reference: Vec<f32>,
    /// Frames x rank, row-major, one matrix a group.
    pub coefficients: [Vec<f32>; 5],
    /// Rank x numbers of the group, row-major, one matrix a group.
    pub modes: [Vec<f32>; 5],
    /// Relative L2 error of the truncation over the recording, by group.
    pub truncation: [f32; 5],
}

impl Factored {
    /// Number of modes kept in `group`.
    #[must_use]
    pub fn rank(&self, group: usize) -> usize {
        self.modes[group].len() / group_range(group).len()
    }

    /// Writes the full state of `frame` into `out` ([`STATE`] numbers).
    ///
    /// # Panics
    /// When `frame` or the length of `out` is out of range.
    pub fn state(&self, frame: usize, out: &mut [f32]) {
        assert_eq!(out.len(), STATE, "a full state has {STATE} numbers");
        out.copy_from_slice(&self.reference);
        for group in 0..GROUP_COMPONENTS.len() {
            let range = group_range(group);
            let (rank, width) = (self.rank(group), range.len());
            let row = &self.coefficients[group][frame * rank..(frame + 1) * rank];
            for (c, mode) in row.iter().zip(self.modes[group].chunks_exact(width)) {
                for (o, m) in out[range.clone()].iter_mut().zip(mode) {
                    *o += c * m;
                }
            }
        }
    }
}
