//! Effects of the glass and its place: inclined, accelerated upwards, filled to another height.
//!
//! ```text
//! tilt theta, acceleration a:   body force in the frame of the glass  (g + a) (sin theta, 0, -cos theta)
//! ```
//! The potential energy is that of this constant force, which therefore does no work in the books; the
//! surface at rest has the slope `tan theta`.

use super::Laws;
use meniscus_data::motion::Kinematics;
use meniscus_data::recording::Glass;

/// `glass` with the fill that the effects give it.
pub(crate) fn glass_with(laws: &Laws, glass: Glass) -> Glass {
    Glass { fill_m: laws.fill_m.unwrap_or(glass.fill_m), ..glass }
}

/// `motion` of the glass with what is constant added.
pub(crate) fn motion_with(laws: &Laws, mut motion: Kinematics) -> Kinematics {
    motion.tilt_rad += laws.tilt_rad;
    motion.acceleration_m_s2[2] += laws.lift_m_s2;
    motion
}

/// Returns the largest height of the surface at rest above the fill on the wall, m.
pub(crate) fn rise_m(laws: &Laws, glass: &Glass) -> f64 {
    glass.radius_at(glass.fill_m) * laws.tilt_rad.tan().abs()
}
