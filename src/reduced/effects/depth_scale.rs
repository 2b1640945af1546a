//! Every length seen is too large by one factor: a wrong depth unit, or refraction at the glass.

use super::{Class, Entry, Parameter, Slot};

pub(super) const ENTRY: Entry = Entry {
    name: "depth_scale",
    class: Class::View,
    parameters: &[Parameter {
        name: "factor",
        unit: "1",
        neutral: 1.0,
        range: (0.7, 1.4),
        typical: 0.04,
        meaning: "seen length over the true one",
    }],
    about: "the camera's lengths are off by a factor",
    source: "geometry of the pinhole camera",
    slot: Slot::View(|[factor, _], view| view.scale *= factor),
};
