//! A film on the surface: `gamma += f/2 sqrt(nu w/2) k coth kh` (Miles 1967); f = 1 does not stretch, 2 is
//! about the most that an elastic film reaches.

use super::{Class, Effect, EffectKind, FreeParameters, Parameter, Reference, Simulator, Slot};

pub(super) const EFFECT: Effect = Effect {
    kind: EffectKind::SurfaceFilm,
    name: "surface_film",
    class: Class::Damping,
    parameters: &[Parameter {
        name: "stiffness",
        spelling: "surface_film",
        unit: "1",
        reference: Reference::Absolute,
        admissible: (0.0, 2.0),
        neutral: 0.0,
        range: (0.0, 2.0),
        typical: 0.5,
        meaning: "damping of the film over that of one that does not stretch",
    }],
    about: "a film (surfactant, dirt) holds the surface",
    source: "Miles 1967",
    slot: Slot::Liquid(|[stiffness, _], liquid| liquid.film = *stiffness),
    simulator: Simulator::Absent("its surface has no film that could stretch"),
    free: FreeParameters::All,
    twin: None,
    trial: None,
};
