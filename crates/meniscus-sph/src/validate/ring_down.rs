//! A mode that rings out: the simulator against the frequency and decay of theory.
//!
//! The liquid starts with the velocity of the mode without viscosity, 0.05 m/s at the top of the wall, and a flat
//! surface. Its modal momentum `sum m v.grad(phi)` is fitted by a damped oscillation from 0.05 s on, because
//! the wall layer has to form first.

use super::cost::Stopwatch;
use super::fit::{Fit, fit};
use super::theory::{Mode, Tone};
use super::viscous::viscous_mode;
use crate::{Error, Setup, Simulator};
use meniscus_data::effects::Effects;
use meniscus_data::glass::WallShape;
use meniscus_data::liquids::{Liquid, Rheology};
use meniscus_data::recording::Glass;

/// The glass of every case.
pub(super) const GLASS: Glass =
    Glass { radius_m: 0.035, fill_m: 0.07, rim_m: 0.11, wall: WallShape::UPRIGHT };

/// Glycerine as in the paper: density kg/m3 and viscosity Pa s.
pub(super) const GLYCERINE: (f64, f64) = (1261.0, 0.950);

/// Speed of the mode at the top of the wall when it starts, m/s.
const START_M_S: f64 = 0.05;

/// Start of the fit, s.
const FORMED_S: f64 = 0.05;

/// One mode that rang out.
#[derive(Clone, Debug)]
pub struct Ringing {
    /// Name of the case, for the title of its picture.
    pub name: String,
    /// Times (s) and modal momenta as parts of the first.
    pub series: Vec<(f64, f64)>,
    /// The oscillation fitted to them.
    pub fit: Fit,
    /// The tone of linear theory.
    pub theory: Tone,
    /// Processor time for each simulated second.
    pub cost: f64,
}

/// A liquid of `rheology` with the density of glycerine in the glass.
pub(super) fn setup(rheology: Rheology, spacing_m: f64, no_slip: bool) -> Setup {
    let liquid = Liquid {
        name: "validation".into(),
        density_kg_m3: GLYCERINE.0,
        rheology,
        effects: Effects::default(),
    };
    Setup { glass: GLASS, liquid, spacing_m, seed: 0, no_slip, effects: Effects::default(), step_s: None }
}

/// Modal momentum of the present state, kg m/s.
pub(super) fn momentum(simulator: &Simulator, mode: &Mode) -> f64 {
    simulator.motion().map(|(x, v, m)| m * dot(mode.velocity(x), v)).sum()
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Lets the first mode ring for `seconds` in a liquid of `viscosity` (Pa s).
///
/// # Errors
/// As for [`Simulator::new`] and [`Simulator::step`].
pub(super) fn ring(
    name: &str,
    viscosity: f64,
    spacing_m: f64,
    no_slip: bool,
    seconds: f64,
    mut watch: impl FnMut(f64),
) -> Result<Ringing, Error> {
    let mode = Mode::first(GLASS);
    let mut simulator = Simulator::new(&setup(Rheology::newtonian(viscosity), spacing_m, no_slip))?;
    simulator.set_velocity(|x| mode.velocity(x).map(|v| START_M_S * v));
    let first = momentum(&simulator, &mode);
    let mut series = Vec::new();
    let stopwatch = Stopwatch::start();
    while simulator.time_s() < seconds {
        series.push((simulator.time_s(), momentum(&simulator, &mode) / first));
        simulator.step(|_| 0.0)?;
        watch(simulator.time_s() / seconds);
    }
    let cost = stopwatch.seconds() / simulator.time_s();
    let nu = viscosity / GLYCERINE.0;
    let inviscid = Tone { hz: mode.hz(), decay: 0.0 };
    let viscous = if viscosity > 0.0 { viscous_mode(&GLASS, nu, no_slip) } else { Some(inviscid) };
    let undetermined = || Error::Setup(format!("{name}: the decay does not determine an oscillation"));
    let theory = viscous.ok_or_else(undetermined)?;
    let formed = series.partition_point(|(t, _)| *t < FORMED_S);
    let fit = fit(&series[formed..], theory, &[]).ok_or_else(undetermined)?;
    Ok(Ringing { name: name.into(), series, fit, theory, cost })
}

impl Ringing {
    /// Relative error of the frequency, signed, per cent.
    #[must_use]
    pub fn frequency_error(&self) -> f64 {
        100.0 * (self.fit.tone.hz / self.theory.hz - 1.0)
    }

    /// Relative error of the decay, signed, per cent.
    #[must_use]
    pub fn decay_error(&self) -> f64 {
        100.0 * (self.fit.tone.decay / self.theory.decay - 1.0)
    }

    /// The viscosity that would give the fitted decay in the bulk alone, `decay / (2 k^2)`, m2/s.
    #[must_use]
    pub fn numerical_viscosity(&self) -> f64 {
        self.fit.tone.decay / (2.0 * Mode::first(GLASS).wave_number().powi(2))
    }
}
