//! A contact line that slides freely although the liquid sticks to the wall, or the other way round.
//!
//! A wall that sticks holds the line too, and the surface beside it is bent within a layer's depth: the first mode is
//! damped more and lowered less than layer theory says for a free line, see [`crate::reduced`], `finite_layer`. The value is
//! the share of that difference, 1 in the plain liquid. It is counted from what the baseline holds of the line
//! ([`crate::reduced::Baseline::held_line`]): at 1 the baseline's share stays.

use super::{Class, Effect, EffectKind, FreeParameters, Parameter, Reference, Simulator, Slot};

pub(super) const EFFECT: Effect = Effect {
    kind: EffectKind::StuckLine,
    name: "stuck_line",
    class: Class::Damping,
    parameters: &[Parameter {
        name: "share",
        spelling: "stuck_line",
        unit: "1",
        reference: Reference::Absolute,
        admissible: (0.0, 2.0),
        neutral: 1.0,
        range: (0.0, 2.0),
        typical: 0.5,
        meaning: "share of the contact line that a sticking wall holds; 1 is as in the plain liquid, 0 lets it slide freely",
    }],
    about: "the contact line slides where the wall was taken to hold it, or the other way round",
    source: "linearised Navier-Stokes equations, Ritz's method",
    slot: Slot::Liquid(|[share, _], liquid| liquid.held_line = *share),
    simulator: Simulator::Absent(
        "its wall holds the contact line wherever the liquid sticks; use wall_slip or pinned_line",
    ),
    free: FreeParameters::All,
    twin: None,
    trial: None,
};
