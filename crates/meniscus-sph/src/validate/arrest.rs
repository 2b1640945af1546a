//! A liquid with a yield stress comes to rest, where one without creeps on.
//!
//! Its stress does not fall below the yield stress, so that it decelerates the wave at the last as at the first. The theory is that of
//! [`super::by_law`]. Both have the same largest viscosity, by which they creep on after the wave has stopped.
//!
//! Here `k = 0.5 Pa s^n, n = 0.5, tau0 = 3 Pa` against a Newtonian liquid of 0.25 Pa s.

use super::by_law::{Scene, ring_by_law};
use super::ring_down::{GLASS, GLYCERINE, setup};
use super::theory::Mode;
use crate::{Error, Simulator};
use meniscus_data::liquids::Rheology;

/// The liquid that is to stop; its viscosity is capped at 20 Pa s.
const PLASTIC: Rheology = Rheology { consistency: 0.5, index: 0.5, yield_stress: 3.0, largest: 20.0 };

/// The viscosity of the liquid that is to go on, Pa s.
const NEWTONIAN_PA_S: f64 = 0.25;

/// Speed of the first mode at the start, m/s.
const START_M_S: f64 = 0.05;

/// Part of the first speed below which the liquid counts as standing.
const STANDING: f64 = 0.03;

/// Arrest of the one liquid and creep of the other.
#[derive(Clone, Debug)]
pub(super) struct Arrest {
    /// When the plastic liquid stood for good, s; not a number if it never did.
    pub(super) plastic_s: f64,
    /// Speed of the Newtonian liquid at that time and later, its largest, as a part of its first.
    pub(super) newtonian: f64,
    /// When the plastic liquid stands in theory, s.
    theory_s: f64,
}

impl Arrest {
    /// Relative error of the time at which the plastic liquid stands, signed, per cent.
    pub(super) fn error(&self) -> f64 {
        100.0 * (self.plastic_s / self.theory_s - 1.0)
    }
}

/// Lets both ring for `seconds`.
pub(super) fn arrest(spacing_m: f64, seconds: f64, mut watch: impl FnMut(f64)) -> Result<Arrest, Error> {
    let plastic = speeds(PLASTIC, spacing_m, seconds, |part| watch(0.8 * part))?;
    let newtonian =
        speeds(Rheology::newtonian(NEWTONIAN_PA_S), spacing_m, seconds, |part| watch(0.8 + 0.2 * part))?;
    let scene = Scene { glass: GLASS, density_kg_m3: GLYCERINE.0, rheology: PLASTIC };
    let theory = ring_by_law(&scene, START_M_S, seconds).unwrap_or_default();
    let theory: Vec<_> = theory.iter().map(|now| (now.time_s, now.speed)).collect();
    let [plastic_s, theory_s] = [&plastic, &theory].map(|series| stands(series));
    let later = newtonian.iter().filter(|(time, _)| *time >= plastic_s);
    Ok(Arrest { plastic_s, newtonian: later.map(|(_, speed)| *speed).fold(0.0, f64::max), theory_s })
}

/// When the speed of a series first stays below [`STANDING`], s; not a number if it never does.
fn stands(series: &[(f64, f64)]) -> f64 {
    let stood = series.iter().rposition(|(_, speed)| *speed > STANDING).map_or(0, |last| last + 1);
    series.get(stood).map_or(f64::NAN, |(time, _)| *time)
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
