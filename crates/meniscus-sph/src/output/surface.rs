//! The free surface: one smooth height over the cross-section of the glass.
//!
//! In each column the surface is where the colour function, the volume of liquid that the kernel
//! sees over the volume of glass that it sees, falls through one half:
//! ```text
//! C(x) = sum_f V_f W(x - x_f) / (1 - sum_w V_w W(x - x_w)) = 1/2
//! ```
//! The heights of all columns are then fitted by the polynomials `(r/R)^m+2k cos/sin m phi` up to
//! degree 7 (36 of them), by least squares. This removes the grain of the particles, and cannot
//! show an overturning wave. A constant offset, measured at rest, puts the mean of the resting
//! surface at the fill height.

use crate::particles::Particle;
use crate::{Error, Simulator};
use meniscus::surface::{POINTS, profile_abscissa};
use meniscus_data::recording::{COLUMNS, Lattice, WALL_POINTS, wall_azimuth};
use nalgebra::DMatrix;
use rayon::prelude::*;

/// Degree of the fitted polynomials.
const DEGREE: usize = 7;

/// Number of fitted coefficients, `(d + 1)(d + 2)/2`.
pub(crate) const COEFFICIENTS: usize = (DEGREE + 1) * (DEGREE + 2) / 2;

/// Particles near one column: index and squared horizontal distance.
pub(crate) type Nearby = Vec<(u32, f64)>;

/// The fitted surface: coefficients of the polynomials, metres.
pub(crate) type Coefficients = [f64; COEFFICIENTS];

/// Finds and fits the surface.
#[derive(Clone, Debug)]
pub(crate) struct SurfaceFinder {
    /// Of the cross-section at the fill.
    radius_m: f64,
    /// Farthest that a tracer stands from its column, squared after adding the support, m2.
    reach2: f64,
    /// Columns of the lattice, then the points of the contact line.
    positions: Vec<[f64; 2]>,
    /// Half the part of the kernel that lies inside the glass, at each place.
    threshold: Vec<f64>,
    /// From heights to coefficients.
    fit: DMatrix<f64>,
    offset_m: f64,
}

impl SurfaceFinder {
    /// The finder for a settled `simulator`, calibrated on its resting surface.
    ///
    /// # Errors
    /// When the columns do not determine the polynomials.
    pub(crate) fn new(simulator: &Simulator) -> Result<Self, Error> {
        let glass = simulator.glass;
        let radius_m = glass.radius_at(glass.fill_m);
        let mut positions = Lattice::new(&glass).columns;
        positions.extend((0..WALL_POINTS).map(|k| {
            let (sin, cos) = wall_azimuth(k).sin_cos();
            [radius_m * cos, radius_m * sin]
        }));
        let threshold = positions.iter().map(|place| 0.5 * inside(simulator, place)).collect();
        let rows: Vec<Coefficients> = positions.iter().map(|p| basis(p, radius_m)).collect();
        let matrix = DMatrix::from_fn(positions.len(), COEFFICIENTS, |r, c| rows[r][c]);
        let fit = matrix
            .pseudo_inverse(1e-9)
            .map_err(|why| Error::Setup(format!("the surface cannot be fitted over these columns: {why}")))?;
        let support2 = simulator.forces.kernel.support2;
        let reach2 = if glass.is_cylinder() { support2 } else { (support2.sqrt() + glass.lean_m()).powi(2) };
        let mut finder = Self { radius_m, reach2, positions, threshold, fit, offset_m: 0.0 };
        let nearby = finder.nearby(simulator);
        let rest = finder.coefficients(simulator, &nearby);
        let columns = &finder.positions[..COLUMNS];
        let mean = columns.iter().map(|p| finder.height(&rest, p)).sum::<f64>() / COLUMNS as f64;
        finder.offset_m = glass.fill_m - mean;
        Ok(finder)
    }

    /// The particles within the support of the kernel around every place and its tracers, horizontally.
    pub(crate) fn nearby(&self, simulator: &Simulator) -> Vec<Nearby> {
        let reach2 = self.reach2;
        self.positions
            .par_iter()
            .map(|place| {
                let near = |p: &Particle| {
                    let (dx, dy) = (p.x[0] - place[0], p.x[1] - place[1]);
                    dx * dx + dy * dy
                };
                let all = simulator.fluid.particle.iter().enumerate().map(|(i, p)| (i as u32, near(p)));
                all.filter(|(_, d2)| *d2 < reach2).collect()
            })
            .collect()
    }

    /// Fits the surface of the present state; `nearby` as from [`Self::nearby`].
    pub(crate) fn coefficients(&self, simulator: &Simulator, nearby: &[Nearby]) -> Coefficients {
        let heights: Vec<f64> = nearby
            .par_iter()
            .zip(&self.threshold)
            .map(|(nearby, threshold)| crossing(simulator, nearby, *threshold))
            .collect();
        let mut fitted = [0.0; COEFFICIENTS];
        for (row, c) in fitted.iter_mut().enumerate() {
            *c = self.fit.row(row).iter().zip(&heights).map(|(a, h)| a * h).sum();
        }
        fitted[0] += self.offset_m;
        fitted
    }

    /// Height of the fitted surface at `place`, m.
    pub(crate) fn height(&self, fitted: &Coefficients, place: &[f64; 2]) -> f64 {
        basis(place, self.radius_m).iter().zip(fitted).map(|(b, c)| b * c).sum()
    }

    /// Heights over the columns of the lattice, then along the contact line.
    pub(crate) fn heights(&self, fitted: &Coefficients) -> (Vec<f32>, Vec<f32>) {
        let all: Vec<f32> = self.positions.iter().map(|p| self.height(fitted, p) as f32).collect();
        (all[..COLUMNS].to_vec(), all[COLUMNS..].to_vec())
    }

    /// The profile: heights of the contact line on the wall that faces the camera.
    pub(crate) fn profile(&self, fitted: &Coefficients) -> [f32; POINTS] {
        std::array::from_fn(|i| {
            let x = profile_abscissa(i);
            let place = [self.radius_m * x, -self.radius_m * (1.0 - x * x).sqrt()];
            self.height(fitted, &place) as f32
        })
    }
}

/// The polynomials at `place`: for each azimuthal order m, `(r/R)^(m+2k)` times cosine and sine.
fn basis(place: &[f64; 2], radius_m: f64) -> Coefficients {
    let (x, y) = (place[0] / radius_m, place[1] / radius_m);
    let r2 = x * x + y * y;
    let mut out = [0.0; COEFFICIENTS];
    let mut slots = out.iter_mut();
    // (x + i y)^m = r^m (cos m phi + i sin m phi).
    let (mut cosine, mut sine) = (1.0, 0.0);
    for m in 0..=DEGREE {
        let mut ring = 1.0;
        for _ in 0..=(DEGREE - m) / 2 {
            let parts = [ring * cosine, ring * sine];
            // `parts` first: a zip asks its first iterator first, and must not lose a slot.
            for (part, slot) in parts.iter().take(1 + m.min(1)).zip(slots.by_ref()) {
                *slot = *part;
            }
            ring *= r2;
        }
        (cosine, sine) = (cosine * x - sine * y, cosine * y + sine * x);
    }
    out
}

/// The part of the kernel around `place`, far from bottom and rim, that lies inside the glass.
fn inside(simulator: &Simulator, place: &[f64; 2]) -> f64 {
    const HEIGHTS: usize = 8;
    let kernel = &simulator.forces.kernel;
    let glass = &simulator.glass;
    let middle = if glass.is_cylinder() { 0.5 * glass.rim_m } else { glass.fill_m };
    let mut outside = 0.0;
    for k in 0..HEIGHTS {
        let z = middle + simulator.spacing_m * k as f64 / HEIGHTS as f64;
        for (x, volume) in simulator.shell.position.iter().zip(&simulator.shell.volume) {
            let (dx, dy, dz) = (x[0] - place[0], x[1] - place[1], x[2] - z);
            outside += volume * kernel.value(dx * dx + dy * dy + dz * dz);
        }
    }
    1.0 - outside / HEIGHTS as f64
}

/// Height at which the colour function first reaches `threshold`, coming down from above; 0 if never.
fn crossing(simulator: &Simulator, nearby: &Nearby, threshold: f64) -> f64 {
    let kernel = &simulator.forces.kernel;
    let particle = &simulator.fluid.particle;
    let colour = |z: f64| -> f64 {
        let part = |(i, d2): &(u32, f64)| {
            let p = &particle[*i as usize];
            let r2 = d2 + (p.x[2] - z) * (p.x[2] - z);
            if r2 < kernel.support2 { p.volume * kernel.value(r2) } else { 0.0 }
        };
        nearby.iter().map(part).sum::<f64>() - threshold
    };
    let top = nearby.iter().map(|(i, _)| particle[*i as usize].x[2]).fold(0.0, f64::max);
    let (mut high, step) = (top + kernel.h, 0.5 * kernel.h);
    let mut above = colour(high);
    while high > 0.0 {
        let low = high - step;
        let below = colour(low);
        if below >= 0.0 {
            return root(colour, low, below, high, above);
        }
        (high, above) = (low, below);
    }
    0.0
}

/// Root of `f` between `low` (where it is `below >= 0`) and `high` (`above < 0`), by bracketed secants.
fn root(f: impl Fn(f64) -> f64, mut low: f64, mut below: f64, mut high: f64, mut above: f64) -> f64 {
    let mut z = low;
    for _ in 0..4 {
        z = low + (high - low) * below / (below - above);
        let value = f(z);
        if value >= 0.0 {
            (low, below) = (z, value);
        } else {
            (high, above) = (z, value);
        }
    }
    z
}
