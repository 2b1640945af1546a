//! Corrections of the plain sums: exact gradients up to the free surface, the smooth part of the velocity, the density of the
//! positions.
//!
//! ```text
//! moments --> corrected   gradients of pressure and continuity
//!         --> smooth      velocity gradient, so that friction acts on the jitter alone
//!         --> positions   density that the flow's density is called back to
//! ```

mod corrected;
mod moments;
mod positions;
mod smooth;

pub(crate) use corrected::Corrected;
pub(crate) use moments::Moments;
pub(crate) use positions::PositionDensity;
pub(crate) use smooth::{Gradients, NOISE, share};
