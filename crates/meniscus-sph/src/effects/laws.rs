//! The laws that are on: one struct of the simulator's own numbers, from the one list of effects.
//!
//! The match over [`Law`] is exhaustive, so that an effect that the list gives to the simulator acts here or does not
//! compile.

use meniscus::reduced::effects::{LIBRARY, Law};
use meniscus_data::effects::Effects;

/// Deflection at which a contact line slides unless the effect says, m.
const REACH_M: f64 = 0.0005;

/// Deflection up to which a pinned line is a spring, m: more than a wave in a glass moves it.
const PINNED_REACH_M: f64 = 0.02;

/// Relaxation time of a Maxwell stress unless the effect says, s.
const RELAXATION_S: f64 = 0.05;

/// Contact line that is held by a spring and slides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Line {
    /// Force per length at which it slides, N/m.
    pub(crate) force_n_m: f64,
    /// Deflection at which it slides, m.
    pub(crate) reach_m: f64,
}

/// Maxwell stress.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Relaxation {
    /// Modulus G, Pa.
    pub(crate) modulus_pa: f64,
    /// Relaxation time, s.
    pub(crate) time_s: f64,
}

impl Relaxation {
    /// Returns the dissipating and the storing part of the viscosity `G lambda/(1 + i w lambda)` at `omega` rad/s, Pa s.
    pub(crate) fn viscosity(&self, omega: f64) -> [f64; 2] {
        let turn = omega * self.time_s;
        let lost = self.modulus_pa * self.time_s / (1.0 + turn * turn);
        [lost, turn * lost]
    }
}

/// Numbers of the laws that are on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Laws {
    /// Consistency instead of the liquid's, Pa s^n.
    pub(crate) consistency: Option<f64>,
    /// Flow index instead of the liquid's.
    pub(crate) index: Option<f64>,
    /// Yield stress instead of the liquid's, Pa.
    pub(crate) yield_stress_pa: Option<f64>,
    /// Slip length at a wall that sticks otherwise, m.
    pub(crate) slip_m: f64,
    /// Surface tension, N/m; none acts where it is zero.
    pub(crate) tension_n_m: Option<f64>,
    /// Contact line; none acts where its force is zero.
    pub(crate) line: Option<Line>,
    /// Coefficient beta of the foam, N/m (s/m)^(2/3); none acts where it is zero.
    pub(crate) foam: Option<f64>,
    /// Maxwell stress; none acts where its modulus is zero.
    pub(crate) relaxation: Option<Relaxation>,
    /// Constant inclination towards +x, rad.
    pub(crate) tilt_rad: f64,
    /// Constant upward acceleration, m/s2.
    pub(crate) lift_m_s2: f64,
    /// Height of the liquid at rest instead of the glass's, m.
    pub(crate) fill_m: Option<f64>,
}

impl Laws {
    /// Returns the laws of `effects`.
    pub(crate) fn of(effects: &Effects) -> Self {
        let mut laws = Self::default();
        for effect in &LIBRARY {
            let [first, second] = effects.values(effect.kind);
            let strong = first.filter(|value| *value > 0.0);
            let Some(law) = effect.simulator.law() else { continue };
            match law {
                Law::Viscosity => laws.consistency = first,
                Law::ShearThinning => laws.index = first,
                Law::YieldStress => laws.yield_stress_pa = first,
                Law::WallSlip => laws.slip_m = first.unwrap_or(0.0),
                Law::SurfaceTension => laws.tension_n_m = strong,
                Law::ContactLine => {
                    let line = |force_n_m| Line { force_n_m, reach_m: second.unwrap_or(REACH_M) };
                    laws.line = strong.map(line).or(laws.line);
                }
                Law::PinnedLine => {
                    let line =
                        |spring: f64| Line { force_n_m: PINNED_REACH_M * spring, reach_m: PINNED_REACH_M };
                    laws.line = strong.map(line).or(laws.line);
                }
                Law::Foam => laws.foam = strong,
                Law::Viscoelastic => {
                    let time_s = second.unwrap_or(RELAXATION_S);
                    laws.relaxation = strong.map(|modulus_pa| Relaxation { modulus_pa, time_s });
                }
                Law::ContainerTilt => laws.tilt_rad = first.unwrap_or(0.0),
                Law::VerticalAcceleration => laws.lift_m_s2 = first.unwrap_or(0.0),
                Law::Fill => laws.fill_m = first,
            }
        }
        laws
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_carried_effect_changes_the_laws() {
        assert_eq!(Laws::of(&Effects::default()), Laws::default());
        for effect in &LIBRARY {
            let parameter = &effect.parameters[0];
            let on = Effects::default().with(effect.kind, parameter.admissible.1);
            let carried = Laws::of(&on) != Laws::default();
            assert_eq!(carried, effect.simulator.law().is_some(), "{}", effect.name);
        }
    }

    #[test]
    fn a_pinned_line_is_a_spring_that_does_not_slide_in_a_glass() {
        let mut effects = Effects::default();
        effects.parse("pinned_line=10").expect("a spring");
        let line = Laws::of(&effects).line.expect("a line");
        assert!((line.force_n_m / line.reach_m - 10.0).abs() < 1e-12 && line.reach_m == 0.02, "{line:?}");
    }
}
