//! Another viscosity than the liquid's file states: `k -> f k`.
//!
//! The value is the viscosity in Pa s (of a Herschel-Bulkley liquid the consistency in Pa s^n), because that is what a
//! viscometer shows and what a liquid file holds. The reduced model's coordinate is the factor f over the stated one: its
//! formulas hold for a perturbation of a liquid, and a fit of f is equally conditioned in water and in honey.

use super::{Class, Effect, EffectKind, FreeParameters, Law, Parameter, Reference, Simulator, Slot};

pub(super) const EFFECT: Effect = Effect {
    kind: EffectKind::Viscosity,
    name: "viscosity",
    class: Class::Damping,
    parameters: &[Parameter {
        name: "consistency",
        spelling: "viscosity",
        unit: "Pa s^n",
        reference: Reference::Consistency,
        admissible: (0.0, 100.0),
        neutral: 1.0,
        range: (0.2, 5.0),
        typical: 0.3,
        meaning: "viscosity of the liquid, or consistency k of tau = tau0 + k rate^n",
    }],
    about: "the liquid is thicker or thinner than it is said to be",
    source: "Newton; Case and Parkinson 1957; Lamb 1932",
    slot: Slot::Liquid(|[factor, _], liquid| liquid.consistency *= factor),
    simulator: Simulator::Law(Law::Viscosity),
    free: FreeParameters::All,
    twin: None,
    trial: Some(|size| 1.0 + (1.3 - 1.0) * size),
};
