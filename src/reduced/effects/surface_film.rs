//! A film on the surface: `gamma += f/2 sqrt(nu w/2) k coth kh` (Miles 1967); f = 1 does not stretch, 2 is
//! about the most that an elastic film reaches.

use super::{Class, Entry, Parameter, Slot};

pub(super) const ENTRY: Entry = Entry {
    name: "surface_film",
    class: Class::Damping,
    parameters: &[Parameter {
        name: "stiffness",
        unit: "1",
        neutral: 0.0,
        range: (0.0, 2.0),
        typical: 0.5,
        meaning: "damping of the film over that of one that does not stretch",
    }],
    about: "a film (surfactant, dirt) holds the surface",
    source: "Miles 1967",
    slot: Slot::Liquid(|[stiffness, _], liquid| liquid.film = *stiffness),
};
