//! Coefficients of one mode under all effects: stiffness, forcing, frequency and friction.

use super::baseline::Baseline;
use super::modes::{Cylinder, RADIAL, SloshMode, Wave};
use crate::math::{sqrt, tan};
use crate::reduced::boundary_layer::{Rheology, friction};
use crate::reduced::effects::{Active, Branch, Relax, Slot};
use crate::reduced::speed_table::SpeedTable;
use crate::reduced::wall_impedance::Maxwell;
use crate::units::GRAVITY_M_S2;

/// Speed at the wall at which the layer's lowering of the frequency is taken, m/s: a middling slosh.
pub(super) const MIDDLING_M_S: f64 = 0.1;

/// Coefficients of one mode (1,n) for steps of one length.
#[derive(Clone, Copy, Debug)]
pub(super) struct ModeCoefficients {
    pub(super) mode: SloshMode,
    /// Stiffness of the discrete oscillator, N/m.
    pub(super) stiffness: f64,
    /// Force for each m/s2 of acceleration input, kg.
    pub(super) push_kg: f64,
    /// Stiffness for each m/s2 of lift, kg/m.
    pub(super) lift_kg_m: f64,
    /// Frequency, 1/s.
    pub(super) w: f64,
    /// Frequency without friction, 1/s.
    pub(super) free: f64,
    /// Friction G by the amplitude of the rate, N s/m.
    pub(super) friction: SpeedTable,
}

/// Returns the stiffness that `mode` gains by what the effects `active` store, N/m.
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

/// Returns the inner variable of the bulk for `mode`: a viscosity mu there has the friction `4 m mu k^2/rho`.
pub(super) fn memory(maxwell: Maxwell, mode: &SloshMode, glass: &Cylinder) -> Branch {
    if maxwell.modulus_pa == 0.0 {
        return Branch::default();
    }
    Branch {
        stiffness: 4.0 * mode.mass_kg * maxwell.modulus_pa * mode.k * mode.k / glass.density_kg_m3,
        relax: Relax::Time(maxwell.time_s),
    }
}

/// Returns the coefficients of the mode (1,n) under all that acts on it.
pub(super) fn coefficients(
    n: usize,
    glass: &Cylinder,
    liquid: &Rheology,
    baseline: &Baseline,
    active: &[Active],
    dt: f64,
) -> ModeCoefficients {
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
    ModeCoefficients {
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
