//! A pitch of the camera that is not known of: the near wall's points lie at depths `-R sqrt(1 - x^2/R^2)`,
//! so the profile bows by `theta R (1 - sqrt(1 - x^2/R^2))`, even in x, at rest too.

use super::{Class, Effect, EffectKind, FreeParameters, Parameter, Reference, Simulator, Slot};

pub(super) const EFFECT: Effect = Effect {
    kind: EffectKind::CameraPitch,
    name: "camera_pitch",
    class: Class::View,
    parameters: &[Parameter {
        name: "angle",
        spelling: "camera_pitch",
        unit: "rad",
        reference: Reference::Absolute,
        admissible: (-0.35, 0.35),
        neutral: 0.0,
        range: (-0.35, 0.35),
        typical: 0.02,
        meaning: "pitch beyond the stated one, positive when the camera looks down",
    }],
    about: "the camera is pitched",
    source: "rotation about the camera's horizontal",
    slot: Slot::View(|[angle, _], view| view.pitch_rad += angle),
    simulator: Simulator::Absent("it changes what the camera shows, not the liquid"),
    free: FreeParameters::All,
    twin: None,
    trial: Some(|size| 0.035 * size),
};
