//! The waves of the second order in a glass with its effects: what a step needs of each.
//!
//! As the modes (1,n) do, they feel what the effects store, the lift, and the layers, which rub and lower the frequency;
//! how thick the liquid is, the first mode says. At the wall they ride on it, too: a force `c |v|^p` per length that rubs
//! on it with `G = c v1^(p-1) R int |cos|^(p+1) dtheta` rubs on a small wave beside it with `p c |v1 cos|^(p-1)`, which makes
//! ```text
//! (p + 1) G of (0,n),      (p + 1 - 4p/(p + 3)) G of (2,n)
//! ```

use super::model::{Baseline, MIDDLING_M_S, Ready, discrete, line_rubs, memory, stores};
use super::modes::{Cylinder, RADIAL, SloshMode, Wave};
use crate::math::{ln, sqrt, tan};
use crate::reduced::boundary_layer::{Rheology, resistance, viscosities};
use crate::reduced::contact_line_friction::ContactLineFriction;
use crate::reduced::coupling::Coupling;
use crate::reduced::effects::{Active, Branch, Port, Relax};
use crate::reduced::second_order::{BoundWave, BoundWaves};
use crate::reduced::speed_table::SpeedTable;
use crate::units::GRAVITY_M_S2;
use core::f64::consts::PI;

/// What acts on these waves and is known already.
pub(super) struct FirstModeContext<'a> {
    /// What the motion of the glass becomes.
    pub(super) port: &'a Port,
    /// What catches the contact line.
    pub(super) line: &'a Branch,
    /// The first mode.
    pub(super) first: &'a Ready,
    /// Length of a step, s.
    pub(super) dt: f64,
}

/// The waves of the second order `beside` the first mode in `glass`, with p and q of (0,1) and (2,1) from `baseline`.
pub(super) fn second_order(
    glass: &Cylinder,
    liquid: &Rheology,
    baseline: &Baseline,
    active: &[Active],
    beside: &FirstModeContext<'_>,
) -> BoundWaves {
    let [ring, saddle] = baseline.drive;
    let rings: [Wave; RADIAL] = core::array::from_fn(Wave::Ring);
    let saddles: [Wave; RADIAL] = core::array::from_fn(Wave::Saddle);
    let ride = |wave: Wave| {
        let mut riding = riding(wave, glass, liquid, active, beside);
        match wave {
            Wave::Ring(0) => riding.drive = ring,
            Wave::Saddle(0) => riding.drive = saddle,
            _ => {}
        }
        riding
    };
    BoundWaves {
        waves: [rings.map(ride), saddles.map(ride)],
        radius_m: glass.radius_m,
        steepness: beside.first.mode.steepness,
        rim: rim(glass, beside.line, [rings, saddles]),
    }
}

/// One wave, driven as theory without viscosity says.
fn riding(
    wave: Wave,
    glass: &Cylinder,
    liquid: &Rheology,
    active: &[Active],
    beside: &FirstModeContext<'_>,
) -> BoundWave {
    let FirstModeContext { port, first, dt, .. } = *beside;
    let mode = SloshMode::new(glass, wave);
    let coupling = Coupling::with(wave);
    let kappa = [first.mode.steepness, mode.steepness];
    let stored = stores(&mode, glass, active) / mode.mass_kg;
    let least = 0.01 * mode.square(GRAVITY_M_S2);
    let free = sqrt((mode.square(GRAVITY_M_S2 + port.lift_m_s2) + stored).max(least));
    let layers = |speed: f64| {
        let thick = viscosities(&first.mode, first.w, speed, liquid, glass.density_kg_m3);
        resistance(&mode, free, thick, liquid, glass)
    };
    let foam = |speed: f64| line_rubs(active, speed, glass);
    let foamed = foam(MIDDLING_M_S) > 0.0;
    let damping = |speed: f64| {
        let here = foam(speed);
        let p = if foamed { 1.0 + ln(foam(1.1 * speed) / here) / ln(1.1) } else { 1.0 };
        let share = if mode.order == 0 { p + 1.0 } else { p + 1.0 - 4.0 * p / (p + 3.0) };
        layers(speed).0 + share * here / (2.0 * mode.mass_kg)
    };
    let w = (free - layers(MIDDLING_M_S).1).max(0.1 * free);
    let branch = memory(active, &mode, glass);
    BoundWave {
        square: w * w,
        discrete: discrete(w, dt),
        damping: if liquid.is_linear() && !foamed {
            SpeedTable::constant(damping(MIDDLING_M_S))
        } else {
            SpeedTable::new(damping)
        },
        drive: coupling.drive(kappa, glass.radius_m),
        carried: coupling.own(kappa, glass.radius_m),
        lean: coupling.lean(kappa, glass.radius_m) * tan(port.tilt_rad),
        memory: Branch { stiffness: branch.stiffness / mode.mass_kg, ..branch },
    }
}

/// The contact line beside `waves`: of a spring k_c along the wall the `line` has the stiffness `pi R k_c` if it holds,
/// `4 R k_c` if it slides.
fn rim(glass: &Cylinder, line: &Branch, waves: [[Wave; RADIAL]; 2]) -> Option<ContactLineFriction> {
    let (spring, reach_m) = match line.relax {
        Relax::Never => (line.stiffness / (PI * glass.radius_m), f64::INFINITY),
        Relax::Path(reach_m) => (line.stiffness / (4.0 * glass.radius_m), reach_m),
        Relax::Time(_) => return None,
    };
    let mass_kg = waves.map(|row| row.map(|wave| SloshMode::new(glass, wave).mass_kg));
    (spring > 0.0).then(|| ContactLineFriction::new(spring, reach_m, glass.radius_m, mass_kg))
}
