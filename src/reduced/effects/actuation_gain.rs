//! The glass goes farther, or less far, than it is said to: `x -> f x`.

use super::{Class, Effect, EffectKind, FreeParameters, Parameter, Reference, Simulator, Slot};

pub(super) const EFFECT: Effect = Effect {
    kind: EffectKind::ActuationGain,
    name: "actuation_gain",
    class: Class::Actuation,
    parameters: &[Parameter {
        name: "factor",
        spelling: "actuation_gain",
        unit: "1",
        reference: Reference::Absolute,
        admissible: (0.5, 1.5),
        neutral: 1.0,
        range: (0.5, 1.5),
        typical: 0.05,
        meaning: "travel of the glass over the stated one",
    }],
    about: "the glass is moved farther or less far than stated",
    source: "linearity of the port",
    slot: Slot::Port(|[factor, _], port| port.gain *= factor),
    simulator: Simulator::Absent("its glass moves as the motion file says; scale the motion instead"),
    free: FreeParameters::All,
    twin: None,
    trial: Some(|size| 1.0 + 0.08 * size),
};
