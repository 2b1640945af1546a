//! More or less liquid than stated: depth and level both change, `w^2 = g k tanh k(h0 + d)`.
//!
//! The value is the height of the liquid at rest in m, because that is what a ruler shows and what a scene file holds for
//! the glass. The reduced model's coordinate is the excess d over the stated height h0.

use super::{Class, Effect, EffectKind, FreeParameters, Law, Parameter, Reference, Simulator, Slot};

pub(super) const EFFECT: Effect = Effect {
    kind: EffectKind::Fill,
    name: "fill",
    class: Class::View,
    parameters: &[Parameter {
        name: "height",
        spelling: "fill",
        unit: "m",
        reference: Reference::Fill,
        admissible: (0.005, 0.3),
        neutral: 0.0,
        range: (-0.03, 0.03),
        typical: 0.002,
        meaning: "height of the liquid at rest, from the bottom of the glass",
    }],
    about: "there is more or less liquid than stated",
    source: "Lamb 1932, article 257; geometry",
    slot: Slot::Vessel(|[excess, _], glass| glass.depth_m += excess),
    simulator: Simulator::Law(Law::Fill),
    free: FreeParameters::All,
    twin: None,
    trial: Some(|size| 0.003 * size),
};
