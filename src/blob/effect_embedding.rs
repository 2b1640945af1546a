//! Embedding of effects: from the list of a blob to the slots of the step and the observation model.
//!
//! Effects of the liquid and of gravity act in the step ([`Slots`]), the others on the measurement ([`ObservationModel`]).

use super::LoadError;
use super::embedded_effects::EmbeddedEffects;
use super::header::Header;
use super::observation_model::ObservationModel;
use crate::latent::generic::{LATENTS, ModeMap, Slots};
use crate::reduced::effects::{Active, MOST, Port, Slot, View, find};
use crate::reduced::{Baseline, Cylinder, ReducedModel};
use heapless::Vec;
use nalgebra::SMatrix;

/// Returns the reason that a blob cannot embed `effect`; `None` where it can.
fn embedding_obstacle(effect: &Active) -> Option<&'static str> {
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
        return Some("a board receives no inclination and no vertical motion that it could take a share of");
    }
    None
}

/// Returns the slots and the observation model of the effects in `embedded`; `hessian` is that of H at rest.
pub(super) fn embed(
    header: &Header,
    embedded: &EmbeddedEffects,
    map: ModeMap,
    hessian: &SMatrix<f64, LATENTS, LATENTS>,
) -> Result<(Slots, ObservationModel), LoadError> {
    let liquid = &embedded.liquid;
    let sound = [
        ("density_kg_m3", embedded.density_kg_m3, 1e-9),
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
    for (index, effect) in embedded.effects.iter().enumerate() {
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
        Cylinder { radius_m: header.radius_m, depth_m: header.fill_m, density_kg_m3: embedded.density_kg_m3 };
    let model =
        |active: &[Active]| ReducedModel::new(glass, *liquid, &Baseline::default(), active, header.dt_s);
    let (plain, with) = (model(&[]), model(&active));
    let observation_model = ObservationModel::new(header.radius_m, header.fill_m, &with);
    Ok((Slots::between(&plain, &with, map, header.energy_scale_j, hessian), observation_model))
}
