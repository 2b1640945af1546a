//! The picture is older than its time says: everything seen is late by the same time.

use super::{Class, Entry, Parameter, Slot};

pub(super) const ENTRY: Entry = Entry {
    name: "camera_latency",
    class: Class::Timing,
    parameters: &[Parameter {
        name: "latency",
        unit: "s",
        neutral: 0.0,
        range: (-0.2, 0.2),
        typical: 0.02,
        meaning: "age of the picture beyond its time stamp",
    }],
    about: "the camera's pictures are late",
    source: "shift of the view in time",
    slot: Slot::View(|[latency, _], view| view.latency_s += latency),
};
