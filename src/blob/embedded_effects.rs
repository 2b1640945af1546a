//! Embedded effects of a blob, and their observation model.
//!
//! A blob lists effects by name and value; what they do to the step is worked out when it is loaded, by the formulas
//! of [`crate::reduced::effects`], so that nothing but the list has to be believed. Effects of the liquid and of gravity act
//! in the step ([`Slots`]), the others on what is measured:
//!
//! ```text
//! measured z_i = f (z_i + d_i) + p_i         f: scale;   d_i: fill and inclination;   p_i: slope and pitch of the camera
//! ```
//! A profile is freed of f, p and d before the encoder reads it, and d is added to the estimated surface.

use super::LoadError;
use super::header::Header;
use crate::latent::generic::{LATENTS, ModeMap, Slots};
use crate::math::{sincos, sqrt};
use crate::reduced::effects::{Active, MOST, PARAMETERS, Port, Slot, Stated, View, find};
use crate::reduced::{Baseline, Cylinder, ReducedModel, Rheology};
use crate::surface::{POINTS, SurfaceProfile, profile_abscissa};
use heapless::{String, Vec};
use nalgebra::SMatrix;
use serde::{Deserialize, Serialize};

/// One effect with the coordinates of its parameters in the reduced model; those that it does not have are zero.
///
/// A viscosity is stored as the factor over [`EmbeddedEffects::liquid`], a fill as the excess over the header's: the blob holds both,
/// so [`EmbeddedEffects::stated`] gives the SI values back.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EmbeddedEffect {
    /// Its name in the list of effects.
    pub name: String<32>,
    /// Its coordinates.
    pub values: [f64; PARAMETERS],
}

/// Effects and the liquid that they are counted from: the one that the model was trained on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EmbeddedEffects {
    /// Density of that liquid, kg/m3.
    pub density_kg_m3: f64,
    /// How it resists.
    pub liquid: Rheology,
    /// What it lacks.
    pub effects: Vec<EmbeddedEffect, MOST>,
}

impl EmbeddedEffects {
    /// Returns the liquid and the fill that the coordinates are counted from, in a model of the fill `fill_m`.
    #[must_use]
    pub fn stated(&self, fill_m: f64) -> Stated {
        Stated { consistency_pa_sn: self.liquid.consistency, fill_m }
    }
}

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

/// Returns the reason that a blob cannot embed `effect`; `None` where it can.
#[must_use]
pub fn embedding_obstacle(effect: &Active) -> Option<&'static str> {
    let (mut port, mut view) = (Port::default(), View::default());
    match effect.entry.slot {
        Slot::FirstMode(_) => {
            return Some("its latents know one direction of the wave, and its energy has to stay convex");
        }
        Slot::Port(change) => change(&effect.values, &mut port),
        Slot::View(change) => change(&effect.values, &mut view),
        _ => {}
    }
    if port.delay_s != 0.0 || view.latency_s != 0.0 {
        return Some("it is a matter of clocks: put the times of pictures or motion right instead");
    }
    if port.tilt_share != 0.0 || port.lift_share != 0.0 {
        return Some("a board is told no inclination and no vertical motion that it could have a share of");
    }
    None
}

/// What the effects of `named` do in the step and to the profile; `hessian` is that of H at rest.
pub(super) fn apply(
    header: &Header,
    named: &EmbeddedEffects,
    map: ModeMap,
    hessian: &SMatrix<f64, LATENTS, LATENTS>,
) -> Result<(Slots, ObservationModel), LoadError> {
    let liquid = &named.liquid;
    let sound = [
        ("density_kg_m3", named.density_kg_m3, 1e-9),
        ("consistency", liquid.consistency, 1e-9),
        ("index", liquid.index, 1e-9),
        ("yield_pa", liquid.yield_pa, 0.0),
        ("slip_m", liquid.slip_m, 0.0),
        ("film", liquid.film, 0.0),
    ];
    for (field, value, least) in sound {
        if !(value.is_finite() && value >= least) {
            return Err(LoadError::HeaderValue { field, value });
        }
    }
    let mut active = Vec::<Active, MOST>::new();
    for (index, effect) in named.effects.iter().enumerate() {
        let entry = find(&effect.name).ok_or(LoadError::UnknownEffect { index })?;
        for (parameter, &value) in entry.parameters.iter().zip(&effect.values) {
            let (least, largest) = parameter.range;
            if !(least <= value && value <= largest) {
                return Err(LoadError::EffectValue {
                    effect: entry.name,
                    parameter: parameter.coordinate_name(),
                    value,
                });
            }
        }
        let one = Active { entry, values: effect.values };
        if let Some(why) = embedding_obstacle(&one) {
            return Err(LoadError::EffectNotEmbeddable { effect: entry.name, why });
        }
        // The list that is read holds no more than this one.
        let _room = active.push(one);
    }
    let glass =
        Cylinder { radius_m: header.radius_m, depth_m: header.fill_m, density_kg_m3: named.density_kg_m3 };
    let model =
        |active: &[Active]| ReducedModel::new(glass, *liquid, &Baseline::default(), active, header.dt_s);
    let (plain, with) = (model(&[]), model(&active));
    let observation_model = ObservationModel::new(header.radius_m, header.fill_m, &with);
    Ok((Slots::between(&plain, &with, map, header.energy_scale_j, hessian), observation_model))
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
}
