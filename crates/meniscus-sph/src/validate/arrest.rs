//! A liquid with a yield stress comes to rest, where one without creeps on.
//!
//! The envelope `A` of a slosh in a thin-layered Herschel-Bulkley liquid obeys
//! ```text
//! A' = -gamma A - c - d A^((1+n)/2)
//! ```
//! whose constant `c`, the yield stress, brings it to rest in finite time; with `c = 0` it never is.
//! Here: `k = 0.5 Pa s^n, n = 0.5, tau0 = 3 Pa` against a Newtonian liquid of 0.25 Pa s.

use super::ring_down::{GLASS, setup};
use super::theory::Mode;
use crate::{Error, Simulator};
use meniscus_data::liquids::Rheology;

/// The liquid that is to stop; its viscosity is capped at 20 Pa s.
pub(super) const PLASTIC: Rheology =
    Rheology { consistency: 0.5, index: 0.5, yield_stress: 3.0, largest: 20.0 };

/// The viscosity of the liquid that is to go on, Pa s.
const NEWTONIAN_PA_S: f64 = 0.25;

/// Speed of the first mode at the start, m/s.
pub(super) const START_M_S: f64 = 0.05;

/// Part of the first speed below which the liquid counts as standing.
const STANDING: f64 = 0.03;

/// Arrest of the one liquid and creep of the other.
#[derive(Clone, Debug)]
pub(super) struct Arrest {
    /// When the plastic liquid first stood for good, s; not a number if it never did.
    pub(super) plastic_s: f64,
    /// Speed of the Newtonian liquid at that time and later, its largest, as a part of its first.
    pub(super) newtonian: f64,
}

/// Lets both ring for `seconds`.
pub(super) fn arrest(spacing_m: f64, seconds: f64, mut watch: impl FnMut(f64)) -> Result<Arrest, Error> {
    let plastic = speeds(PLASTIC, spacing_m, seconds, |part| watch(0.8 * part))?;
    let newtonian =
        speeds(Rheology::newtonian(NEWTONIAN_PA_S), spacing_m, seconds, |part| watch(0.8 + 0.2 * part))?;
    let moving = plastic.iter().rposition(|(_, speed)| *speed > STANDING);
    let stood = moving.map_or(0, |last| last + 1);
    let plastic_s = plastic.get(stood).map_or(f64::NAN, |(time, _)| *time);
    let later = newtonian.iter().filter(|(time, _)| *time >= plastic_s);
    Ok(Arrest { plastic_s, newtonian: later.map(|(_, speed)| *speed).fold(0.0, f64::max) })
}

/// Times (s) and root mean square speeds as parts of the first.
fn speeds(
    rheology: Rheology,
    spacing_m: f64,
    seconds: f64,
    mut watch: impl FnMut(f64),
) -> Result<Vec<(f64, f64)>, Error> {
    let mode = Mode::first(GLASS);
    let mut simulator = Simulator::new(&setup(rheology, spacing_m, true))?;
    simulator.set_velocity(|x| mode.velocity(x).map(|v| START_M_S * v));
    let first = simulator.energy().kinetic;
    let mut series = Vec::new();
    while simulator.time_s() < seconds {
        simulator.step(|_| 0.0)?;
        series.push((simulator.time_s(), (simulator.energy().kinetic / first).sqrt()));
        watch(simulator.time_s() / seconds);
    }
    Ok(series)
}
