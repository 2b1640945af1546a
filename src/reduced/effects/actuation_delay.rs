//! The glass moves later than it is said to: `x(t) -> x(t - tau)`.

use super::{Class, Effect, EffectKind, FreeParameters, Parameter, Reference, Simulator, Slot};

pub(super) const EFFECT: Effect = Effect {
    kind: EffectKind::ActuationDelay,
    name: "actuation_delay",
    class: Class::Timing,
    parameters: &[Parameter {
        name: "delay",
        spelling: "actuation_delay",
        unit: "s",
        reference: Reference::Absolute,
        admissible: (-0.2, 0.2),
        neutral: 0.0,
        range: (-0.2, 0.2),
        typical: 0.02,
        meaning: "how much later the glass moves than stated",
    }],
    about: "the glass moves later than stated",
    source: "shift of the port in time",
    slot: Slot::Port(|[delay, _], port| port.delay_s += delay),
    simulator: Simulator::Absent(
        "its glass moves when the motion file says; shift the times of the motion instead",
    ),
    free: FreeParameters::All,
    twin: Some(EffectKind::CameraLatency),
    trial: Some(|size| 0.033 * size),
};
