//! Surface tension: `w^2 = (g k + sigma k^3/rho) tanh kh` (Lamb 1932, article 267), for a line that slides
//! freely at 90 degrees; so a mode's stiffness gains `sigma k^2 N`.

use super::{Class, Entry, Parameter, Slot};

pub(super) const ENTRY: Entry = Entry {
    name: "surface_tension",
    class: Class::Stiffness,
    parameters: &[Parameter {
        name: "tension",
        unit: "N/m",
        neutral: 0.0,
        range: (0.0, 1.0),
        typical: 0.07,
        meaning: "surface tension sigma beside that of the baseline",
    }],
    about: "the surface pulls",
    source: "Lamb 1932, article 267",
    slot: Slot::Stiffness(|[tension, _], mode, _| tension * mode.k * mode.k * mode.area_m2),
};
