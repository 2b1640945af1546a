//! The two directions of the first mode exchange energy: `E += c K a_x a_y`. A glass or a motion that is
//! not quite round splits the frequency by `c w/2` either way, and the wave turns out of the plane and
//! back in `2 pi/(c w)` (Faltinsen and Timokha 2009; Marcotte, Gallaire and Bongarzone 2023).

use super::{
    Class, Effect, EffectKind, FirstModeEnergy, FreeParameters, Parameter, Reference, Simulator, Slot,
};

pub(super) const EFFECT: Effect = Effect {
    kind: EffectKind::Swirl,
    name: "swirl",
    class: Class::Shape,
    parameters: &[Parameter {
        name: "coupling",
        spelling: "swirl",
        unit: "1",
        reference: Reference::Absolute,
        admissible: (0.0, 0.5),
        neutral: 0.0,
        range: (0.0, 0.5),
        typical: 0.04,
        meaning: "coupling c of the two directions over the stiffness",
    }],
    about: "the wave turns out of the plane",
    source: "Faltinsen and Timokha 2009; Marcotte, Gallaire and Bongarzone 2023",
    slot: Slot::FirstMode(|[coupling, _]| FirstModeEnergy { softening: 0.0, coupling: *coupling }),
    simulator: Simulator::Absent(
        "its glass is round, and its waves turn by the equations of motion, not by a number",
    ),
    free: FreeParameters::All,
    twin: None,
    trial: None,
};
