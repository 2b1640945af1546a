//! Foam on the wall: a force `beta |v|^(2/3)` per length of line (Bretherton 1961), of `v = u cos theta`.
//! The friction that loses as much in a cycle of amplitude u is
//! ```text
//! G = beta u^(-1/3) e(2/3) R int |cos theta|^(5/3) dtheta,      e(p) = 2 <|cos|^(p+1)>
//! ```
//! and the amplitude ends in a finite time (Viola et al. 2016; Sauret et al. 2015).

use super::{Class, Effect, EffectKind, FreeParameters, Law, Parameter, Reference, Simulator, Slot};
use crate::math::pow;
use core::f64::consts::TAU;

/// Mean of `|cos|^(5/3)` over a circle.
const MEAN: f64 = 0.535_594;

pub(super) const EFFECT: Effect = Effect {
    kind: EffectKind::Foam,
    name: "foam",
    class: Class::AmplitudeDamping,
    parameters: &[Parameter {
        name: "strength",
        spelling: "foam",
        unit: "N/m (s/m)^(2/3)",
        reference: Reference::Absolute,
        admissible: (0.0, 20.0),
        neutral: 0.0,
        range: (0.0, 20.0),
        typical: 0.03,
        meaning: "coefficient beta of the force per length beta |v|^(2/3) of foam on the wall",
    }],
    about: "foam rubs on the wall",
    source: "Bretherton 1961; Viola et al. 2016; Sauret et al. 2015",
    slot: Slot::Line(|[strength, _], speed, glass| {
        let rim = glass.radius_m * TAU * MEAN;
        strength * pow(speed.max(1e-4), -1.0 / 3.0) * 2.0 * MEAN * rim
    }),
    simulator: Simulator::Law(Law::Foam),
    free: FreeParameters::All,
    twin: None,
    trial: Some(|size| 0.1 * size),
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_is_that_of_a_circle() {
        let n = 20_000;
        let one =
            |i: u32| pow(crate::math::sincos(TAU * (f64::from(i) + 0.5) / f64::from(n)).1.abs(), 5.0 / 3.0);
        let mean = (0..n).map(one).sum::<f64>() / f64::from(n);
        assert!((mean - MEAN).abs() < 1e-5, "{mean}");
    }
}
