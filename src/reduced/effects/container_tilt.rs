//! An inclined glass: gravity leaves `g sin theta` along the surface. Under a constant angle the surface is
//! level in the room and `tan theta` in the glass: at rest the same in a profile as a rolled camera. A wave
//! distinguishes the two, because in a glass that leans it carries waves of other shapes along (`reduced::bound_waves`).
//! Beside it the part of the recorded inclination that the model does not have yet, which acts as an acceleration input.

use super::{
    Class, Effect, EffectKind, FreeParameters, Law, Parameter, Recorded, Reference, Simulator, Slot,
};

pub(super) const EFFECT: Effect = Effect {
    kind: EffectKind::ContainerTilt,
    name: "container_tilt",
    class: Class::View,
    parameters: &[
        Parameter {
            name: "angle",
            spelling: "container_tilt",
            unit: "rad",
            reference: Reference::Absolute,
            admissible: (-0.35, 0.35),
            neutral: 0.0,
            range: (-0.35, 0.35),
            typical: 0.03,
            meaning: "constant inclination of the glass towards +x",
        },
        Parameter {
            name: "share",
            spelling: "container_tilt_share",
            unit: "1",
            reference: Reference::Absolute,
            admissible: (-0.2, 1.5),
            neutral: 0.0,
            range: (-0.2, 1.5),
            typical: 0.5,
            meaning: "part of the recorded inclination that acts beyond the share that the model gets",
        },
    ],
    about: "the container is tilted",
    source: "gravity turned into the frame of the glass",
    slot: Slot::Port(|[angle, share], port| {
        port.tilt_rad += angle;
        port.tilt_share += share;
    }),
    simulator: Simulator::Law(Law::ContainerTilt),
    free: FreeParameters::FirstOrRecorded(Recorded::Inclination),
    twin: None,
    trial: Some(|size| 0.035 * size),
};
