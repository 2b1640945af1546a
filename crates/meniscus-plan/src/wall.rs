//! From the 21 heights of a profile to the ends of the wall, where a slosh along x is highest.
//!
//! ```text
//! h(s) = sum_m c_m T_m(s),  s = cos theta          a surface along a round wall is a series of cos m theta = T_m(s)
//! h(+-1) = E z                                     E: least squares of the degrees up to 5 on the 21 points
//! ```
//! The profile ends at s = 0.9; nearer to the silhouette the camera sees the wall at too flat an angle.

use meniscus::surface::{POINTS, profile_abscissa};
use nalgebra::{DMatrix, DVector};

/// Points of the wall: one end, the points of a profile, the other end.
pub const WALL: usize = POINTS + 2;

/// Highest degree of the series.
const DEGREE: usize = 5;

/// Weights that give the heights at both ends.
#[derive(Clone, Debug, PartialEq)]
pub struct WallMap {
    /// Weights of the 21 heights for s = -1, then for s = 1.
    ends: [[f64; POINTS]; 2],
}

impl WallMap {
    /// The weights of the least squares above.
    #[must_use]
    pub fn new() -> Self {
        let row = |s: f64| DVector::from_iterator(DEGREE + 1, (0..=DEGREE).map(|m| chebyshev(m, s)));
        let series = DMatrix::from_fn(POINTS, DEGREE + 1, |i, m| chebyshev(m, profile_abscissa(i)));
        // T'T of 21 points and six degrees is regular; were it not, the ends would be those of the profile.
        let inverse = (series.transpose() * &series).try_inverse();
        let of = |s: f64, end: usize| {
            let unit = |i: usize| if i == end { 1.0 } else { 0.0 };
            let weights = inverse.as_ref().map(|inverse| &series * (inverse * row(s)));
            std::array::from_fn(|i| weights.as_ref().map_or(unit(i), |weights| weights[i]))
        };
        Self { ends: [of(-1.0, 0), of(1.0, POINTS - 1)] }
    }

    /// Returns the heights at both ends.
    #[must_use]
    pub fn ends(&self, heights: &[f64; POINTS]) -> [f64; 2] {
        self.ends.each_ref().map(|weights| weights.iter().zip(heights).map(|(w, z)| w * z).sum())
    }

    /// Returns the heights along the wall from end to end.
    #[must_use]
    pub fn wall(&self, heights: &[f64; POINTS]) -> [f64; WALL] {
        let [left, right] = self.ends(heights);
        std::array::from_fn(|i| match i {
            0 => left,
            _ if i == WALL - 1 => right,
            _ => heights[i - 1],
        })
    }
}

impl Default for WallMap {
    fn default() -> Self {
        Self::new()
    }
}

/// T_m(s).
fn chebyshev(degree: usize, s: f64) -> f64 {
    let (mut one, mut two) = (1.0, s);
    for _ in 0..degree {
        (one, two) = (two, 2.0 * s * two - one);
    }
    one
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Waves that go round the wall twice and three times, seen from 0.9 to -0.9, are known at its ends.
    #[test]
    fn the_ends_follow_from_the_profile() {
        let map = WallMap::new();
        let height = |s: f64| {
            let theta = s.acos();
            0.07 + 0.006 * theta.cos() - 0.001 * (2.0 * theta).cos() + 0.0005 * (3.0 * theta).cos()
        };
        let heights = std::array::from_fn(|i| height(profile_abscissa(i)));
        let wall = map.wall(&heights);
        assert!((wall[0] - height(-1.0)).abs() < 1e-9 && (wall[WALL - 1] - height(1.0)).abs() < 1e-9);
        assert_eq!(wall[11], heights[10]);
    }

    /// White noise of the points grows by less than the number of degrees that are fitted.
    #[test]
    fn noise_does_not_explode_at_the_ends() {
        let gain = WallMap::new().ends.map(|weights| weights.iter().map(|w| w * w).sum::<f64>().sqrt());
        assert!(gain.iter().all(|g| (0.5..3.0).contains(g)), "{gain:?}");
    }
}
