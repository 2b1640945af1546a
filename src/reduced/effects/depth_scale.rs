//! Every length seen is too large by one factor: a wrong depth unit, or refraction at the glass.

use super::{Class, Effect, EffectKind, FreeParameters, Parameter, Reference, Simulator, Slot};

pub(super) const EFFECT: Effect = Effect {
    kind: EffectKind::DepthScale,
    name: "depth_scale",
    class: Class::View,
    parameters: &[Parameter {
        name: "factor",
        spelling: "depth_scale",
        unit: "1",
        reference: Reference::Absolute,
        admissible: (0.7, 1.4),
        neutral: 1.0,
        range: (0.7, 1.4),
        typical: 0.04,
        meaning: "seen length over the true one",
    }],
    about: "the camera's lengths are off by a factor",
    source: "geometry of the pinhole camera",
    slot: Slot::View(|[factor, _], view| view.scale *= factor),
    simulator: Simulator::Absent("it changes what the camera shows, not the liquid"),
    free: FreeParameters::All,
    twin: None,
    trial: Some(|size| 1.0 + 0.05 * size),
};
