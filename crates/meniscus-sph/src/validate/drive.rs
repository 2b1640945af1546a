//! Cases in which the glass moves or the start is violent: second mode, energy, escapes, rest, bits.

use super::fit::{Fit, fit};
use super::ring::{GLASS, momentum, setup};
use super::theory::{Mode, Tone};
use crate::{Error, Setup, Simulator, relative_closure};
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_data::effects::Effects;
use meniscus_data::liquids::{Liquid, Rheology};
use meniscus_data::recording::EnergyBook;
use std::f64::consts::PI;

/// Length (s) and acceleration (m/s2) of the push that starts the second mode: half a sine, short
/// against both periods.
const PUSH: (f64, f64) = (0.05, 1.5);

/// Where its fit begins, s: sound has died away.
const AFTER_S: f64 = 0.08;

/// The second mode, started by a push of the glass in a liquid without viscosity: its momentum over
/// time and the fit beside the first mode, which is fitted before.
pub(super) fn second_mode(
    spacing_m: f64,
    seconds: f64,
    mut watch: impl FnMut(f64),
) -> Result<Option<Fit>, Error> {
    let modes = [Mode::first(GLASS), Mode::second(GLASS)];
    let mut simulator = Simulator::new(&setup(Rheology::newtonian(0.0), spacing_m, true))?;
    let push = |t: f64| if t < PUSH.0 { PUSH.1 * (PI * t / PUSH.0).sin() } else { 0.0 };
    let mut series = [Vec::new(), Vec::new()];
    while simulator.time_s() < seconds {
        simulator.step(push)?;
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

/// What the books fail to close by over `seconds` of slosh in glycerine under `strokes:7`, per cent
/// of the largest slosh energy; books at 60 Hz.
pub(super) fn energy_closure(setup: &Setup, seconds: f64, mut watch: impl FnMut(f64)) -> Result<f64, Error> {
    let motion = meniscus_data::motion::Motion::parse("strokes:7", seconds)
        .map_err(|error| Error::Setup(format!("{error}")))?;
    let mut simulator = Simulator::new(setup)?;
    let steps = simulator.divide(FRAME_INTERVAL_S);
    let mut books: Vec<EnergyBook> = Vec::new();
    while simulator.time_s() < seconds {
        for _ in 0..steps {
            simulator.step(|t| motion.acceleration(t))?;
        }
        books.push(simulator.energy());
        watch(simulator.time_s() / seconds);
    }
    Ok(100.0 * relative_closure(&books))
}

/// Particles that leave the glass when the first mode of water starts at `speed_m_s`.
pub(super) fn escapes(
    spacing_m: f64,
    speed_m_s: f64,
    seconds: f64,
    mut watch: impl FnMut(f64),
) -> Result<usize, Error> {
    let liquid = Liquid::load("water").map_err(|error| Error::Setup(format!("{error}")))?;
    let mut simulator = Simulator::new(&Setup {
        glass: GLASS,
        liquid,
        spacing_m,
        seed: 0,
        no_slip: true,
        effects: Effects::default(),
        step_s: None,
    })?;
    let mode = Mode::first(GLASS);
    simulator.set_velocity(|x| mode.velocity(x).map(|v| speed_m_s * v));
    while simulator.time_s() < seconds {
        match simulator.step(|_| 0.0) {
            Err(Error::Escaped { count, .. }) => return Ok(count),
            other => other?,
        }
        watch(simulator.time_s() / seconds);
    }
    match simulator.check_inside() {
        Err(Error::Escaped { count, .. }) => Ok(count),
        other => other.map(|()| 0),
    }
}

/// Largest root mean square of the particles' speeds in `seconds` of rest without viscosity, mm/s.
pub(super) fn rest_noise(spacing_m: f64, seconds: f64, mut watch: impl FnMut(f64)) -> Result<f64, Error> {
    let mut simulator = Simulator::new(&setup(Rheology::newtonian(0.0), spacing_m, true))?;
    let mut largest = 0.0_f64;
    while simulator.time_s() < seconds {
        simulator.step(|_| 0.0)?;
        let (mass, energy) = simulator.motion().fold((0.0, 0.0), |(mass, energy), (_, v, m)| {
            (mass + m, energy + m * v.iter().map(|v| v * v).sum::<f64>())
        });
        largest = largest.max((energy / mass).sqrt());
        watch(simulator.time_s() / seconds);
    }
    Ok(1e3 * largest)
}

/// Whether one thread and two give the same bits of every position and velocity after a shaken 0.1 s.
pub(super) fn same_bits(spacing_m: f64) -> Result<bool, Error> {
    let bits = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .map_err(|error| Error::Setup(format!("threads cannot be started: {error}")))?;
        pool.install(|| {
            let mut simulator = Simulator::new(&setup(Rheology::newtonian(0.95), spacing_m, true))?;
            while simulator.time_s() < 0.1 {
                simulator.step(|t| 3.0 * (20.0 * t).sin())?;
            }
            let bits: Vec<_> =
                simulator.motion().map(|(x, v, _)| (x.map(f64::to_bits), v.map(f64::to_bits))).collect();
            Ok::<_, Error>(bits)
        })
    };
    Ok(bits(1)? == bits(2)?)
}
