//! Coefficients of the second-order waves in a glass with its effects.
//!
//! As the modes (1,n) do, they feel what the effects store, the lift, and the layers, which rub and lower the frequency;
//! how thick the liquid is, the first mode says. At the wall they ride on it, too: a force `c |v|^p` per length that rubs
//! on it with `G = c v1^(p-1) R int |cos|^(p+1) dtheta` rubs on a small wave beside it with `p c |v1 cos|^(p-1)`, which makes
//! ```text
//! (p + 1) G of (0,n),      (p + 1 - 4p/(p + 3)) G of (2,n)
//! ```

use super::baseline::Baseline;
use super::mode_coefficients::{MIDDLING_M_S, ModeCoefficients, discrete, line_rubs, memory, stores};
use super::modes::{Cylinder, RADIAL, SloshMode, Wave};
use crate::math::{ln, sqrt, tan};
use crate::reduced::bound_waves::{BoundWave, BoundWaves};
use crate::reduced::boundary_layer::{Rheology, resistance, viscosities};
use crate::reduced::contact_line_friction::ContactLineFriction;
use crate::reduced::coupling::Coupling;
use crate::reduced::effects::{Active, Branch, Port, Relax};
use crate::reduced::speed_table::SpeedTable;
use crate::units::GRAVITY_M_S2;
use core::f64::consts::PI;

/// First mode and its surroundings, as the second-order waves need them.
pub(super) struct FirstModeContext<'a> {
    /// Changes to the motion of the glass.
    pub(super) port: &'a Port,
    /// Inner variable of the contact line.
    pub(super) line: &'a Branch,
    /// The first mode.
    pub(super) first: &'a ModeCoefficients,
    /// Length of a step, s.
    pub(super) dt: f64,
}

/// Returns the second-order waves in the `context` of the first mode in `glass`, with p and q of (0,1) and (2,1) from `baseline`
/// where it has them.
pub(super) fn bound_waves(
    glass: &Cylinder,
    liquid: &Rheology,
    baseline: &Baseline,
    active: &[Active],
    context: &FirstModeContext<'_>,
) -> BoundWaves {
    let rings: [Wave; RADIAL] = core::array::from_fn(Wave::Ring);
    let saddles: [Wave; RADIAL] = core::array::from_fn(Wave::Saddle);
    let of_shape = |wave: Wave| {
        let bound_wave = bound_wave(wave, glass, liquid, active, context);
        match (wave, baseline.drive) {
            (Wave::Ring(0), Some([ring, _])) => calibrated(bound_wave, ring, glass, context),
            (Wave::Saddle(0), Some([_, saddle])) => calibrated(bound_wave, saddle, glass, context),
            _ => bound_wave,
        }
    };
    BoundWaves {
        waves: [rings.map(of_shape), saddles.map(of_shape)],
        radius_m: glass.radius_m,
        steepness: context.first.mode.steepness,
        contact_line: contact_line(glass, context.line, [rings, saddles]),
    }
}

/// Returns `wave` with the calibrated coefficients p and q of its `drive`, and the coupling to a lean that q implies.
///
/// `q = -R C/kappa1` says how far C is from that of an inviscid liquid. The layer at the wall is one reason: the flow along the wall
/// that it lacks takes `pi delta/(2 R N)` off C of (2,n), with N in units of R^2 and delta the thickness of the layer. What acts at the
/// wall is the same for `t x` as for `a1 phi1`, which are alike there, so `B` is off by R times as much as C.
fn calibrated(
    wave: BoundWave,
    drive: [f64; 2],
    glass: &Cylinder,
    context: &FirstModeContext<'_>,
) -> BoundWave {
    let excess = -drive[1] * context.first.mode.steepness - glass.radius_m * wave.carried;
    BoundWave { drive, lean: wave.lean + excess * tan(context.port.tilt_rad), ..wave }
}

/// Returns one wave, driven as inviscid theory says.
fn bound_wave(
    wave: Wave,
    glass: &Cylinder,
    liquid: &Rheology,
    active: &[Active],
    context: &FirstModeContext<'_>,
) -> BoundWave {
    let FirstModeContext { port, first, dt, .. } = *context;
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
    let branch = memory(liquid.maxwell, &mode, glass);
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

/// Returns the contact line beside `waves`: of a spring k_c along the wall the `line` has the stiffness `pi R k_c` if it holds,
/// `4 R k_c` if it slides.
fn contact_line(glass: &Cylinder, line: &Branch, waves: [[Wave; RADIAL]; 2]) -> Option<ContactLineFriction> {
    let (spring, reach_m) = match line.relax {
        Relax::Never => (line.stiffness / (PI * glass.radius_m), f64::INFINITY),
        Relax::Path(reach_m) => (line.stiffness / (4.0 * glass.radius_m), reach_m),
        Relax::Time(_) => return None,
    };
    let mass_kg = waves.map(|row| row.map(|wave| SloshMode::new(glass, wave).mass_kg));
    (spring > 0.0).then(|| ContactLineFriction::new(spring, reach_m, glass.radius_m, mass_kg))
}
