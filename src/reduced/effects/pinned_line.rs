//! A contact line that is held by a spring and does not slide: force `k_c u cos theta` per length,
//! so every mode of azimuthal order one gains `k_c R int cos^2 = pi R k_c`, and all of them move against
//! it as one (Benjamin and Scott 1979; Hocking 1987 for the elastic line).

use super::{
    Branch, Class, Effect, EffectKind, FreeParameters, Law, Parameter, Reference, Relax, Simulator, Slot,
};
use core::f64::consts::PI;

pub(super) const EFFECT: Effect = Effect {
    kind: EffectKind::PinnedLine,
    name: "pinned_line",
    class: Class::Stiffness,
    parameters: &[Parameter {
        name: "spring",
        spelling: "pinned_line",
        unit: "N/m2",
        reference: Reference::Absolute,
        admissible: (0.0, 500.0),
        neutral: 0.0,
        range: (0.0, 500.0),
        typical: 5.0,
        meaning: "spring of the contact line: force per length for each metre of deflection",
    }],
    about: "the contact line is pinned",
    source: "Benjamin and Scott 1979; Hocking 1987",
    slot: Slot::Catch(|[spring, _], glass| Branch {
        stiffness: PI * glass.radius_m * spring,
        relax: Relax::Never,
    }),
    simulator: Simulator::Law(Law::PinnedLine),
    free: FreeParameters::All,
    twin: None,
    trial: Some(|size| 10.0 * size),
};
