//! Effects of camera, fill and inclination on a profile.
//!
//! ```text
//! measured z_i = f (z_i + d_i) + p_i         f: scale;   d_i: fill and inclination;   p_i: slope and pitch of the camera
//! ```
//! A profile is freed of f, p and d before the encoder reads it, and d is added to the estimated surface.

use crate::math::{sincos, sqrt};
use crate::reduced::ReducedModel;
use crate::surface::{POINTS, SurfaceProfile, profile_abscissa};

/// Camera and fill effects on a profile.
///
/// ```
/// use meniscus::blob::ObservationModel;
/// use meniscus::reduced::effects::{EffectKind, Stated};
/// use meniscus::reduced::{Baseline, Cylinder, ReducedModel, Rheology};
/// use meniscus::surface::{POINTS, SurfaceProfile};
/// use meniscus::units::Micros;
///
/// let glass = Cylinder { radius_m: 0.035, depth_m: 0.07, density_kg_m3: 1261.0 };
/// let glycerine = Rheology::newtonian(0.95);
/// let stated = Stated { consistency_pa_sn: 0.95, radius_m: 0.035, fill_m: 0.07 };
/// // The camera measures every length 2 % too long.
/// let scale = EffectKind::DepthScale.effect().active(&[Some(1.02), None], &stated)?;
/// let reduced = ReducedModel::new(glass, glycerine, &Baseline::default(), &[scale], 1.0 / 60.0);
/// let observation_model = ObservationModel::new(0.035, 0.07, &reduced);
///
/// let height_m = observation_model.to_measured(&[0.07; POINTS]);
/// assert!((height_m[10] - 1.02 * 0.07).abs() < 1e-6);
/// let measured = SurfaceProfile {
///     height_m,
///     variance_m2: [1e-8; POINTS],
///     valid: [true; POINTS],
///     glass_x_m: Some(0.102),
///     sequence: 0,
///     captured: Micros(0),
/// };
/// let corrected = observation_model.to_model(&measured);
/// assert!((corrected.height_m[10] - 0.07).abs() < 1e-6);
/// assert!((corrected.glass_x_m.unwrap() - 0.1).abs() < 1e-6);
/// # Ok::<(), meniscus::reduced::effects::ValueError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ObservationModel {
    /// f.
    scale: f32,
    /// p, m.
    shift: [f32; POINTS],
    /// d, m.
    offset: [f32; POINTS],
    /// Factor on a measured motion of the glass; a tracked motion is unchanged.
    pub gain: f64,
}

impl ObservationModel {
    /// Returns the observation model of a glass of this radius and stated fill (m) whose reduced model is `with`.
    #[must_use]
    pub fn new(radius_m: f64, fill_m: f64, with: &ReducedModel) -> Self {
        let (port, view) = (&with.port, &with.view);
        let tangent = |angle: f64| {
            let (sin, cos) = sincos(angle);
            sin / cos
        };
        let (rolled, tilted) = (tangent(view.slope_rad), tangent(port.tilt_rad));
        let excess = with.glass.depth_m - fill_m;
        let mut observation_model =
            Self { scale: view.scale as f32, shift: [0.0; POINTS], offset: [0.0; POINTS], gain: port.gain };
        for (i, (p, d)) in observation_model.shift.iter_mut().zip(&mut observation_model.offset).enumerate() {
            let s = profile_abscissa(i);
            let bow = 1.0 - sqrt((1.0 - s * s).max(0.0));
            *p = (radius_m * (s * rolled + view.pitch_rad * bow)) as f32;
            *d = (excess + radius_m * s * tilted) as f32;
        }
        observation_model
    }

    /// Returns `profile` as the model's own glass and camera would show it.
    #[must_use]
    pub fn to_model(&self, profile: &SurfaceProfile) -> SurfaceProfile {
        let mut out = *profile;
        let places = out.height_m.iter_mut().zip(self.shift.iter().zip(&self.offset));
        places.for_each(|(z, (p, d))| *z = (*z - p) / self.scale - d);
        let square = self.scale * self.scale;
        out.variance_m2.iter_mut().for_each(|variance| *variance /= square);
        out.glass_x_m = profile.glass_x_m.map(|x| x / self.scale);
        out
    }

    /// Returns a surface of this glass as its camera measures it: the inverse of [`Self::to_model`] without the offset d.
    #[must_use]
    pub fn to_measured(&self, surface_m: &[f32; POINTS]) -> [f32; POINTS] {
        let mut out = *surface_m;
        out.iter_mut().zip(&self.shift).for_each(|(z, p)| *z = self.scale * *z + p);
        out
    }

    /// Adds the offset d of the glass to a surface of the model.
    pub fn add_offset(&self, surface_m: &mut [f32; POINTS]) {
        surface_m.iter_mut().zip(&self.offset).for_each(|(z, d)| *z += d);
    }
}
