//! Yield stress: `tau = tau0 + K rate` (Bingham 1922); `A' = -gamma A - c` comes to rest in a finite time
//! (Cheng and Olshanskii 2016).

use super::{Class, Effect, EffectKind, FreeParameters, Law, Parameter, Reference, Simulator, Slot};

pub(super) const EFFECT: Effect = Effect {
    kind: EffectKind::YieldStress,
    name: "yield_stress",
    class: Class::AmplitudeDamping,
    parameters: &[Parameter {
        name: "stress",
        spelling: "yield_stress",
        unit: "Pa",
        reference: Reference::Absolute,
        admissible: (0.0, 1000.0),
        neutral: 0.0,
        range: (0.0, 100.0),
        typical: 1.0,
        meaning: "stress tau0 below which the liquid does not flow",
    }],
    about: "the liquid stands below a stress",
    source: "Bingham 1922; Herschel and Bulkley 1926; Papanastasiou 1987",
    slot: Slot::Liquid(|[stress, _], liquid| liquid.yield_pa = *stress),
    simulator: Simulator::Law(Law::YieldStress),
    free: FreeParameters::All,
    twin: None,
    trial: Some(|size| 3.0 * size),
};
