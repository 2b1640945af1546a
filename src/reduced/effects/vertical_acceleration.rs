//! Effective gravity: a glass that is accelerated upwards by a has `g + a`. A constant one, and the part
//! of the recorded vertical acceleration that the model does not have yet. It acts where the glass's motion
//! does, but it changes the restoring force of the surface.

use super::{
    Class, Effect, EffectKind, FreeParameters, Law, Parameter, Recorded, Reference, Simulator, Slot,
};

pub(super) const EFFECT: Effect = Effect {
    kind: EffectKind::VerticalAcceleration,
    name: "vertical_acceleration",
    class: Class::Stiffness,
    parameters: &[
        Parameter {
            name: "lift",
            spelling: "vertical_acceleration",
            unit: "m/s2",
            reference: Reference::Absolute,
            admissible: (-5.0, 20.0),
            neutral: 0.0,
            range: (-5.0, 20.0),
            typical: 0.3,
            meaning: "constant upward acceleration of the glass",
        },
        Parameter {
            name: "share",
            spelling: "vertical_acceleration_share",
            unit: "1",
            reference: Reference::Absolute,
            admissible: (-0.2, 1.5),
            neutral: 0.0,
            range: (-0.2, 1.5),
            typical: 0.5,
            meaning: "part of the recorded vertical acceleration that acts beyond the share that the model gets",
        },
    ],
    about: "gravity is not what it seems: the glass is accelerated vertically",
    source: "equivalence of gravity and acceleration",
    slot: Slot::Port(|[lift, share], port| {
        port.lift_m_s2 += lift;
        port.lift_share += share;
    }),
    simulator: Simulator::Law(Law::VerticalAcceleration),
    free: FreeParameters::FirstOrRecorded(Recorded::Lift),
    twin: None,
    trial: Some(|size| 0.5 * size),
};
