//! Walls are mirrors: behind a wall stands the image of the liquid before it.
//!
//! With `n` the outward normal of the wall:
//! ```text
//! place       side  x_g = x + 2 y n,  V_g = V r_g/r      bottom  z_g = -z        corner  both
//! pressure    p_g = p + rho g.(x_g - x)                  g the body force of the moving frame
//! no flow     v_g = v - 2 (v.n) n                        what continuity sees
//! slip        v_s = v_g, azimuthal part times r_g/r      without shear stress
//! no slip     v_n = -f v                                 delta = sqrt(2 nu/omega_1), f below
//! friction    s v_n + (1 - s) v_s,   s = y/(y + b)       what friction sees, slip length b (Navier 1823)
//! ```
//! with `y` the distance of the particle from the wall; `u = (b + y) du/dn` continues to `(b - y) du/dn`.
//!
//! Images are exchanged with their originals in both the momentum and the continuity equation, so a
//! plane wall conserves energy exactly and a round one to a few per cent of what it exchanges (which
//! is booked). Fixed wall particles (Adami, Hu and Adams 2012, J. Comput. Phys. 231, 7057) stood here
//! before: they stand still in the continuity equation, which moves the wall a quarter of a spacing
//! outward (first mode -1.8 %), and lost half of the energy of a slosh per second.
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

use super::slip::stick;
use crate::frame::Body;
use crate::particles::tensor::{Symmetric, mirrored};
use crate::particles::{Fluid, Particle};
use meniscus::reduced::{Cylinder, SloshMode, Wave};
use meniscus::units::GRAVITY_M_S2;
use meniscus_data::recording::Glass;
use rayon::prelude::*;

/// Without viscosity there is no layer, and what this bounds is multiplied by nothing.
const LAYERS: f64 = 1e6;

/// Returns `f`, the velocity behind a wall over that before it with its sign changed, at a distance of so many `layers`.
fn behind(layers: f64) -> f64 {
    // What blows up has densities below zero and no number here: it is for the check of the positions to tell.
    let layers = if layers > 1e-6 { layers.min(LAYERS) } else { 1e-6 };
    2.0 * layers / -(-layers).exp_m1() - 1.0
}

/// Original of an image, and the walls that mirror it.
#[derive(Clone, Copy, Debug)]
struct Origin {
    particle: u32,
    side: bool,
    bottom: bool,
}

impl Origin {
    /// The velocity `v` behind the walls that mirror it, the side wall with the outward normal `n`.
    fn mirror(self, n: &[f64; 3], v: &[f64; 3]) -> [f64; 3] {
        let mut out = *v;
        if self.side {
            let normal: f64 = n.iter().zip(v).map(|(n, v)| n * v).sum();
            for (out, n) in out.iter_mut().zip(n) {
                *out -= 2.0 * normal * n;
            }
        }
        if self.bottom {
            out[2] = -out[2];
        }
        out
    }
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

/// One image as friction sees it.
struct Behind {
    /// Cosine and sine of the azimuth, and the radius of the image over that of its original, less 1.
    around: Option<[f64; 3]>,
    /// Share by which the liquid sticks.
    stuck: f64,
    /// `stuck f`.
    odd: f64,
}

impl Behind {
    /// For the image of `origin` at `image_radius` m from the axis.
    fn new(glass: &Glass, liquid: &Fluid, origin: &Origin, image_radius: f64, sticking: Sticking) -> Self {
        let i = origin.particle as usize;
        let x = &liquid.particle[i].x;
        let mut distance = x[2];
        let around = origin.side.then(|| {
            distance = to_side(glass, x).0;
            let r = radius(x);
            [x[0] / r, x[1] / r, image_radius / r - 1.0]
        });
        let stuck = stick(sticking.slip_m, distance);
        let layers = sticking.layers(distance, liquid.density[i], liquid.viscosity[i]);
        Self { around, stuck, odd: stuck * behind(layers) }
    }

    /// The velocity that friction sees of an original that moves with `v` and is mirrored to `image`.
    fn velocity(&self, v: &[f64; 3], image: &[f64; 3]) -> [f64; 3] {
        let mut shear_free = *image;
        if let Some([cos, sin, farther]) = self.around {
            let around = farther * (v[1] * cos - v[0] * sin);
            shear_free[0] -= around * sin;
            shear_free[1] += around * cos;
        }
        std::array::from_fn(|k| (1.0 - self.stuck) * shear_free[k] - self.odd * v[k])
    }
}

/// The images of the liquid.
#[derive(Clone, Debug, Default)]
pub(crate) struct Walls {
    origin: Vec<Origin>,
    /// The images as continuity and pressure see them.
    pub(crate) image: Vec<Particle>,
    /// Their velocities as friction sees them, m/s.
    pub(crate) rubbing: Vec<[f64; 3]>,
    /// `p L` of the images (see `corrected`), Pa.
    pub(crate) pressure: Vec<Symmetric>,
}

/// A linear map from the velocity of an original to that of its image, by rows.
pub(crate) type Map = [[f64; 3]; 3];

impl Walls {
    /// Lists the particles nearer to a wall than `reach_m`, whose images can act; above the rim there is no wall.
    pub(crate) fn list(&mut self, glass: &Glass, reach_m: f64, particles: &[Particle]) {
        self.origin.clear();
        for (particle, p) in (0..).zip(particles) {
            let below = p.x[2] <= glass.rim_m;
            let (side, bottom) = (below && to_side(glass, &p.x).0 < reach_m, p.x[2] < reach_m);
            let walls = [(true, false), (false, true), (true, true)];
            let seen = walls.into_iter().filter(|(s, b)| side >= *s && bottom >= *b);
            self.origin.extend(seen.map(|(side, bottom)| Origin { particle, side, bottom }));
        }
        let nothing = Particle { x: [0.0; 3], v: [0.0; 3], volume: 0.0, p: 0.0 };
        self.image.resize(self.origin.len(), nothing);
        self.rubbing.resize(self.origin.len(), [0.0; 3]);
    }

    /// Makes the images of the present state under the body force `body`.
    pub(crate) fn reflect(&mut self, glass: &Glass, liquid: &Fluid, body: &Body) {
        let images = self.image.par_iter_mut().zip(&self.origin).with_min_len(256);
        images.for_each(|(image, origin)| {
            let original = &liquid.particle[origin.particle as usize];
            *image = *original;
            if origin.side {
                let (y, n) = to_side(glass, &original.x);
                image.v = origin.mirror(&n, &original.v);
                for (x, n) in image.x.iter_mut().zip(n) {
                    *x += 2.0 * y * n;
                }
                image.volume *= radius(&image.x) / radius(&original.x);
            }
            if origin.bottom {
                image.x[2] = -image.x[2];
                if !origin.side {
                    image.v[2] = -image.v[2];
                }
            }
            let [g_x, g_y, g_z] = body.still(&image.x);
            let [d_x, d_y, d_z] = [0, 1, 2].map(|k| image.x[k] - original.x[k]);
            let lift = g_x * d_x + g_y * d_y + g_z * d_z;
            image.p += liquid.density[origin.particle as usize] * lift;
        });
    }

    /// Gives the images the velocities that friction sees where the liquid sticks as `sticking` says.
    pub(crate) fn rub(&mut self, glass: &Glass, liquid: &Fluid, sticking: Sticking) {
        let Self { origin, image, rubbing, .. } = self;
        let images = rubbing.par_iter_mut().zip(&*image).zip(&*origin).with_min_len(256);
        images.for_each(|((rubbing, image), origin)| {
            let original = &liquid.particle[origin.particle as usize];
            let behind = Behind::new(glass, liquid, origin, radius(&image.x), sticking);
            *rubbing = behind.velocity(&original.v, &image.v);
        });
    }

    /// Fills `maps` with the linear map from the velocity of each original to that of its image, where the liquid sticks as
    /// `sticking` says.
    pub(crate) fn map(&self, glass: &Glass, liquid: &Fluid, sticking: Sticking, maps: &mut Vec<Map>) {
        let images = self.image.par_iter().zip(&self.origin).with_min_len(256);
        let found = images.map(|(image, origin)| {
            let original = &liquid.particle[origin.particle as usize];
            let behind = Behind::new(glass, liquid, origin, radius(&image.x), sticking);
            let n = to_side(glass, &original.x).1;
            let columns = [0, 1, 2].map(|axis| {
                let v: [f64; 3] = std::array::from_fn(|k| f64::from(u8::from(k == axis)));
                behind.velocity(&v, &origin.mirror(&n, &v))
            });
            std::array::from_fn(|row| std::array::from_fn(|column| columns[column][row]))
        });
        found.collect_into_vec(maps);
    }

    /// Fills `out` with the velocities of the images under `maps` of originals that move with `v`.
    pub(crate) fn mapped(&self, maps: &[Map], v: impl Fn(usize) -> [f64; 3], out: &mut Vec<[f64; 3]>) {
        out.clear();
        out.extend(self.origin.iter().zip(maps).map(|(origin, map)| {
            let v = v(origin.particle as usize);
            map.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
        }));
    }

    /// The original of image `w`.
    pub(crate) fn original(&self, w: usize) -> usize {
        self.origin[w].particle as usize
    }

    /// Fills `pressure` with `L` of the particles: `L` is mirrored with its particle.
    pub(crate) fn press(&mut self, glass: &Glass, particle: &[Particle], l: &[Symmetric]) {
        let Self { origin, image, pressure, .. } = self;
        pressure.clear();
        pressure.extend(origin.iter().zip(&*image).map(|(origin, image)| {
            let i = origin.particle as usize;
            let mut l = l[i];
            if origin.side {
                l = mirrored(&l, &to_side(glass, &particle[i].x).1);
            }
            if origin.bottom {
                // z changes its sign.
                (l[2], l[4]) = (-l[2], -l[4]);
            }
            l.map(|l| image.p * l)
        }));
    }
}

/// Angular frequency of the first mode of the glass at rest, rad/s.
fn first_mode(glass: &Glass) -> f64 {
    // The frequency does not depend on the density.
    let (radius_m, depth_m) = (glass.radius_at(glass.fill_m), glass.fill_m);
    SloshMode::new(&Cylinder { radius_m, depth_m, density_kg_m3: 1.0 }, Wave::First(0))
        .square(GRAVITY_M_S2)
        .sqrt()
}

/// Distance from the axis, m, and never nothing.
fn radius(x: &[f64; 3]) -> f64 {
    (x[0] * x[0] + x[1] * x[1]).sqrt().max(1e-9)
}

/// Distance from the side wall and its outward normal.
fn to_side(glass: &Glass, x: &[f64; 3]) -> (f64, [f64; 3]) {
    let r = radius(x);
    let length = (1.0 + glass.taper * glass.taper).sqrt();
    let y = (glass.radius_at(x[2]) - r) / length;
    (y, [x[0] / r / length, x[1] / r / length, -glass.taper / length])
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
