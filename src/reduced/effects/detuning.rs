//! Amplitude detuning beyond the baseline's: `w = w1 (1 - kappa A^2/R^2)`, a Duffing term in the energy
//! (Bauerlein and Avila 2021; deep vessels soften, shallow ones harden).

use super::{
    Class, Effect, EffectKind, FirstModeEnergy, FreeParameters, Parameter, Reference, Simulator, Slot,
};

pub(super) const EFFECT: Effect = Effect {
    kind: EffectKind::Detuning,
    name: "detuning",
    class: Class::Shape,
    parameters: &[Parameter {
        name: "softening",
        spelling: "detuning",
        unit: "1",
        reference: Reference::Absolute,
        admissible: (-1.0, 1.0),
        neutral: 0.0,
        range: (-1.0, 1.0),
        typical: 0.1,
        meaning: "softening kappa beside that of the baseline",
    }],
    about: "the frequency depends on the amplitude",
    source: "Bauerlein and Avila 2021",
    slot: Slot::FirstMode(|[softening, _]| FirstModeEnergy { softening: *softening, coupling: 0.0 }),
    simulator: Simulator::Absent("its waves detune by the equations of motion, not by a number"),
    free: FreeParameters::All,
    twin: None,
    trial: None,
};
