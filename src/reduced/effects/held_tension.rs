//! Surface tension whose contact line does not move: `sigma k^2 N` of each mode as for a free line, and a meniscus.
//!
//! Beside a line that is held the surface is bent within the capillary length `l = sqrt(sigma/(rho g))`. Where the mode
//! would lift the line by u, the meniscus pulls back with
//! ```text
//! sigma u/l = sqrt(sigma rho g) u        per length of the line
//! ```
//! which stiffens a mode by `sqrt(sigma rho g) int phi^2 ds` along the wall: `pi R` of the waves with a sign, `2 pi R` of
//! the rings (Benjamin and Scott 1979; first order in l/R). The meniscus is all that the higher modes do, so that they
//! do not give way to it once more, as they do to the spring of `pinned_line`.

use super::{Class, Effect, EffectKind, FreeParameters, Parameter, Reference, Simulator, Slot};
use crate::math::sqrt;
use crate::units::GRAVITY_M_S2;
use core::f64::consts::{PI, TAU};

pub(super) const EFFECT: Effect = Effect {
    kind: EffectKind::HeldTension,
    name: "held_tension",
    class: Class::Stiffness,
    parameters: &[Parameter {
        name: "tension",
        spelling: "held_tension",
        unit: "N/m",
        reference: Reference::Absolute,
        admissible: (0.0, 2.0),
        neutral: 0.0,
        range: (0.0, 1.0),
        typical: 0.03,
        meaning: "surface tension sigma; the contact line does not move",
    }],
    about: "the surface pulls and its contact line is held",
    source: "Benjamin and Scott 1979",
    slot: Slot::Stiffness(|[tension, _], mode, glass| {
        let around = if mode.order == 0 { TAU } else { PI };
        let meniscus = sqrt((tension * glass.density_kg_m3 * GRAVITY_M_S2).max(0.0));
        tension * mode.k * mode.k * mode.area_m2 + around * glass.radius_m * meniscus
    }),
    simulator: Simulator::Absent(
        "its surface tension leaves the contact line free; use surface_tension and pinned_line",
    ),
    free: FreeParameters::All,
    twin: None,
    trial: None,
};
