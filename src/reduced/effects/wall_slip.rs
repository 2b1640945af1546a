//! Slip at the wall: `u = b du/dn` (Navier 1823); the layer's impedance over `1 + (1 + i) b/delta`, see
//! [`friction`](crate::reduced::friction).

use super::{Class, Entry, Parameter, Slot};

pub(super) const ENTRY: Entry = Entry {
    name: "wall_slip",
    class: Class::Damping,
    parameters: &[Parameter {
        name: "length",
        unit: "m",
        neutral: 0.0,
        range: (0.0, 0.1),
        typical: 0.002,
        meaning: "slip length b",
    }],
    about: "the liquid slips along the wall",
    source: "Navier 1823",
    slot: Slot::Liquid(|[length, _], liquid| liquid.slip_m = *length),
};
