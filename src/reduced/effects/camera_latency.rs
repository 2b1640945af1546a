//! The picture is older than its time says: everything seen is late by the same time.

use super::{Class, Effect, EffectKind, FreeParameters, Parameter, Reference, Simulator, Slot};

pub(super) const EFFECT: Effect = Effect {
    kind: EffectKind::CameraLatency,
    name: "camera_latency",
    class: Class::Timing,
    parameters: &[Parameter {
        name: "latency",
        spelling: "camera_latency",
        unit: "s",
        reference: Reference::Absolute,
        admissible: (-0.2, 0.2),
        neutral: 0.0,
        range: (-0.2, 0.2),
        typical: 0.02,
        meaning: "age of the picture beyond its time stamp",
    }],
    about: "the camera's pictures are late",
    source: "shift of the view in time",
    slot: Slot::View(|[latency, _], view| view.latency_s += latency),
    simulator: Simulator::Absent("it changes what the camera shows, not the liquid"),
    free: FreeParameters::All,
    twin: Some(EffectKind::ActuationDelay),
    trial: Some(|size| 0.033 * size),
};
