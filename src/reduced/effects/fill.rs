//! More or less liquid than stated: depth and level both change, `w^2 = g k tanh k(h + d)`.

use super::{Class, Entry, Parameter, Slot};

pub(super) const ENTRY: Entry = Entry {
    name: "fill",
    class: Class::View,
    parameters: &[Parameter {
        name: "excess",
        unit: "m",
        neutral: 0.0,
        range: (-0.03, 0.03),
        typical: 0.002,
        meaning: "height of the liquid at rest over the stated one",
    }],
    about: "there is more or less liquid than stated",
    source: "Lamb 1932, article 257; geometry",
    slot: Slot::Vessel(|[excess, _], glass| glass.depth_m += excess),
};
