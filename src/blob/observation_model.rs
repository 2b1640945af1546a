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
