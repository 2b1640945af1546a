//! Modes of potential flow in a cylinder, and their integrals as sums over points.
//!
//! ```text
//! Phi = v cosh(kz)/(k sinh kh) phi(r) cos(m theta),     phi(r) = J_m(kr)/J_m(kR),     u = grad Phi        (Lamb 1932, article 257)
//! ```
//! The rate v is that of the surface at the wall.

use std::f64::consts::TAU;

/// Points of the quadratures: along the radius, around, and over the depth.
const RADII: usize = 12;
const ANGLES: usize = 16;
const DEPTHS: usize = 16;

/// Step of the differences that make strains of velocities, m.
const STEP_M: f64 = 1e-6;

/// Returns the Bessel function J_m by its power series, for arguments up to a dozen.
#[must_use]
pub fn bessel(order: u32, x: f64) -> f64 {
    let half = 0.5 * x;
    let mut term = (1..=order).fold(1.0, |term, j| term * half / f64::from(j));
    let mut sum = term;
    for j in 1..60 {
        term *= -half * half / (f64::from(j) * f64::from(j + order));
        sum += term;
    }
    sum
}

/// One mode of a cylinder of liquid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    /// Azimuthal order m.
    pub order: u32,
    /// Wave number, 1/m.
    pub k: f64,
    radius_m: f64,
    depth_m: f64,
}

/// Piece of the wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// Area, m2.
    pub area_m2: f64,
    /// Speed of the liquid along it at the unit rate of the mode.
    pub speed: f64,
}

/// Piece of the bulk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strained {
    /// Volume, m3.
    pub volume_m3: f64,
    /// Rate of shear `sqrt(2 e:e)` at the unit rate of the mode, 1/m.
    pub shear: f64,
}

impl Shape {
    /// Returns the mode of azimuthal `order` with the zero `xi` of its slope at the wall.
    #[must_use]
    pub fn new(order: u32, xi: f64, radius_m: f64, depth_m: f64) -> Self {
        Self { order, k: xi / radius_m, radius_m, depth_m }
    }

    /// Returns `k tanh(kh)`, 1/m.
    #[must_use]
    pub fn steepness(&self) -> f64 {
        self.k * (self.k * self.depth_m).tanh()
    }

    /// Returns its height over the surface at `(x, y)`.
    #[must_use]
    pub fn height(&self, x: f64, y: f64) -> f64 {
        let angle = y.atan2(x);
        bessel(self.order, self.k * x.hypot(y)) / bessel(self.order, self.k * self.radius_m)
            * (f64::from(self.order) * angle).cos()
    }

    /// Returns the slope of its height at `(x, y)`, 1/m.
    #[must_use]
    pub fn slope(&self, x: f64, y: f64) -> [f64; 2] {
        let h = STEP_M;
        [
            (self.height(x + h, y) - self.height(x - h, y)) / (2.0 * h),
            (self.height(x, y + h) - self.height(x, y - h)) / (2.0 * h),
        ]
    }

    /// Returns the velocity at `(x, y, z)`, z from the bottom, at the unit rate.
    fn velocity(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let (k, sinh) = (self.k, (self.k * self.depth_m).sinh());
        let [along, across] = self.slope(x, y);
        let flat = (k * z).cosh() / (k * sinh);
        [flat * along, flat * across, (k * z).sinh() / sinh * self.height(x, y)]
    }

    /// Returns the pieces of the wall, side and bottom.
    #[must_use]
    pub fn patches(&self) -> Vec<Patch> {
        let (radius, turn) = (self.radius_m, TAU / ANGLES as f64);
        let mut out = Vec::new();
        for angle in (0..ANGLES).map(|i| (i as f64 + 0.5) * turn) {
            let (sin, cos) = angle.sin_cos();
            for (z, thick) in heights(self.depth_m) {
                let [u, v, w] = self.velocity([radius * cos, radius * sin, z]);
                let speed = (v * cos - u * sin).hypot(w);
                out.push(Patch { area_m2: thick * radius * turn, speed });
            }
            for (r, wide) in radii(radius) {
                let [u, v, _] = self.velocity([r * cos, r * sin, 0.0]);
                out.push(Patch { area_m2: wide * r * turn, speed: u.hypot(v) });
            }
        }
        out
    }

    /// Returns the pieces of the bulk.
    #[must_use]
    pub fn strained(&self) -> Vec<Strained> {
        let turn = TAU / ANGLES as f64;
        let mut out = Vec::new();
        for angle in (0..ANGLES).map(|i| (i as f64 + 0.5) * turn) {
            let (sin, cos) = angle.sin_cos();
            for (r, wide) in radii(self.radius_m) {
                for (z, thick) in heights(self.depth_m) {
                    let shear = self.shear([r * cos, r * sin, z]);
                    out.push(Strained { volume_m3: wide * thick * r * turn, shear });
                }
            }
        }
        out
    }

    /// Returns `sqrt(2 e:e)` at a point; of potential flow e is the matrix of second derivatives.
    fn shear(&self, at: [f64; 3]) -> f64 {
        const H: f64 = 1e-4;
        let mut sum = 0.0;
        for axis in 0..3 {
            let moved = |by: f64| {
                let mut point = at;
                point[axis] += by;
                self.velocity(point)
            };
            let (up, down) = (moved(H), moved(-H));
            sum += up.iter().zip(down).map(|(up, down)| ((up - down) / (2.0 * H)).powi(2)).sum::<f64>();
        }
        (2.0 * sum).sqrt()
    }

    /// Returns the integral of `of(x, y)` over the surface.
    pub fn over_surface(&self, of: impl Fn(f64, f64) -> f64) -> f64 {
        let turn = TAU / ANGLES as f64;
        let at = |(r, wide): (f64, f64)| {
            let around = (0..ANGLES).map(|i| {
                let (sin, cos) = ((i as f64 + 0.5) * turn).sin_cos();
                of(r * cos, r * sin)
            });
            wide * r * turn * around.sum::<f64>()
        };
        fine_radii(self.radius_m).map(at).sum()
    }
}

/// Returns the middles and widths of rings of the bulk.
fn radii(radius_m: f64) -> impl Iterator<Item = (f64, f64)> {
    let wide = radius_m / RADII as f64;
    (0..RADII).map(move |i| ((i as f64 + 0.5) * wide, wide))
}

/// Returns the same of the surface, finer.
fn fine_radii(radius_m: f64) -> impl Iterator<Item = (f64, f64)> {
    let wide = radius_m / (20 * RADII) as f64;
    (0..20 * RADII).map(move |i| ((i as f64 + 0.5) * wide, wide))
}

/// Returns the middles and thicknesses of slices of the liquid, thinner towards the surface.
fn heights(depth_m: f64) -> impl Iterator<Item = (f64, f64)> {
    let edge = move |i: usize| depth_m * (1.0 - (1.0 - i as f64 / DEPTHS as f64).powi(2));
    (0..DEPTHS).map(move |i| (0.5 * (edge(i) + edge(i + 1)), edge(i + 1) - edge(i)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn the_integrals_are_those_of_theory() {
        let (radius, xi) = (0.04, 1.841_183_8);
        let shape = Shape::new(1, xi, radius, 0.08);
        // int phi^2 cos^2 = (pi/2) R^2 (1 - 1/xi^2), and int |grad|^2 = k^2 of it.
        let area = shape.over_surface(|x, y| shape.height(x, y).powi(2));
        let wanted = 0.5 * PI * radius * radius * (1.0 - 1.0 / (xi * xi));
        assert!((area / wanted - 1.0).abs() < 1e-4, "{area} for {wanted}");
        let slopes = shape.over_surface(|x, y| shape.slope(x, y).iter().map(|s| s * s).sum());
        assert!((slopes / (shape.k * shape.k * wanted) - 1.0).abs() < 1e-3, "{slopes}");
        // The kinetic energy of the bulk is that of the surface: int |u|^2 = N/(k tanh kh).
        let turn = TAU / ANGLES as f64;
        let mut whole = 0.0;
        for angle in (0..ANGLES).map(|i| (i as f64 + 0.5) * turn) {
            for (r, wide) in radii(radius) {
                for (z, thick) in heights(0.08) {
                    let u = shape.velocity([r * angle.cos(), r * angle.sin(), z]);
                    whole += wide * thick * r * turn * u.iter().map(|u| u * u).sum::<f64>();
                }
            }
        }
        assert!((whole * shape.steepness() / wanted - 1.0).abs() < 0.01, "{whole}");
        assert!((bessel(0, 2.404_825_557_7)).abs() < 1e-9 && (bessel(1, 1.0) - 0.440_050_585_7).abs() < 1e-9);
    }
}
