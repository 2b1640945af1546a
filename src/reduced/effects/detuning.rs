//! Amplitude detuning beyond the baseline's: `w = w1 (1 - kappa A^2/R^2)`, a Duffing term in the energy
//! (Bauerlein and Avila 2021; deep vessels soften, shallow ones harden).

use super::{Class, Entry, First, Parameter, Slot};

pub(super) const ENTRY: Entry = Entry {
    name: "detuning",
    class: Class::Shape,
    parameters: &[Parameter {
        name: "softening",
        unit: "1",
        neutral: 0.0,
        range: (-1.0, 1.0),
        typical: 0.1,
        meaning: "softening kappa beside that of the baseline",
    }],
    about: "the frequency depends on the amplitude",
    source: "Bauerlein and Avila 2021",
    slot: Slot::First(|[softening, _]| First { softening: *softening, coupling: 0.0 }),
};
