//! Corrections of the plain sums over neighbours.
//!
//! ```text
//! moments --> corrected   gradients of pressure and continuity
//!         --> smooth      velocity gradient, so that friction acts on the jitter alone
//!         --> positions   density that the flow's density is called back to
//! ```
//! `completion` is a number where the sum needs no matrix: the share of neighbours that a free surface lacks.

mod completion;
mod corrected;
mod moments;
mod positions;
mod smooth;

pub(crate) use completion::completion;
pub(crate) use corrected::Corrected;
pub(crate) use moments::Moments;
pub(crate) use positions::PositionDensity;
pub(crate) use smooth::{Gradients, NOISE, share};
