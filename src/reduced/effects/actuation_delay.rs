//! The glass moves later than it is said to: `x(t) -> x(t - tau)`.

use super::{Class, Entry, Parameter, Slot};

pub(super) const ENTRY: Entry = Entry {
    name: "actuation_delay",
    class: Class::Timing,
    parameters: &[Parameter {
        name: "delay",
        unit: "s",
        neutral: 0.0,
        range: (-0.2, 0.2),
        typical: 0.02,
        meaning: "how much later the glass moves than stated",
    }],
    about: "the glass moves later than stated",
    source: "shift of the port in time",
    slot: Slot::Port(|[delay, _], port| port.delay_s += delay),
};
