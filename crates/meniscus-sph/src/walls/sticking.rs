//! Velocities behind a wall to which the liquid sticks.
//!
//! No slip: an odd image, `-v`, holds for a straight profile, whose friction is `mu (1 + f) v/2y` with `f = 1`. The layer at
//! the wall of a slosh is Stokes's, `v = U (1 - e^(-y/delta))` with the friction `mu U/delta` in step with `U` (Stokes 1851;
//! Lamb, Hydrodynamics, 345). The image that gives this friction at any distance is `-f v` with
//! ```text
//! f = 2 (y/delta)/(1 - e^(-y/delta)) - 1       -> 1 inside the layer,  2 y/delta - 1 outside of it
//! ```
//! and `1/delta = Re sqrt(i omega_1 rho/eta)` at the first mode, `eta` the viscosity with that of an elastic stress: 8.2 mm for glycerine, 0.3 mm for water, which the particles do not see at all. Decay of the
//! first mode at 5 mm: glycerine -1.3 %, 0.3 Pa s -9 %, 1 mPa s +0.6 % (a sixth of it the numerical viscosity's). With `-v`
//! glycerine has -5.4 %, with `-2 v` +3.9 %, and 1 mPa s, by the formula, an eighth of its friction. What flows steadily for longer
//! than a slosh rubs too much.

use super::origin::{Origin, bulge, radius};
use super::slip::stick;
use crate::particles::Fluid;
use meniscus::reduced::{Cylinder, SloshMode, Wave};
use meniscus::units::GRAVITY_M_S2;
use meniscus_data::glass::Glass;
use std::f64::consts::PI;

/// Without viscosity there is no layer, and what this bounds is multiplied by nothing.
const LAYERS: f64 = 1e6;

/// Returns `f`, the velocity behind a wall over that before it with its sign changed, at a distance of so many `layers`.
fn behind(layers: f64) -> f64 {
    // What blows up has densities below zero and no number here: it is for the check of the positions to tell.
    let layers = if layers > 1e-6 { layers.min(LAYERS) } else { 1e-6 };
    2.0 * layers / -(-layers).exp_m1() - 1.0
}

/// Sticking of the liquid to the walls.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sticking {
    /// Slip length, m.
    slip_m: f64,
    /// Half of the angular frequency of the Stokes layers at the walls, rad/s; zero for straight profiles.
    half_omega: f64,
    /// Dissipating and storing part of the viscosity of an elastic stress at that frequency, Pa s.
    elastic: [f64; 2],
}

impl Sticking {
    /// With the Stokes layers of the first mode of `glass`, which friction between pairs needs. An elastic stress of the viscosity
    /// `elastic(omega)` makes them thicker.
    pub(crate) fn new(glass: &Glass, slip_m: f64, elastic: impl Fn(f64) -> [f64; 2]) -> Self {
        let omega = first_mode(glass);
        Self { slip_m, half_omega: 0.5 * omega, elastic: elastic(omega) }
    }

    /// With the profile that the particles show, odd across the wall.
    pub(crate) fn straight(self) -> Self {
        Self { half_omega: 0.0, ..self }
    }

    /// The distance `y_m` from the wall in thicknesses of the layer, in a liquid of `density` and `viscosity`:
    /// `Re sqrt(i omega rho/(a - i b)) = sqrt(omega rho/(2 |a - i b|) (1 - b/|a - i b|))`.
    fn layers(&self, y_m: f64, density: f64, viscosity: f64) -> f64 {
        let [lost, stored] = self.elastic;
        let size = (viscosity + lost).hypot(stored);
        y_m.max(0.0) * (self.half_omega * density / size * (1.0 - stored / size)).sqrt()
    }
}

/// A round side wall between an original and its image.
struct Around {
    /// Cosine and sine of the azimuth.
    azimuth: [f64; 2],
    /// The radius of the image over that of its original, less 1.
    farther: f64,
    /// Outward normal of the wall.
    normal: [f64; 3],
    /// [`bulge`], less 1.
    along: f64,
}

/// One image as friction sees it.
pub(super) struct Behind {
    /// The side wall that mirrors it.
    around: Option<Around>,
    /// Share by which the liquid sticks.
    stuck: f64,
    /// `stuck f`.
    odd: f64,
}

impl Behind {
    /// For the image of `origin` at `image_radius` m from the axis.
    pub(super) fn new(
        glass: &Glass,
        liquid: &Fluid,
        origin: &Origin,
        image_radius: f64,
        sticking: Sticking,
    ) -> Self {
        let i = origin.particle as usize;
        let x = &liquid.particle[i].x;
        let mut distance = x[2];
        let around = origin.side.then(|| {
            let side = origin.wall(glass, x);
            distance = side.distance_m;
            let r = radius(x);
            Around {
                azimuth: [x[0] / r, x[1] / r],
                farther: image_radius / r - 1.0,
                normal: side.normal,
                along: bulge(&side) - 1.0,
            }
        });
        let stuck = stick(sticking.slip_m, distance);
        let layers = sticking.layers(distance, liquid.density[i], liquid.viscosity[i]);
        Self { around, stuck, odd: stuck * behind(layers) }
    }

    /// The velocity that friction sees of an original that moves with `v` and is mirrored to `image`.
    pub(super) fn velocity(&self, v: &[f64; 3], image: &[f64; 3]) -> [f64; 3] {
        let mut shear_free = *image;
        if let Some(Around { azimuth: [cos, sin], farther, normal, along }) = &self.around {
            let around = v[1] * cos - v[0] * sin;
            shear_free[0] -= farther * around * sin;
            shear_free[1] += farther * around * cos;
            if *along != 0.0 {
                // What is left along the wall: neither around the axis nor into the wall.
                let into: f64 = normal.iter().zip(v).map(|(n, v)| n * v).sum();
                let rest = [v[0] + around * sin, v[1] - around * cos, v[2]];
                for ((out, v), n) in shear_free.iter_mut().zip(rest).zip(normal) {
                    *out += along * (v - into * n);
                }
            }
        }
        std::array::from_fn(|k| (1.0 - self.stuck) * shear_free[k] - self.odd * v[k])
    }
}

/// Angular frequency of the first mode of the glass at rest, rad/s.
fn first_mode(glass: &Glass) -> f64 {
    // The frequency does not depend on the density.
    let radius_m = glass.radius_at(glass.fill_m);
    // The depth of a cylinder with as much liquid under this surface.
    let depth_m = glass.volume_m3(0.0, glass.fill_m) / (PI * radius_m * radius_m);
    SloshMode::new(&Cylinder { radius_m, depth_m, density_kg_m3: 1.0 }, Wave::First(0))
        .square(GRAVITY_M_S2)
        .sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_behind_a_wall_gives_the_friction_of_a_stokes_layer_before_it() {
        for layers in [0.01, 0.3, 1.0, 3.0, 30.0] {
            let before = 1.0 - f64::exp(-layers);
            let friction = (1.0 + behind(layers)) * before / (2.0 * layers);
            assert!((friction - 1.0).abs() < 1e-9, "{friction} at {layers} layers");
        }
        assert!((behind(0.0) - 1.0).abs() < 1e-5, "{}", behind(0.0));
        assert!(behind(f64::NAN).is_finite() && behind(f64::INFINITY).is_finite());
    }
}
