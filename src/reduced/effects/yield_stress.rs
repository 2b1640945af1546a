//! Yield stress: `tau = tau0 + K rate` (Bingham 1922); `A' = -gamma A - c` comes to rest in a finite time
//! (Cheng and Olshanskii 2016).

use super::{Class, Entry, Parameter, Slot};

pub(super) const ENTRY: Entry = Entry {
    name: "yield_stress",
    class: Class::AmplitudeDamping,
    parameters: &[Parameter {
        name: "stress",
        unit: "Pa",
        neutral: 0.0,
        range: (0.0, 100.0),
        typical: 1.0,
        meaning: "yield stress tau0",
    }],
    about: "the liquid stands below a stress",
    source: "Bingham 1922; Herschel and Bulkley 1926",
    slot: Slot::Liquid(|[stress, _], liquid| liquid.yield_pa = *stress),
};
