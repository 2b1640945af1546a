//! From a profile to the height of the first mode at the wall.
//!
//! ```text
//! s = sum (z - z_rest) xi / sum xi^2,    var s = sum xi^2 var z / (sum xi^2)^2        xi = x/R, over the points seen
//! ```
//! The mode (1,1) stands along the wall as cos theta = xi (Lamb 1932, article 257), and the edge that the camera sees
//! is the line on the wall. Least squares; what is even in xi, the waves of the second order, stays out of it where
//! both sides are seen.

use crate::surface::{SurfaceProfile, profile_abscissa};

/// A reading of the first mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slope {
    /// s, m.
    pub height_m: f64,
    /// Its variance, m2.
    pub variance_m2: f64,
}

/// The first mode in `profile` of a liquid that rests at `fill_m`; nothing where too little was seen.
///
/// ```
/// use meniscus::identify::slope;
/// use meniscus::surface::{POINTS, SurfaceProfile, profile_abscissa};
/// use meniscus::units::Micros;
///
/// let tilted = SurfaceProfile {
///     height_m: core::array::from_fn(|i| (0.07 + 0.004 * profile_abscissa(i)) as f32),
///     variance_m2: [1e-8; POINTS],
///     valid: [true; POINTS],
///     glass_x_m: Some(0.0),
///     sequence: 0,
///     captured: Micros(0),
/// };
/// let found = slope(&tilted, 0.07).unwrap();
/// assert!((found.height_m - 0.004).abs() < 1e-7);
/// ```
#[must_use]
pub fn slope(profile: &SurfaceProfile, fill_m: f64) -> Option<Slope> {
    if profile.valid_points() < crate::runtime::POINTS_NEEDED {
        return None;
    }
    let points = profile.height_m.iter().zip(&profile.variance_m2).zip(&profile.valid).enumerate();
    let (mut square, mut sum, mut spread) = (0.0, 0.0, 0.0);
    for (index, ((z, variance), _)) in points.filter(|(_, (_, valid))| **valid) {
        let xi = profile_abscissa(index);
        square += xi * xi;
        sum += xi * (f64::from(*z) - fill_m);
        spread += xi * xi * f64::from(*variance);
    }
    let found = Slope { height_m: sum / square, variance_m2: spread / (square * square) };
    (found.height_m.is_finite() && found.variance_m2.is_finite()).then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::POINTS;
    use crate::units::Micros;

    #[test]
    fn a_tilted_surface_has_its_slope_and_a_dish_none() {
        let xi = |index| profile_abscissa(index) as f32;
        let mut profile = SurfaceProfile {
            height_m: core::array::from_fn(|i| 0.07 + 0.004 * xi(i) + 0.02 * (xi(i) * xi(i) - 0.3)),
            variance_m2: [1e-8; POINTS],
            valid: [true; POINTS],
            glass_x_m: None,
            sequence: 0,
            captured: Micros(0),
        };
        let found = slope(&profile, 0.07).expect("all seen");
        assert!((found.height_m - 0.004).abs() < 1e-8, "{found:?}");
        assert!(found.variance_m2 < 0.2e-8 && found.variance_m2 > 0.1e-8, "{found:?}");
        profile.valid = core::array::from_fn(|i| i < 13);
        assert_eq!(slope(&profile, 0.07), None);
    }
}
