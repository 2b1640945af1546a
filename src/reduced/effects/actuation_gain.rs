//! The glass goes farther, or less far, than it is said to: `x -> f x`.

use super::{Class, Entry, Parameter, Slot};

pub(super) const ENTRY: Entry = Entry {
    name: "actuation_gain",
    class: Class::Actuation,
    parameters: &[Parameter {
        name: "factor",
        unit: "1",
        neutral: 1.0,
        range: (0.5, 1.5),
        typical: 0.05,
        meaning: "way of the glass over the stated one",
    }],
    about: "the glass is moved farther or less far than stated",
    source: "linearity of the port",
    slot: Slot::Port(|[factor, _], port| port.gain *= factor),
};
