//! Height of the contact line: at rest in an inclined glass, and under a wave of known speed.
//!
//! ```text
//! inclined by theta     eta = tan(theta) x
//! first mode            eta(R) = V/w at most, where V is the speed of the surface at the wall as it passes rest
//! ```

use super::Held;
use super::fit::fit;
use super::ring_down::{GLASS, GLYCERINE, setup};
use super::theory::{Mode, Tone};
use crate::output::SurfaceFinder;
use crate::{Error, Setup, Simulator};
use meniscus::reduced::effects::EffectKind;
use meniscus_data::effects::Effects;
use meniscus_data::liquids::Rheology;
use meniscus_data::recording::wall_azimuth;
use std::f64::consts::PI;

/// Speed of the first mode at the wall when it starts, m/s.
const START_M_S: f64 = 0.05;

/// Start of the fit, s: by then sound has died away.
const AFTER_S: f64 = 0.05;

/// Steps between two looks at the surface.
const EVERY: usize = 8;

/// Slope at rest of the liquid in a glass that is inclined by 0.02 rad, the inclination of a waiter's tray.
pub(super) fn small_tilt(spacing_m: f64) -> Result<Held, Error> {
    const ANGLE: f64 = 0.02;
    Ok(Held { what: "slope at rest", measured: slope(&inclined(spacing_m, ANGLE)?), theory: ANGLE.tan() })
}

/// Slope at rest of the liquid by volume: `sum V x = slope pi R^4/4`.
pub(super) fn slope(simulator: &Simulator) -> f64 {
    let moment: f64 = simulator.motion().map(|(x, _, m)| m * x[0]).sum::<f64>() / GLYCERINE.0;
    moment / (0.25 * PI * GLASS.radius_m.powi(4))
}

/// Slope at rest as the contact line of a recording shows it, at 0.1 rad.
pub(super) fn wall_tilt(spacing_m: f64) -> Result<Held, Error> {
    const ANGLE: f64 = 0.1;
    let simulator = inclined(spacing_m, ANGLE)?;
    let finder = SurfaceFinder::new(&simulator)?;
    let measured = across(&simulator, &finder) / GLASS.radius_m;
    Ok(Held { what: "slope of the contact line at rest", measured, theory: ANGLE.tan() })
}

/// Height of the first mode at the wall as the contact line of a recording shows it, mm, without viscosity.
pub(super) fn wall_amplitude(
    spacing_m: f64,
    seconds: f64,
    mut watch: impl FnMut(f64),
) -> Result<Held, Error> {
    let mode = Mode::first(GLASS);
    let mut simulator = Simulator::new(&setup(Rheology::newtonian(0.0), spacing_m, true))?;
    let finder = SurfaceFinder::new(&simulator)?;
    simulator.set_velocity(|x| mode.velocity(x).map(|v| START_M_S * v));
    let mut series = Vec::new();
    while simulator.time_s() < seconds {
        for _ in 0..EVERY {
            simulator.step(|_| 0.0)?;
        }
        if simulator.time_s() > AFTER_S {
            series.push((simulator.time_s(), across(&simulator, &finder)));
        }
        watch(simulator.time_s() / seconds);
    }
    let found = fit(&series, Tone { hz: mode.hz(), decay: 0.0 }, &[])
        .ok_or_else(|| Error::Setup("the contact line does not determine an oscillation".into()))?;
    let [c, s] = found.amplitude;
    let theory = 1e3 * START_M_S / (2.0 * PI * mode.hz());
    Ok(Held { what: "height of the first mode at the wall, mm", measured: 1e3 * c.hypot(s), theory })
}

/// The settled liquid of a glass that is inclined by `angle` rad.
pub(super) fn inclined(spacing_m: f64, angle: f64) -> Result<Simulator, Error> {
    let effects = Effects::default().with(EffectKind::ContainerTilt, angle);
    Simulator::new(&Setup { effects, ..setup(Rheology::newtonian(GLYCERINE.1), spacing_m, true) })
}

/// First harmonic of the contact line along x, m.
fn across(simulator: &Simulator, finder: &SurfaceFinder) -> f64 {
    let surface = finder.coefficients(simulator, &finder.nearby(simulator));
    let (_, wall) = finder.heights(&surface);
    let sum: f64 = wall.iter().enumerate().map(|(k, h)| f64::from(*h) * wall_azimuth(k).cos()).sum();
    2.0 * sum / wall.len() as f64
}
