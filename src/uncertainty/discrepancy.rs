//! Discrepancy of the decoder's surface from the heights that were seen.
//!
//! A liquid that the model was not trained on stands in shapes that thirteen latents do not decode to. With S the decoder's
//! surface, e its error at a height, and z the camera's measurement of that height,
//!
//! ```text
//! z = S(x) + e + noise,   <e^2> = w d,   <noise^2> = r
//! e^ = s (z - S(x)),      s = w d / max(w d + r, (z - S)^2/b^2),      <(e - e^)^2> = (1 - s) w d
//! ```
//! (the discrepancy of a model: Kennedy and O'Hagan, J. R. Stat. Soc. B 63 (2001) 425; w, d and r are those of
//! [`crate::uncertainty::error_model`]). The filter counts e as noise, so that the latents do not run after what they cannot say; here it is added
//! to the surface. A height beyond b standard deviations is taken for an outlier and counts less the farther it is off (bounded
//! influence, as in the filter). The discrepancy changes the surface alone: no part of the field moves with it, no forecast uses
//! it, and where a height was not seen there is none. A model on its own liquid has next to none either.

use crate::surface::{POINTS, SurfaceProfile};
use crate::uncertainty::error_model::ErrorModel;

/// b: what a liquid shows that the model was not trained on lies well within.
const GATE: f64 = 10.0;

/// Least variance of a measured height, m2: that of 0.1 mm.
pub const LEAST_M2: f64 = 1e-8;

/// s of every height; 0 where it was not seen.
///
/// ```
/// # #[repr(align(64))]
/// # struct Aligned<T: ?Sized>(T);
/// # static BLOB: &Aligned<[u8]> =
/// #     &Aligned(*include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/models/glycerine.blob")));
/// let model = meniscus::blob::Model::load(&BLOB.0)?;
/// use meniscus::surface::{POINTS, SurfaceProfile};
/// use meniscus::uncertainty::discrepancy::Discrepancy;
/// use meniscus::units::Micros;
///
/// // The decoder says 70 mm, the camera 72 mm; one point is not valid.
/// let mut valid = [true; POINTS];
/// valid[3] = false;
/// let profile = SurfaceProfile {
///     height_m: [0.072; POINTS],
///     variance_m2: [1e-8; POINTS],
///     valid,
///     glass_x_m: None,
///     sequence: 0,
///     captured: Micros(0),
/// };
/// let mut surface_m = [0.070; POINTS];
/// let discrepancy = Discrepancy::of(&model.error_model, &profile, &surface_m, 1.0);
/// discrepancy.add_to(&mut surface_m, &profile);
/// // The estimate moves towards the measurement, and stays where there is none.
/// assert!(surface_m[10] > 0.070 && surface_m[10] < 0.072);
/// assert_eq!(surface_m[3], 0.070);
/// # Ok::<(), meniscus::blob::LoadError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Discrepancy([f64; POINTS]);

impl Discrepancy {
    /// Of no measurement.
    pub const NONE: Self = Self([0.0; POINTS]);

    /// Returns s of the heights in `profile`, where the decoder says `surface_m`, under a slosh of energy `latent_energy` in units
    /// of H.
    #[must_use]
    pub fn of(
        errors: &ErrorModel<'_>,
        profile: &SurfaceProfile,
        surface_m: &[f32; POINTS],
        latent_energy: f64,
    ) -> Self {
        let (w, mut shares) = (errors.weight(latent_energy), [0.0; POINTS]);
        let points = profile.valid.iter().zip(&profile.variance_m2).zip(errors.surface_misfit);
        let differences = profile.height_m.iter().zip(surface_m).map(|(z, said)| f64::from(z - said) / GATE);
        for ((share, ((valid, variance), d)), beyond) in shares.iter_mut().zip(points).zip(differences) {
            let (missed, noise) = ((w * f64::from(*d)).max(0.0), f64::from(*variance).max(LEAST_M2));
            let of_both = missed / (missed + noise).max(beyond * beyond);
            // The misfit may overflow in a hostile blob.
            *share = if *valid && of_both.is_finite() { of_both } else { 0.0 };
        }
        Self(shares)
    }

    /// Adds e^ to the decoder's surface.
    pub fn add_to(&self, surface_m: &mut [f32; POINTS], profile: &SurfaceProfile) {
        let points = self.0.iter().zip(&profile.height_m);
        for (z, (share, measured)) in surface_m.iter_mut().zip(points) {
            // A height that was not seen need not be a number.
            if *share > 0.0 {
                *z += *share as f32 * (*measured - *z);
            }
        }
    }

    /// 1 - s: remaining share of w d at every height.
    pub(crate) fn left(&self) -> [f64; POINTS] {
        self.0.map(|share| 1.0 - share)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::uncertainty::error_model::tests::error_model;
    use crate::units::Micros;

    fn profile() -> SurfaceProfile {
        let mut valid = [true; POINTS];
        valid[3] = false;
        let mut height_m = [0.072; POINTS];
        height_m[3] = f32::NAN;
        SurfaceProfile {
            height_m,
            variance_m2: [4e-8; POINTS],
            valid,
            glass_x_m: None,
            sequence: 0,
            captured: Micros(0),
        }
    }

    /// d = 1e-8 m2 under w = 4 is as much as the noise: half of what was missed comes back, and half of its variance is left.
    #[test]
    fn what_is_as_large_as_the_noise_comes_back_by_half() {
        let (errors, profile) = (error_model(), profile());
        let shares = Discrepancy::of(&errors, &profile, &[0.070; POINTS], 4.0 - errors.weight(0.0));
        let mut surface_m = [0.070; POINTS];
        shares.add_to(&mut surface_m, &profile);
        assert!((surface_m[7] - 0.071).abs() < 1e-6, "{}", surface_m[7]);
        assert!((shares.left()[7] - 0.5).abs() < 1e-6);
        assert_eq!((surface_m[3], shares.left()[3]), (0.070, 1.0), "a height that was not seen");
    }

    /// Over many heights with misfit and noise, what comes back misses (1 - s) w d, as is said of it: less than the decoder
    /// alone, w d, and than the measurement alone, r.
    #[test]
    fn what_is_left_is_as_much_as_is_said() {
        let (errors, mut profile) = (error_model(), profile());
        profile.variance_m2 = [9e-8; POINTS];
        let shares = Discrepancy::of(&errors, &profile, &[0.070; POINTS], 4.0 - errors.weight(0.0));
        let mut bits = 1_u64;
        let mut draw = || {
            // The sum of twelve uniform numbers is near a Gaussian of deviation one.
            let mut sum = -6.0;
            for _ in 0..12 {
                bits = bits.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                sum += (bits >> 11) as f64 / (1_u64 << 53) as f64;
            }
            sum
        };
        let (mut left, turns) = (0.0, 20_000);
        for _ in 0..turns {
            let (e, noise) = (2e-4 * draw(), 3e-4 * draw());
            profile.height_m[7] = (0.070 + e + noise) as f32;
            let mut surface_m = [0.070; POINTS];
            shares.add_to(&mut surface_m, &profile);
            let off = f64::from(surface_m[7]) - (0.070 + e);
            left += off * off / f64::from(turns);
        }
        let said = shares.left()[7] * 4e-8;
        assert!((left / said - 1.0).abs() < 0.05, "{left} where {said} was said");
        assert!(left < 0.9 * 4e-8);
    }

    /// A height 100 standard deviations off moves its estimate by a hundredth of what it would without a gate.
    #[test]
    fn an_outlier_moves_its_point_little() {
        let (errors, mut profile) = (error_model(), profile());
        // The root of w d + r = 8e-8 m2.
        let deviation_m = 2.828_427e-4;
        profile.height_m[7] = (0.070 + 100.0 * deviation_m) as f32;
        let shares = Discrepancy::of(&errors, &profile, &[0.070; POINTS], 4.0 - errors.weight(0.0));
        let mut surface_m = [0.070; POINTS];
        shares.add_to(&mut surface_m, &profile);
        let moved = f64::from(surface_m[7]) - 0.070;
        assert!((moved / (0.005 * 100.0 * deviation_m) - 1.0).abs() < 0.01, "{moved}");
        assert!((shares.left()[7] - 0.995).abs() < 1e-6);
    }

    /// Values of a hostile blob that are not finite have no effect.
    #[test]
    fn what_is_no_number_comes_back_nowhere() {
        let errors = ErrorModel { surface_misfit: &[f32::INFINITY; POINTS], ..error_model() };
        let mut surface_m = [0.070; POINTS];
        Discrepancy::of(&errors, &profile(), &surface_m, 1.0).add_to(&mut surface_m, &profile());
        assert_eq!(surface_m, [0.070; POINTS]);
    }
}
