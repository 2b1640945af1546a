//! From images to the liquid's edge: 21 heights above the bottom of the glass.

mod profile;

pub use profile::{POINTS, PROFILE_HALF_SPAN, SurfaceProfile, profile_abscissa};
