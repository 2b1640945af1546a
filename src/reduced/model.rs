//! A glass of liquid with its effects: every coefficient that a step needs.

use super::modes::{Cylinder, RADIAL, SloshMode, Wave};
use crate::math::{sqrt, tan};
use crate::reduced::bound_waves::{FirstModeContext, second_order};
use crate::reduced::boundary_layer::{Rheology, friction};
use crate::reduced::effects::{Active, Branch, MOST, Port, Slot, View};
use crate::reduced::second_order::BoundWaves;
use crate::reduced::speed_table::{SLOWEST_M_S, SpeedTable};
use crate::units::GRAVITY_M_S2;
use heapless::Vec;

/// Speed at the wall at which the layer's lowering of the frequency is taken, m/s: a middling slosh.
pub(super) const MIDDLING_M_S: f64 = 0.1;

/// What the plain model is allowed to be off by, and what its second order is; calibrated on reference
/// recordings of a known liquid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Baseline {
    /// Relative offsets of the frequencies of the modes (1,n).
    pub frequency: [f64; RADIAL],
    /// Factors on the damping of the modes (1,n).
    pub damping: [f64; RADIAL],
    /// Factors on the forcing of the modes (1,n).
    pub lever: [f64; RADIAL],
    /// Softening kappa: `w = w1 (1 - kappa A^2/R^2)` at amplitude A (Bauerlein and Avila 2021).
    pub detuning: f64,
    /// Coefficients p and q of (0,1) and (2,1), see [`BoundWaves`].
    pub drive: [[f64; 2]; 2],
}

impl Default for Baseline {
    /// Linear theory; the second order of an inviscid standing wave is of the order of one half.
    fn default() -> Self {
        Self {
            frequency: [0.0; RADIAL],
            damping: [1.0; RADIAL],
            lever: [1.0; RADIAL],
            detuning: 0.0,
            drive: [[0.5, -0.5], [0.5, -0.5]],
        }
    }
}

/// One mode (1,n), ready for steps.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ready {
    pub(super) mode: SloshMode,
    /// Stiffness of the discrete oscillator, N/m.
    pub(super) stiffness: f64,
    /// Force for each m/s2 of push, kg.
    pub(super) push_kg: f64,
    /// Stiffness for each m/s2 of lift, kg/m.
    pub(super) lift_kg_m: f64,
    /// Frequency, 1/s.
    pub(super) w: f64,
    /// Frequency without friction, 1/s.
    free: f64,
    /// Friction G by the amplitude of the rate, N s/m.
    pub(super) friction: SpeedTable,
}

/// A glass of liquid with its effects, for steps of one length.
#[derive(Clone, Debug)]
pub struct ReducedModel {
    /// Glass and liquid at rest, with the effects on them.
    pub glass: Cylinder,
    /// What the glass's motion becomes before it drives the liquid.
    pub port: Port,
    /// What the surface becomes before it is measured.
    pub view: View,
    pub(super) dt: f64,
    pub(super) modes: [Ready; RADIAL],
    pub(super) second: BoundWaves,
    /// Quartic coefficient of the first mode's energy, N/m3.
    pub(super) quartic: f64,
    /// Coupling of its two directions, N/m.
    pub(super) coupling: f64,
    pub(super) memory: [Branch; RADIAL],
    pub(super) line: Branch,
    /// Friction along the contact line, evaluated at the amplitude of its speed.
    pub(super) rubbing: Vec<Active, MOST>,
}

impl ReducedModel {
    /// The model of `glass` filled with `liquid` under `baseline` with the effects `active`, for steps of
    /// `dt` seconds; at most [`MOST`] effects act, further ones are left out.
    #[must_use]
    pub fn new(glass: Cylinder, liquid: Rheology, baseline: &Baseline, active: &[Active], dt: f64) -> Self {
        let (mut glass, mut liquid) = (glass, liquid);
        let (mut port, mut view) = (Port::default(), View::default());
        let mut rubbing = Vec::new();
        for effect in active {
            match effect.entry.slot {
                Slot::Liquid(change) => change(&effect.values, &mut liquid),
                Slot::Vessel(change) => change(&effect.values, &mut glass),
                Slot::Port(change) => change(&effect.values, &mut port),
                Slot::View(change) => change(&effect.values, &mut view),
                // More than fit are left out, as said above.
                Slot::Line(_) => drop(rubbing.push(*effect)),
                Slot::Stiffness(_) | Slot::FirstMode(_) | Slot::Memory(_) | Slot::Catch(_) => {}
            }
        }
        let ready = |n: usize| ready(n, &glass, &liquid, baseline, active, dt);
        let modes: [Ready; RADIAL] = core::array::from_fn(ready);
        let stiffness = modes.first().map_or(0.0, |m| m.stiffness);
        // A^2 = a^2 of a Duffing oscillator: w = w0 (1 + 3 alpha A^2/(8 w0^2)), energy m alpha a^4/4.
        let soften = |kappa: f64| -8.0 / 3.0 * kappa * stiffness / (glass.radius_m * glass.radius_m);
        let (mut quartic, mut coupling) = (soften(baseline.detuning), 0.0);
        let memory = modes.map(|ready| memory(active, &ready.mode, &glass));
        let mut line = Branch::default();
        for effect in active {
            match effect.entry.slot {
                Slot::FirstMode(shape) => {
                    let shape = shape(&effect.values);
                    quartic += soften(shape.softening);
                    coupling += shape.coupling * stiffness;
                }
                Slot::Catch(branch) => line = branch(&effect.values, &glass),
                _ => {}
            }
        }
        let second = second_order(
            &glass,
            &liquid,
            baseline,
            active,
            &FirstModeContext { port: &port, line: &line, first: &modes[0], dt },
        );
        Self { glass, port, view, dt, modes, second, quartic, coupling, memory, line, rubbing }
    }

    /// Frequency (1/s) and damping gamma (1/s) of the mode (1,n) at small amplitude; none where there is
    /// no such mode.
    #[must_use]
    pub fn frequency_and_damping(&self, n: usize) -> Option<(f64, f64)> {
        self.modes.get(n).map(|m| (m.w, m.friction.at(SLOWEST_M_S) / (2.0 * m.mode.mass_kg)))
    }

    /// Mass of the first mode, kg: its kinetic energy is `m v^2/2`.
    #[must_use]
    pub fn mass_kg(&self) -> f64 {
        self.modes[0].mode.mass_kg
    }

    /// Frequency of the first mode without friction, under the constant lift, 1/s.
    #[must_use]
    pub fn frequency(&self) -> f64 {
        let first = &self.modes[0];
        sqrt((first.free * first.free + first.mode.steepness * self.port.lift_m_s2).max(0.0))
    }

    /// Friction of the first mode at an amplitude of its rate (m/s), in the liquid and along the contact line,
    /// N s/m.
    #[must_use]
    pub fn first_mode_friction(&self, speed: f64) -> f64 {
        self.modes[0].friction.at(speed) + self.line_rubs(speed)
    }

    /// Friction along the contact line at an amplitude of its speed (m/s), N s/m.
    pub(super) fn line_rubs(&self, speed: f64) -> f64 {
        line_rubs(&self.rubbing, speed, &self.glass)
    }

    /// What remembers the first mode's way: in the liquid, and at the contact line. A stiffness of zero is none.
    #[must_use]
    pub fn branches(&self) -> [Branch; 2] {
        [self.memory[0], self.line]
    }

    /// The part of a static slope that the kept modes do not show, m for each unit of slope: the modes
    /// left out follow a push at once.
    #[must_use]
    pub fn residual_lever_m(&self) -> f64 {
        self.glass.radius_m - self.modes.iter().map(|m| m.mode.lever_m).sum::<f64>()
    }
}

/// Stiffness that `mode` gains by what the effects `active` store, N/m.
pub(super) fn stores(mode: &SloshMode, glass: &Cylinder, active: &[Active]) -> f64 {
    let one = |effect: &Active| match effect.entry.slot {
        Slot::Stiffness(extra) => extra(&effect.values, mode, glass),
        _ => 0.0,
    };
    active.iter().map(one).sum()
}

/// Friction of the effects `active` along the contact line at an amplitude of its speed (m/s), N s/m.
pub(super) fn line_rubs(active: &[Active], speed: f64, glass: &Cylinder) -> f64 {
    let one = |effect: &Active| match effect.entry.slot {
        Slot::Line(law) => law(&effect.values, speed, glass),
        _ => 0.0,
    };
    active.iter().map(one).sum()
}

/// Frequency squared (1/s2) of the discrete oscillator that turns by `w dt` a step of `dt`: it turns by
/// `2 atan(w' dt/2)`, so `w' = (2/dt) tan(w dt/2)`.
pub(super) fn discrete(w: f64, dt: f64) -> f64 {
    let root = 2.0 / dt * tan((0.5 * w * dt).min(1.5));
    root * root
}

/// What the liquid remembers of `mode`.
pub(super) fn memory(active: &[Active], mode: &SloshMode, glass: &Cylinder) -> Branch {
    let one = |effect: &Active| match effect.entry.slot {
        Slot::Memory(branch) => Some(branch(&effect.values, mode, glass)),
        _ => None,
    };
    active.iter().filter_map(one).next_back().unwrap_or_default()
}

/// The mode (1,n) under all that acts on it.
fn ready(
    n: usize,
    glass: &Cylinder,
    liquid: &Rheology,
    baseline: &Baseline,
    active: &[Active],
    dt: f64,
) -> Ready {
    let mode = SloshMode::new(glass, Wave::First(n));
    let of = |values: &[f64; RADIAL], or: f64| values.get(n).copied().unwrap_or(or);
    let plain = mode.square(GRAVITY_M_S2);
    let shifted = sqrt((plain + stores(&mode, glass, active) / mode.mass_kg).max(0.01 * plain))
        * (1.0 + of(&baseline.frequency, 0.0));
    let rub = |speed: f64| friction(&mode, shifted, speed, liquid, glass);
    let factor = of(&baseline.damping, 1.0).max(0.0);
    let w = (shifted - rub(MIDDLING_M_S).1).max(0.1 * shifted);
    let square = discrete(w, dt);
    let stretch = square / (w * w);
    let at = |speed: f64| 2.0 * mode.mass_kg * factor * rub(speed).0;
    Ready {
        mode,
        stiffness: mode.mass_kg * square,
        push_kg: mode.mass_kg * mode.steepness * stretch * mode.lever_m * of(&baseline.lever, 1.0),
        lift_kg_m: mode.mass_kg * mode.steepness * stretch,
        w,
        free: shifted,
        friction: if liquid.is_linear() {
            SpeedTable::constant(at(MIDDLING_M_S))
        } else {
            SpeedTable::new(at)
        },
    }
}
