//! The two directions of the first mode exchange energy: `E += c K a_x a_y`. A glass or a motion that is
//! not quite round splits the frequency by `c w/2` either way, and the wave turns out of the plane and
//! back in `2 pi/(c w)` (Faltinsen and Timokha 2009; Marcotte, Gallaire and Bongarzone 2023).

use super::{Class, Entry, First, Parameter, Slot};

pub(super) const ENTRY: Entry = Entry {
    name: "swirl",
    class: Class::Shape,
    parameters: &[Parameter {
        name: "coupling",
        unit: "1",
        neutral: 0.0,
        range: (0.0, 0.5),
        typical: 0.04,
        meaning: "coupling c of the two directions over the stiffness",
    }],
    about: "the wave turns out of the plane",
    source: "Faltinsen and Timokha 2009; Marcotte, Gallaire and Bongarzone 2023",
    slot: Slot::First(|[coupling, _]| First { softening: 0.0, coupling: *coupling }),
};
