//! Field groups of the decoder trunk, in its order.

/// Names of the trunk groups.
pub(crate) const TRUNK: [&str; 5] = ["q", "v", "sigma", "tau", "surface"];

/// Index of the normal stresses among [`TRUNK`].
pub(crate) const SIGMA: usize = 2;

/// Index of the surface among [`TRUNK`].
pub(crate) const SURFACE: usize = 4;

/// Index in a recording's state of each trunk group but the surface.
pub(crate) const IN_STATE: [usize; 4] = [0, 1, 3, 4];
