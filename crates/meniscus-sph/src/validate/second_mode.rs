//! The second mode, excited by a short acceleration of the glass.

use super::fit::{Fit, fit};
use super::ring_down::{GLASS, momentum, setup};
use super::theory::{Mode, Tone};
use crate::{Error, Simulator};
use meniscus_data::liquids::Rheology;
use std::f64::consts::PI;

/// Length of the half sine that starts the second mode, s: short against both periods.
const PULSE_S: f64 = 0.05;

/// Its largest acceleration, m/s2.
const PULSE_M_S2: f64 = 1.5;

/// Start of the fit, s: by then sound has died away.
const AFTER_S: f64 = 0.08;

/// Fits the second mode, started by a pulse of the glass in a liquid without viscosity, beside the first mode, which is
/// fitted before; `None` where the series do not determine them.
pub(super) fn second_mode(
    spacing_m: f64,
    seconds: f64,
    mut watch: impl FnMut(f64),
) -> Result<Option<Fit>, Error> {
    let modes = [Mode::first(GLASS), Mode::second(GLASS)];
    let mut simulator = Simulator::new(&setup(Rheology::newtonian(0.0), spacing_m, true))?;
    let pulse = |t: f64| if t < PULSE_S { PULSE_M_S2 * (PI * t / PULSE_S).sin() } else { 0.0 };
    let mut series = [Vec::new(), Vec::new()];
    while simulator.time_s() < seconds {
        simulator.step(pulse)?;
        if simulator.time_s() > AFTER_S {
            for (series, mode) in series.iter_mut().zip(&modes) {
                series.push((simulator.time_s(), momentum(&simulator, mode)));
            }
        }
        watch(simulator.time_s() / seconds);
    }
    let guess = |mode: &Mode| Tone { hz: mode.hz(), decay: 0.5 };
    let first = fit(&series[0], guess(&modes[0]), &[]);
    Ok(first.and_then(|first| fit(&series[1], guess(&modes[1]), &[first.tone])))
}
