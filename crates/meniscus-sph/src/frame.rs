//! The body force in the frame of a glass that is moved anyhow and turned in the x-z plane.
//!
//! ```text
//! f = Q^T (g - A) - alpha x r - omega x (omega x r) - 2 omega x v
//! ```
//! with `Q` the rotation by the tilt `theta` about +y (the rim goes towards +x), `A` the acceleration of
//! the pivot, `omega = theta' e_y`, `alpha = theta'' e_y`, `r` the place from the pivot (Landau and
//! Lifshitz, Mechanics, paragraph 39). In components, `r = (x, y, z)`:
//! ```text
//! f_x =  (g + A_z) sin theta - A_x cos theta - theta'' z + theta'^2 x - 2 theta' v_z
//! f_y = -A_y
//! f_z = -(g + A_z) cos theta - A_x sin theta + theta'' x + theta'^2 z + 2 theta' v_x
//! ```

use meniscus::units::GRAVITY_M_S2;
use meniscus_data::motion::Kinematics;

/// The body force of one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Body {
    /// The part that is the same everywhere, m/s2.
    pub(crate) uniform: [f64; 3],
    spin: Option<Spin>,
}

/// A turning frame.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Spin {
    rate: f64,
    acceleration: f64,
    pivot_m: [f64; 2],
}

impl Body {
    /// The body force under `motion`.
    pub(crate) fn of(motion: &Kinematics) -> Self {
        let Kinematics { tilt_rad, tilt_rate, tilt_acceleration, pivot_m, .. } = *motion;
        let [a_x, a_y, a_z] = motion.acceleration_m_s2;
        let (sin, cos) = tilt_rad.sin_cos();
        let weight = GRAVITY_M_S2 + a_z;
        let uniform = [weight * sin - a_x * cos, -a_y, -weight * cos - a_x * sin];
        let spins = tilt_rate != 0.0 || tilt_acceleration != 0.0;
        let spin = spins.then_some(Spin { rate: tilt_rate, acceleration: tilt_acceleration, pivot_m });
        Self { uniform, spin }
    }

    /// Whether the frame turns.
    pub(crate) fn turns(&self) -> bool {
        self.spin.is_some()
    }

    /// The force on liquid at rest in the glass at `x`, m/s2.
    #[inline]
    pub(crate) fn still(&self, x: &[f64; 3]) -> [f64; 3] {
        if self.spin.is_none() { self.uniform } else { self.at(x, &[0.0; 3]) }
    }

    /// The force on liquid at `x` that moves with `v` in the glass, m/s2.
    pub(crate) fn at(&self, x: &[f64; 3], v: &[f64; 3]) -> [f64; 3] {
        let [f_x, f_y, f_z] = self.uniform;
        let [e_x, e_z] = self.turning(x, v);
        [f_x + e_x, f_y, f_z + e_z]
    }

    /// The part of the force that comes from turning, along x and z, m/s2.
    pub(crate) fn turning(&self, x: &[f64; 3], v: &[f64; 3]) -> [f64; 2] {
        self.spin.map_or([0.0; 2], |Spin { rate, acceleration, pivot_m }| {
            let r = [x[0] - pivot_m[0], x[2] - pivot_m[1]];
            [
                -acceleration * r[1] + rate * rate * r[0] - 2.0 * rate * v[2],
                acceleration * r[0] + rate * rate * r[1] + 2.0 * rate * v[0],
            ]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A free particle, seen from a glass in any motion, must fall as it does in the room.
    #[test]
    fn a_free_particle_seen_from_the_glass_falls_in_the_room() {
        let pivot_m = [0.01, 0.02];
        // Pivot X = 0.3 t^2, Y = 0.2 t^2, Z = 0.1 t^3, theta = 0.2 + 0.5 t + 0.4 t^2.
        let motion = |t: f64| Kinematics {
            acceleration_m_s2: [0.6, 0.4, 0.6 * t],
            tilt_rad: 0.2 + 0.5 * t + 0.4 * t * t,
            tilt_rate: 0.5 + 0.8 * t,
            tilt_acceleration: 0.8,
            pivot_m,
        };
        // In the glass from the room: r = Q^T (x - X).
        let seen = |t: f64| {
            let d = [0.05 + 0.1 * t - 0.3 * t * t, 0.03 - 0.5 * GRAVITY_M_S2 * t * t - 0.1 * t * t * t];
            let (sin, cos) = motion(t).tilt_rad.sin_cos();
            [pivot_m[0] + d[0] * cos - d[1] * sin, 0.1 - 0.2 * t * t, pivot_m[1] + d[0] * sin + d[1] * cos]
        };
        let (t, h) = (0.13, 1e-4);
        let [before, at, after] = [t - h, t, t + h].map(seen);
        let v: [f64; 3] = std::array::from_fn(|k| (after[k] - before[k]) / (2.0 * h));
        let force = Body::of(&motion(t)).at(&at, &v);
        for k in 0..3 {
            let acceleration = (after[k] - 2.0 * at[k] + before[k]) / (h * h);
            assert!((force[k] - acceleration).abs() < 1e-5, "{} for {acceleration} along {k}", force[k]);
        }
    }

    #[test]
    fn a_glass_moved_along_x_has_the_plain_force() {
        let body = Body::of(&Kinematics::along_x(1.7));
        assert_eq!((body.uniform, body.turns()), ([-1.7, -0.0, -GRAVITY_M_S2], false));
    }
}
