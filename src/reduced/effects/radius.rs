//! A wider or narrower glass than stated: `k = xi/R`, so that frequencies, forcing and layers all change.
//!
//! The value is the inner radius in m, because that is what a ruler shows and what a setup holds. The reduced model's
//! coordinate is the excess over the stated radius R0.

use super::{Class, Effect, EffectKind, FreeParameters, Parameter, Reference, Simulator, Slot};

pub(super) const EFFECT: Effect = Effect {
    kind: EffectKind::Radius,
    name: "radius",
    class: Class::View,
    parameters: &[Parameter {
        name: "length",
        spelling: "radius",
        unit: "m",
        reference: Reference::Radius,
        admissible: (0.003, 0.6),
        neutral: 0.0,
        range: (-0.005, 0.01),
        typical: 0.001,
        meaning: "inner radius of the glass",
    }],
    about: "the glass is wider or narrower than stated",
    source: "Lamb 1932, article 257; geometry",
    slot: Slot::Vessel(|[excess, _], glass| glass.radius_m = (glass.radius_m + excess).max(1e-3)),
    simulator: Simulator::Absent("it belongs to the scene's glass: state the radius there"),
    free: FreeParameters::All,
    twin: None,
    trial: None,
};
