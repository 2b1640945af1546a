//! Surface tension: `w^2 = (g k + sigma k^3/rho) tanh kh` (Lamb 1932, article 267), for a line that slides
//! freely at 90 degrees; so a mode's stiffness gains `sigma k^2 N`.

use super::{Class, Effect, EffectKind, FreeParameters, Law, Parameter, Reference, Simulator, Slot};

pub(super) const EFFECT: Effect = Effect {
    kind: EffectKind::SurfaceTension,
    name: "surface_tension",
    class: Class::Stiffness,
    parameters: &[Parameter {
        name: "tension",
        spelling: "surface_tension",
        unit: "N/m",
        reference: Reference::Absolute,
        admissible: (0.0, 2.0),
        neutral: 0.0,
        range: (0.0, 1.0),
        typical: 0.07,
        meaning: "surface tension sigma; the contact line is free at 90 degrees",
    }],
    about: "the surface pulls",
    source: "Lamb 1932, article 267",
    slot: Slot::Stiffness(|[tension, _], mode, _| tension * mode.k * mode.k * mode.area_m2),
    simulator: Simulator::Law(Law::SurfaceTension),
    free: FreeParameters::All,
    twin: None,
    trial: Some(|size| 0.2 * size),
};
