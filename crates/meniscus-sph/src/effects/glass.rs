//! Effects of the glass and its place: inclined, accelerated upwards, filled to another height.
//!
//! ```text
//! tilt theta, acceleration a:   body force in the frame of the glass  (g + a) (sin theta, 0, -cos theta)
//! ```
//! The potential energy is that of this constant force, which therefore does no work in the books; the
//! surface at rest has the slope `tan theta`.

use meniscus_data::effects::Effects;
use meniscus_data::motion::Kinematics;
use meniscus_data::recording::Glass;

/// `glass` with the fill that the effects give it.
pub(crate) fn glass_with(effects: &Effects, glass: Glass) -> Glass {
    Glass { fill_m: effects.fill.unwrap_or(glass.fill_m), ..glass }
}

/// `motion` of the glass with what is constant added.
pub(crate) fn motion_with(effects: &Effects, mut motion: Kinematics) -> Kinematics {
    motion.tilt_rad += effects.container_tilt.unwrap_or(0.0);
    motion.acceleration_m_s2[2] += effects.vertical_acceleration.unwrap_or(0.0);
    motion
}

/// How high the surface at rest stands above the fill on the wall, m.
pub(crate) fn rise_m(effects: &Effects, glass: &Glass) -> f64 {
    glass.radius_at(glass.fill_m) * effects.container_tilt.unwrap_or(0.0).tan().abs()
}
