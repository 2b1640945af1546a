//! Slip at the wall: `u = b du/dn` (Navier 1823); the layer's impedance over `1 + (1 + i) b/delta`, see
//! [`friction`](crate::reduced::friction).

use super::{Class, Effect, EffectKind, FreeParameters, Law, Parameter, Reference, Simulator, Slot};

pub(super) const EFFECT: Effect = Effect {
    kind: EffectKind::WallSlip,
    name: "wall_slip",
    class: Class::Damping,
    parameters: &[Parameter {
        name: "length",
        spelling: "wall_slip",
        unit: "m",
        reference: Reference::Absolute,
        admissible: (0.0, f64::INFINITY),
        neutral: 0.0,
        range: (0.0, 0.1),
        typical: 0.002,
        meaning: "slip length b of u_wall = b du/dn; 0 sticks, inf slips freely",
    }],
    about: "the liquid slips along the wall",
    source: "Navier 1823",
    slot: Slot::Liquid(|[length, _], liquid| liquid.slip_m = *length),
    simulator: Simulator::Law(Law::WallSlip),
    free: FreeParameters::All,
    twin: None,
    trial: Some(|size| 0.003 * size),
};
