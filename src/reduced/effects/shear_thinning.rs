//! Flow index: `tau = K rate^n` with the stated viscosity as consistency K (Herschel and Bulkley 1926);
//! the damping then goes with the amplitude to the power n - 1 in the bulk.

use super::{Class, Entry, Parameter, Slot};

pub(super) const ENTRY: Entry = Entry {
    name: "shear_thinning",
    class: Class::AmplitudeDamping,
    parameters: &[Parameter {
        name: "index",
        unit: "1",
        neutral: 1.0,
        range: (0.1, 1.0),
        typical: 0.3,
        meaning: "flow index n",
    }],
    about: "the liquid thins when it is sheared",
    source: "Herschel and Bulkley 1926",
    slot: Slot::Liquid(|[index, _], liquid| liquid.index = *index),
};
