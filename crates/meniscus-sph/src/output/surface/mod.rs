//! The free surface: one smooth height over the cross-section of the glass.
//!
//! In each column the surface is where the colour function, the volume of liquid that the kernel
//! sees over the volume of glass that it sees, falls through one half:
//! ```text
//! C(x) = sum_f V_f W(x - x_f) / (1 - sum_w V_w W(x - x_w)) = 1/2
//! ```
//! The heights of all columns are then fitted by the polynomials `(r/R)^m+2k cos/sin m phi` up to
//! degree 7 (36 of them), each as the columns see it ([`basis`]), by least squares. This removes the grain of the particles, and cannot
//! show an overturning wave. A constant offset, measured at rest, puts the mean of the resting
//! surface at the fill height.

mod basis;
mod crossing;

use self::basis::{basis, seen};
use self::crossing::{crossing, inside};
use crate::particles::{Kernel, Particle};
use crate::{Error, Simulator};
use meniscus::surface::{POINTS, profile_abscissa};
use meniscus_data::recording::{COLUMNS, Lattice, WALL_POINTS, wall_azimuth};
use nalgebra::DMatrix;
use rayon::prelude::*;

/// Degree of the fitted polynomials.
const DEGREE: usize = 7;

/// Number of fitted coefficients, `(d + 1)(d + 2)/2`.
pub(crate) const COEFFICIENTS: usize = (DEGREE + 1) * (DEGREE + 2) / 2;

/// Times that the blur of the kernel is taken back. The wall of a glass inclined by 0.1 rad then shows 0.995 of its slope (0.918 without,
/// 5 mm) for 2.4 times the grain; the exact inverse shows 1.05 for five times.
const SHARPENINGS: usize = 2;

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
    /// From the heights that the columns find to coefficients.
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
        let fit = sharp_fit(&positions, radius_m, &simulator.forces.kernel)?;
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

/// Returns the matrix from the heights that the columns find to the coefficients.
///
/// The plain fit `P` takes them for heights of the surface; they are those of the surface blurred by the kernel, `S c`. Van Cittert's
/// iteration (1931) takes that back without the noise of an exact inverse: `F <- F + P (1 - S F)`.
fn sharp_fit(positions: &[[f64; 2]], radius_m: f64, kernel: &Kernel) -> Result<DMatrix<f64>, Error> {
    let matrix = |rows: Vec<Coefficients>| DMatrix::from_fn(rows.len(), COEFFICIENTS, |r, c| rows[r][c]);
    let heights = matrix(positions.iter().map(|place| basis(place, radius_m)).collect());
    let blurred = matrix(positions.par_iter().map(|place| seen(place, radius_m, kernel)).collect());
    let plain = heights
        .pseudo_inverse(1e-9)
        .map_err(|why| Error::Setup(format!("the surface cannot be fitted over these columns: {why}")))?;
    let blur = &plain * blurred;
    let mut fit = plain.clone();
    for _ in 0..SHARPENINGS {
        fit = &fit + &plain - &blur * &fit;
    }
    Ok(fit)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Setup;
    use crate::setup::small_glass;
    use meniscus::reduced::effects::EffectKind;
    use meniscus_data::effects::Effects;
    use meniscus_data::liquids::Rheology;
    use std::f64::consts::PI;

    /// A tilted glass in coarse particles, at rest.
    const ANGLE: f64 = 0.1;

    fn tilted() -> Simulator {
        let effects = Effects::default().with(EffectKind::ContainerTilt, ANGLE);
        let setup = Setup { effects, ..small_glass(1261.0, Rheology::newtonian(0.95)) };
        Simulator::new(&setup).expect("the glass settles")
    }

    #[test]
    fn the_line_at_the_wall_of_a_tilted_glass_is_as_high_as_gravity_says() {
        let simulator = tilted();
        let finder = SurfaceFinder::new(&simulator).expect("the surface is fitted");
        let surface = finder.coefficients(&simulator, &finder.nearby(&simulator));
        let (_, wall) = finder.heights(&surface);
        let products = wall.iter().enumerate().map(|(k, h)| f64::from(*h) * wall_azimuth(k).cos());
        let first = products.sum::<f64>() * 2.0 / WALL_POINTS as f64;
        let exact = simulator.glass.radius_m * ANGLE.tan();
        assert!((first / exact - 1.0).abs() < 0.02, "{first} for {exact}");
    }

    #[test]
    fn the_surface_holds_the_moment_of_the_liquid_below_it() {
        let simulator = tilted();
        let finder = SurfaceFinder::new(&simulator).expect("the surface is fitted");
        let surface = finder.coefficients(&simulator, &finder.nearby(&simulator));
        // int x eta dA = sum V x, by the rule of midpoints.
        let radius_m = simulator.glass.radius_m;
        let mut below = 0.0;
        let (rings, spokes) = (100, 100);
        for (ring, spoke) in (0..rings).flat_map(|ring| (0..spokes).map(move |spoke| (ring, spoke))) {
            let r = radius_m * (f64::from(ring) + 0.5) / f64::from(rings);
            let (sin, cos) = (2.0 * PI * f64::from(spoke) / f64::from(spokes)).sin_cos();
            let area = 2.0 * PI * r * radius_m / f64::from(rings * spokes);
            below += area * r * cos * finder.height(&surface, &[r * cos, r * sin]);
        }
        let liquid: f64 = simulator.motion().map(|(x, _, m)| m * x[0]).sum::<f64>() / 1261.0;
        assert!((below / liquid - 1.0).abs() < 0.04, "{below} for {liquid}");
    }
}
