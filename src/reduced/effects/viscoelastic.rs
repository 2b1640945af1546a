//! Viscoelastic relaxation: a Maxwell branch, modulus G and time lambda, in the bulk's strain and in the layer at the wall
//! (`wall_impedance`). In the bulk it is an inner variable:
//! ```text
//! dissipation of a viscosity mu in the bulk   2 m (2 mu/rho k^2) v^2/2     so  G_friction = 4 m mu k^2/rho
//! the branch                                  k_z = 4 m G k^2/rho,   z' = v - z/lambda
//! ```
//! The bulk raises frequency and damping both: `dw/w = x^2/(1 + x^2) q`, `gamma = w x/(1 + x^2) q`, x = w lambda,
//! `q = 2 G k^2/(rho w^2)` (Maxwell 1867; Bird, Armstrong and Hassager 1987). A relaxation much faster than a radian of
//! the slosh, x << 1, is a viscosity G lambda and is to be called that: the range of lambda begins at 0.02 s.

use super::{Class, Effect, EffectKind, FreeParameters, Law, Parameter, Reference, Simulator, Slot};
use crate::reduced::Maxwell;

pub(super) const EFFECT: Effect = Effect {
    kind: EffectKind::Viscoelastic,
    name: "viscoelastic",
    class: Class::Stiffness,
    parameters: &[
        Parameter {
            name: "modulus",
            spelling: "viscoelastic",
            unit: "Pa",
            reference: Reference::Absolute,
            admissible: (0.0, 500.0),
            neutral: 0.0,
            range: (0.0, 200.0),
            typical: 3.0,
            meaning: "modulus G of a Maxwell stress beside the viscous one",
        },
        Parameter {
            name: "time",
            spelling: "viscoelastic_time",
            unit: "s",
            reference: Reference::Absolute,
            admissible: (1e-3, 100.0),
            neutral: 0.05,
            range: (0.02, 1.0),
            typical: 0.03,
            meaning: "relaxation time lambda of that stress; 0.05 unless given",
        },
    ],
    about: "the liquid remembers its strain",
    source: "Maxwell 1867; Bird, Armstrong and Hassager 1987",
    slot: Slot::Memory(|[modulus, time]| Maxwell { modulus_pa: *modulus, time_s: *time }),
    simulator: Simulator::Law(Law::Viscoelastic),
    free: FreeParameters::All,
    twin: None,
    trial: Some(|size| 5.0 * size),
};
