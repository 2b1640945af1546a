//! A roll of the camera that is not known of: the profile gains the slope `tan theta`, at rest too. A
//! glass that stands inclined does the same to the profile.

use super::{Class, Effect, EffectKind, FreeParameters, Parameter, Reference, Simulator, Slot};

pub(super) const EFFECT: Effect = Effect {
    kind: EffectKind::CameraSlope,
    name: "camera_slope",
    class: Class::View,
    parameters: &[Parameter {
        name: "angle",
        spelling: "camera_slope",
        unit: "rad",
        reference: Reference::Absolute,
        admissible: (-0.35, 0.35),
        neutral: 0.0,
        range: (-0.35, 0.35),
        typical: 0.02,
        meaning: "roll beyond the stated one, positive where +x is seen too high",
    }],
    about: "the camera is rolled",
    source: "rotation about the camera's axis",
    slot: Slot::View(|[angle, _], view| view.slope_rad += angle),
    simulator: Simulator::Absent("it changes what the camera shows, not the liquid"),
    free: FreeParameters::All,
    twin: None,
    trial: Some(|size| 0.052 * size),
};
