//! Walls are mirrors: behind a wall stands the image of the liquid before it.
//!
//! With `n` the outward normal of the wall:
//! ```text
//! place       side  x_g = x + 2 y n,  V_g = V k r_g/r    bottom  z_g = -z        corner  both
//! pressure    p_g = p + rho g.(x_g - x)                  g the body force of the moving frame
//! no flow     v_g = v - 2 (v.n) n                        what continuity sees
//! slip        v_s = v_g, azimuthal part times r_g/r, meridional part times k: without shear stress
//! no slip     v_n = -f v                                 f of [`super::sticking`]
//! friction    s v_n + (1 - s) v_s,   s = y/(y + b)       what friction sees, slip length b (Navier 1823)
//! ```
//! with `y` the distance of the particle from the wall; `u = (b + y) du/dn` continues to `(b - y) du/dn`. `k = (1 + c y)/(1 - c y)` for a
//! wall of the curvature `c` in the plane through the axis, and 1 where it is straight. A bottom that goes round into the side is one
//! wall, seen where it is nearest.
//!
//! Images are exchanged with their originals in both the momentum and the continuity equation, so a
//! plane wall conserves energy exactly and a round one to a few per cent of what it exchanges (which
//! is booked). Fixed wall particles (Adami, Hu and Adams 2012, J. Comput. Phys. 231, 7057) stood here
//! before: they stand still in the continuity equation, which moves the wall a quarter of a spacing
//! outward (first mode -1.8 %), and lost half of the energy of a slosh per second.

use super::origin::{Origin, bulge, radius};
use super::sticking::{Behind, Sticking};
use crate::frame::Body;
use crate::particles::lanes::{Single, row};
use crate::particles::tensor::{Symmetric, mirrored};
use crate::particles::{Fluid, Particle};
use meniscus_data::glass::Glass;
use rayon::prelude::*;

/// The images of the liquid.
#[derive(Clone, Debug, Default)]
pub(crate) struct Walls {
    origin: Vec<Origin>,
    /// The images as continuity and pressure see them.
    pub(crate) image: Vec<Particle>,
    /// Their velocities as friction sees them, m/s.
    pub(crate) rubbing: Vec<[f64; 3]>,
    /// The images with the first component of that velocity in place of the pressure.
    pub(crate) rubbed: Vec<Single<8>>,
    /// `p L` of the images (see `corrected`), Pa, and the other two components of that velocity, m/s.
    pub(crate) pressure: Vec<Single<8>>,
}

/// A linear map from the velocity of an original to that of its image, by rows.
pub(crate) type Map = [[f64; 3]; 3];

impl Walls {
    /// Lists the particles nearer to a wall than `reach_m`, whose images can act; above the rim there is no wall.
    pub(crate) fn list(&mut self, glass: &Glass, reach_m: f64, particles: &[Particle]) {
        self.origin.clear();
        let corner = glass.has_corner();
        for (particle, p) in (0..).zip(particles) {
            let below = p.x[2] <= glass.rim_m;
            let near = if below { glass.side_within(&p.x, reach_m) } else { None };
            let (mut side, mut bottom) = (near.is_some(), p.x[2] < reach_m);
            if let (false, Some(near), true) = (corner, near, bottom) {
                // One round wall, seen where it is nearest.
                (side, bottom) = (near.distance_m <= p.x[2], near.distance_m > p.x[2]);
            }
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
                let side = origin.wall(glass, &original.x);
                image.v = origin.mirror(&side.normal, &original.v);
                for (x, n) in image.x.iter_mut().zip(side.normal) {
                    *x += 2.0 * side.distance_m * n;
                }
                image.volume *= radius(&image.x) / radius(&original.x);
                if side.curvature != 0.0 {
                    image.volume *= bulge(&side);
                }
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

    /// Gives the images the velocities of [`Self::rub`], by the `maps` of [`Self::map`].
    pub(crate) fn rub_by(&mut self, maps: &[Map], particle: &[Particle]) {
        let mut rubbing = std::mem::take(&mut self.rubbing);
        rubbing.clear();
        rubbing.extend(self.mapped(maps, |i| particle[i].v));
        self.rubbing = rubbing;
    }

    /// Fills `maps` with the linear map from the velocity of each original to that of its image, where the liquid sticks as
    /// `sticking` says.
    pub(crate) fn map(&self, glass: &Glass, liquid: &Fluid, sticking: Sticking, maps: &mut Vec<Map>) {
        let images = self.image.par_iter().zip(&self.origin).with_min_len(256);
        let found = images.map(|(image, origin)| {
            let original = &liquid.particle[origin.particle as usize];
            let behind = Behind::new(glass, liquid, origin, radius(&image.x), sticking);
            let n = origin.wall(glass, &original.x).normal;
            let columns = [0, 1, 2].map(|axis| {
                let v: [f64; 3] = std::array::from_fn(|k| f64::from(u8::from(k == axis)));
                behind.velocity(&v, &origin.mirror(&n, &v))
            });
            std::array::from_fn(|row| std::array::from_fn(|column| columns[column][row]))
        });
        found.collect_into_vec(maps);
    }

    /// Returns the velocities of the images under `maps` of originals that move with `v`.
    pub(crate) fn mapped(
        &self,
        maps: &[Map],
        v: impl Fn(usize) -> [f64; 3],
    ) -> impl Iterator<Item = [f64; 3]> {
        self.origin.iter().zip(maps).map(move |(origin, map)| {
            let v = v(origin.particle as usize);
            map.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
        })
    }

    /// The original of image `w`.
    pub(crate) fn original(&self, w: usize) -> usize {
        self.origin[w].particle as usize
    }

    /// Fills what the momentum equation takes from the images, with `L` of the particles: `L` is mirrored with its particle.
    pub(crate) fn press(&mut self, glass: &Glass, particle: &[Particle], l: &[Symmetric]) {
        let Self { origin, image, rubbing, rubbed, pressure } = self;
        let images = image.par_iter().zip(&*rubbing).zip(&*origin).with_min_len(256);
        images
            .map(|((image, rubbing), origin)| {
                let i = origin.particle as usize;
                let mut l = l[i];
                if origin.side {
                    l = mirrored(&l, &origin.wall(glass, &particle[i].x).normal);
                }
                if origin.bottom {
                    // z changes its sign.
                    (l[2], l[4]) = (-l[2], -l[4]);
                }
                let [xx, xy, xz, yy, yz, zz] = l.map(|l| image.p * l);
                let [u, v, w] = *rubbing;
                (row(image, u), Single::of([xx, xy, xz, yy, yz, zz, v, w]))
            })
            .unzip_into_vecs(rubbed, pressure);
    }
}
