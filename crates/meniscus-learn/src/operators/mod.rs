//! Operators of the GENERIC step: linear fit, warm start, roll-out training, constant-gain filter, checks of the laws.

pub(crate) mod filter;
pub(crate) mod friction_law;
pub(crate) mod law_tensors;
pub(crate) mod laws;
pub(crate) mod linear;
pub(crate) mod open_loop;
pub(crate) mod precondition;
pub(crate) mod reference_step;
pub(crate) mod rollout;
pub(crate) mod soft;
pub(crate) mod unrolled;
pub(crate) mod warm;
