//! The standing waves of the surface of a round glass: the functions in which effects on the surface see it.
//!
//! ```text
//! psi = J_m(xi r/R)/J_m(xi) cos/sin m phi,      J_m'(xi) = 0,        1 high at the wall, level there
//! int psi_i psi_j dA = 0 for i != j,            pi R^2/2 (1 - m^2/xi^2)  for i = j (twice that for m = 0)
//! ```
//! (Lamb 1932, article 191.) All waves with `xi` up to 8.6 are here: in the glass of the recordings those not shorter than five
//! spacings of 5 mm, or ten capillary lengths of water. They are level at the wall, so that a force along one of them does not
//! push through it. Polynomials stood here before: their line of force was a small difference of two that pushed hard on the
//! wall, and lost a quarter of what it should hold (5 mm).

use crate::particles::lanes::Row;
use meniscus::math::bessel_j;
use nalgebra::{SMatrix, SVector};

/// Radial waves of each azimuthal number from 0 on.
pub(crate) const RADIAL: [usize; 8] = [2, 3, 2, 2, 1, 1, 1, 1];

/// Number of waves: two of each azimuthal number but the first.
pub(crate) const COUNT: usize = 24;

/// Waves without their azimuth.
const PROFILES: usize = 13;

/// Steps of the table over the radius.
const STEPS: usize = 1024;

/// From generalised forces to rates, or the like.
pub(super) type Square = SMatrix<f64, COUNT, COUNT>;

/// One number for each wave.
pub(super) type Coefficients = SVector<f64, COUNT>;

/// One wave's value and slope along x and y (1/m).
pub(super) type Value = [f64; 3];

/// Profile of a wave at one radius: value, slope (1/m), and value over radius (1/m).
type Profile = [f64; 3];

/// Numbers of a row of the table: the profiles side by side, and one that fills it up to whole vectors.
pub(super) const NUMBERS: usize = 3 * PROFILES + 1;

/// A place in the circle, as the table wants it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Place {
    /// Row of the table below.
    pub(super) step: usize,
    /// Part of the way to the next row.
    pub(super) part: f64,
    /// Cosine and sine of the azimuth.
    pub(super) cos: f64,
    pub(super) sin: f64,
}

/// Returns the zero of J_m' near `x`, by Newton's method.
fn zero_of_slope(order: i32, mut x: f64) -> f64 {
    let m = f64::from(order);
    for _ in 0..8 {
        let slope = slope_of_bessel(order, x);
        // Bessel's equation.
        let bend = -slope / x - (1.0 - m * m / (x * x)) * bessel_j(order, x);
        x -= slope / bend;
    }
    x
}

/// J_m'(x).
fn slope_of_bessel(order: i32, x: f64) -> f64 {
    0.5 * (bessel_j(order - 1, x) - bessel_j(order + 1, x))
}

/// Returns the first `count` zeros `xi` of J_m' for the azimuthal number `order`, but 0.
pub(crate) fn zeros(order: i32, count: usize) -> Vec<f64> {
    // Near the first zero (Abramowitz and Stegun 9.5.16); the others follow a little more than pi apart.
    let mut near = if order == 0 { 3.8 } else { f64::from(order) + 0.81 * f64::from(order).cbrt() };
    let mut zeros = Vec::with_capacity(count);
    for n in 0..count {
        let xi = zero_of_slope(order, near);
        near = xi + if n == 0 { 3.5 } else { 3.25 };
        zeros.push(xi);
    }
    zeros
}

/// The waves over a circle.
#[derive(Clone, Debug)]
pub(super) struct Waves {
    radius_m: f64,
    /// Profiles at each radius of the table.
    pub(super) table: Vec<Row<NUMBERS>>,
    /// `1/int psi^2 dA`, 1/m2.
    pub(super) inverse: Coefficients,
}

impl Waves {
    /// The waves over a circle of radius `radius_m`.
    pub(super) fn new(radius_m: f64) -> Self {
        let kinds: Vec<(i32, f64)> = (0..)
            .zip(RADIAL)
            .flat_map(|(m, count)| zeros(m, count).into_iter().map(move |xi| (m, xi)))
            .collect();
        let table = (0..=STEPS + 1).map(|step| {
            let r = step as f64 / STEPS as f64;
            let profile = |&(m, xi): &(i32, f64)| -> Profile {
                let unit = 1.0 / bessel_j(m, xi);
                let slope = unit * xi / radius_m * slope_of_bessel(m, xi * r);
                // At the axis J_1 alone has a slope, and its value over the radius is that.
                let over = if step == 0 { slope } else { unit * bessel_j(m, xi * r) / (r * radius_m) };
                [unit * bessel_j(m, xi * r), slope, over]
            };
            let mut row = Row::default();
            row.0.iter_mut().zip(kinds.iter().flat_map(profile)).for_each(|(to, x)| *to = x);
            row
        });
        let areas = kinds.iter().flat_map(|&(m, xi)| {
            let part = if m == 0 { 1.0 } else { 0.5 };
            let area =
                part * std::f64::consts::PI * radius_m * radius_m * (1.0 - (f64::from(m) / xi).powi(2));
            std::iter::repeat_n(1.0 / area, if m == 0 { 1 } else { 2 })
        });
        let inverse = Coefficients::from_iterator(areas);
        Self { radius_m, table: table.collect(), inverse }
    }

    /// Returns the place `(x, y)`; beyond the wall that at the wall.
    pub(super) fn place(&self, x: f64, y: f64) -> Place {
        let r = x.hypot(y);
        let (cos, sin) = if r > 1e-9 { (x / r, y / r) } else { (1.0, 0.0) };
        let place = (r / self.radius_m).min(1.0) * STEPS as f64;
        Place { step: place as usize, part: place.fract(), cos, sin }
    }

    /// Every wave at `(x, y)`; beyond the wall its value there.
    pub(super) fn at(&self, x: f64, y: f64) -> [Value; COUNT] {
        let Place { step, part, cos, sin } = self.place(x, y);
        let (low, high) = (self.table[step].0.as_chunks().0, self.table[step + 1].0.as_chunks().0);
        let mut out = [[0.0; 3]; COUNT];
        let (mut slots, mut profiles) = (out.iter_mut(), low.iter().zip(high));
        // cos m phi and sin m phi.
        let mut turn = [1.0, 0.0];
        for (m, count) in RADIAL.iter().enumerate() {
            let order = m as f64;
            for (low, high) in profiles.by_ref().take(*count) {
                let (low, high): (&Profile, &Profile) = (low, high);
                let [f, slope, over]: Profile = std::array::from_fn(|k| low[k] + part * (high[k] - low[k]));
                let around = order * over;
                // Along the radius and around, turned into x and y.
                let [[c, s], [d_c, d_s]] = [turn, [-turn[1], turn[0]]];
                let wave = |azimuth: f64, turned: f64| {
                    [
                        f * azimuth,
                        slope * azimuth * cos - around * turned * sin,
                        slope * azimuth * sin + around * turned * cos,
                    ]
                };
                for (slot, value) in slots.by_ref().take(1 + m.min(1)).zip([wave(c, d_c), wave(s, d_s)]) {
                    *slot = value;
                }
            }
            turn = [turn[0] * cos - turn[1] * sin, turn[0] * sin + turn[1] * cos];
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_zeros_are_those_of_the_tables() {
        // Abramowitz and Stegun, table 9.5.
        let known: [&[f64]; 8] = [
            &[3.83171, 7.01559],
            &[1.84118, 5.33144, 8.53632],
            &[3.05424, 6.70613],
            &[4.20119, 8.01524],
            &[5.31755],
            &[6.41562],
            &[7.50127],
            &[8.57784],
        ];
        for ((order, count), known) in (0..).zip(RADIAL).zip(known) {
            for (found, known) in zeros(order, count).iter().zip(known) {
                assert!((found - known).abs() < 1e-5, "{found} for {known} of order {order}");
            }
        }
    }

    #[test]
    fn slopes_are_derivatives_and_the_wall_is_level() {
        let (radius, h) = (0.035, 1e-6);
        let waves = Waves::new(radius);
        for (x, y) in [(0.011, -0.017), (1e-4, 2e-4), (-0.03, 0.01)] {
            let at = waves.at(x, y);
            let [right, left, up, down] =
                [(x + h, y), (x - h, y), (x, y + h), (x, y - h)].map(|(x, y)| waves.at(x, y));
            for j in 0..COUNT {
                let slope = [(right[j][0] - left[j][0]) / (2.0 * h), (up[j][0] - down[j][0]) / (2.0 * h)];
                let off = (at[j][1] - slope[0]).abs() + (at[j][2] - slope[1]).abs();
                assert!(off < 1.0, "{:?} for {slope:?}, wave {j}", at[j]);
            }
        }
        let (sin, cos) = 0.7_f64.sin_cos();
        let wall = waves.at(radius * cos, radius * sin);
        assert!(wall.iter().all(|[_, x, y]| (x * cos + y * sin).abs() < 1e-2));
        assert!((wall[0][0] - 1.0).abs() < 1e-9 && (wall[2][0] - cos).abs() < 1e-9, "{wall:?}");
    }

    #[test]
    fn the_waves_are_orthogonal_and_have_their_areas() {
        let (radius, rings, turns) = (0.035, 300, 64);
        let waves = Waves::new(radius);
        let mut gram = Square::zeros();
        for cell in 0..rings * turns {
            let r = (f64::from(cell / turns) + 0.5) / f64::from(rings);
            let angle = std::f64::consts::TAU * f64::from(cell % turns) / f64::from(turns);
            let area = std::f64::consts::TAU * r * radius * radius / f64::from(rings * turns);
            let at = waves.at(radius * r * angle.cos(), radius * r * angle.sin());
            let values = Coefficients::from_fn(|j, _| at[j][0]);
            gram.ger(area, &values, &values, 1.0);
        }
        for i in 0..COUNT {
            for j in 0..COUNT {
                let due = f64::from(u8::from(i == j));
                let found = gram[(i, j)] * waves.inverse[i];
                assert!((found - due).abs() < 1e-3, "{found} for {due} of waves {i} and {j}");
            }
        }
    }
}
