//! Flow index: `tau = k rate^n` with the stated viscosity as consistency k (Herschel and Bulkley 1926);
//! the damping then goes with the amplitude to the power n - 1 in the bulk.

use super::{Class, Effect, EffectKind, FreeParameters, Law, Parameter, Reference, Simulator, Slot};

pub(super) const EFFECT: Effect = Effect {
    kind: EffectKind::ShearThinning,
    name: "shear_thinning",
    class: Class::AmplitudeDamping,
    parameters: &[Parameter {
        name: "index",
        spelling: "shear_thinning",
        unit: "1",
        reference: Reference::Absolute,
        admissible: (0.1, 2.0),
        neutral: 1.0,
        range: (0.1, 1.0),
        typical: 0.3,
        meaning: "flow index n of tau = tau0 + k rate^n; below 1 the liquid thins",
    }],
    about: "the liquid thins when it is sheared",
    source: "Herschel and Bulkley 1926",
    slot: Slot::Liquid(|[index, _], liquid| liquid.index = *index),
    simulator: Simulator::Law(Law::ShearThinning),
    free: FreeParameters::All,
    twin: None,
    // 1 - n halves and doubles; beyond 0.8 nothing is left to thin.
    trial: Some(|size| 1.0 - (0.5 * size).min(0.8)),
};
