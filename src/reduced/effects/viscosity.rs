//! Another viscosity than the liquid is said to have: `mu -> f mu`.

use super::{Class, Entry, Parameter, Slot};

pub(super) const ENTRY: Entry = Entry {
    name: "viscosity",
    class: Class::Damping,
    parameters: &[Parameter {
        name: "factor",
        unit: "1",
        neutral: 1.0,
        range: (0.2, 5.0),
        typical: 0.3,
        meaning: "viscosity over the stated one",
    }],
    about: "the liquid is thicker or thinner than it is said to be",
    source: "Case and Parkinson 1957; Lamb 1932",
    slot: Slot::Liquid(|[factor, _], liquid| liquid.consistency *= factor),
};
