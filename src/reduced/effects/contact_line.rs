//! A contact line that is caught and slides: a spring that yields to dry friction (Dahl 1968), at most
//! `f` N for each metre of line. With the line's height `u cos theta` all around,
//! ```text
//! force on the modes   int f sgn(u cos theta) cos theta R dtheta = 4 R f       slides
//! k_c = 4 R f/reach    z' = u' - |u'| z/reach                                  before it
//! ```
//! so `A' = -gamma A - c` and the slosh ends at `ln(1 + gamma A0/c)/gamma` (Viola, Brun, Gallaire 2018).

use super::{
    Branch, Class, Effect, EffectKind, FreeParameters, Law, Parameter, Reference, Relax, Simulator, Slot,
};

pub(super) const EFFECT: Effect = Effect {
    kind: EffectKind::ContactLine,
    name: "contact_line",
    class: Class::AmplitudeDamping,
    parameters: &[
        Parameter {
            name: "force",
            spelling: "contact_line",
            unit: "N/m",
            reference: Reference::Absolute,
            admissible: (0.0, 2.0),
            neutral: 0.0,
            range: (0.0, 1.0),
            typical: 0.01,
            meaning: "force per length at which the contact line slides",
        },
        Parameter {
            name: "reach",
            spelling: "contact_line_reach",
            unit: "m",
            reference: Reference::Absolute,
            admissible: (1e-5, 0.02),
            neutral: 5e-4,
            range: (5e-5, 2e-3),
            typical: 3e-4,
            meaning: "deflection at which the line slides; 0.0005 unless given",
        },
    ],
    about: "the contact line sticks and slides (hysteresis)",
    source: "Dahl 1968; Viola, Brun and Gallaire 2018; Dollet, Lorenceau and Gallaire 2020",
    slot: Slot::Catch(|[force, reach], glass| Branch {
        stiffness: 4.0 * glass.radius_m * force / reach.max(1e-6),
        relax: Relax::Path(*reach),
    }),
    simulator: Simulator::Law(Law::ContactLine),
    free: FreeParameters::First,
    twin: None,
    trial: Some(|size| 0.03 * size),
};
