//! Each effect of the simulator held against its theory.
//!
//! | effect | what is measured | theory |
//! |---|---|---|
//! | viscosity | decay of the first mode | Ritz solution at that viscosity |
//! | shear_thinning, yield_stress | mean decay from two speeds | the modes under that law ([`super::by_law`]) |
//! | wall_slip | decay at b = 5 mm | Ritz solution with Navier's condition |
//! | surface_tension | w^2 with it over w^2 without | `1 + sigma k^2/(rho g)` |
//! | contact_line | speed lost in a period of dry friction | the modes under that force ([`super::wall_force`]) |
//! | pinned_line | w^2 with the spring over w^2 without | the modes, coupled by the spring |
//! | foam | exponent p of `V' ~ V^p` and decay, from two speeds | the modes under that force |
//! | viscoelastic | frequency and decay | Ritz solution with complex viscosity |
//! | container_tilt | slope of the surface at rest | `tan theta` |
//! | vertical_acceleration | w^2 with it over w^2 without | `1 + a/g` |
//! | fill | w^2 over w^2 at another fill | `tanh k h` |
//!
//! Ratios take the simulator's own run without the effect, so that its numerical errors cancel to first order.

use super::Held;
use super::at_the_wall::{inclined, slope};
use super::by_law::{Scene, ring_by_law};
use super::fit::{Fit, fit};
use super::ring_down::{GLASS, GLYCERINE, momentum, setup};
use super::theory::{Mode, Tone};
use super::viscous::{Linear, linear_mode};
use super::wall_force::{foaming, rubbed, sliding, sprung};
use crate::{Error, Setup, Simulator};
use meniscus::reduced::effects::Law;
use meniscus::units::GRAVITY_M_S2;
use meniscus_data::effects::Effects;
use meniscus_data::liquids::Rheology;

/// Where fits begin, s: the wall layer has formed.
const FORMED_S: f64 = 0.08;

/// Where the fits of a liquid with a memory begin, s: its stress starts from nothing, and what that leaves behind fades with its relaxation
/// time of 0.05 s, not so much faster than the mode. (Fitted from [`FORMED_S`] on, the added decay is 23 % too large.)
const FADED_S: f64 = 0.25;

/// Viscosity of the liquid in which stiffness is measured, Pa s: enough to still the grain of the particles.
const CALM_PA_S: f64 = 0.1;

/// A run of the first mode: momentum over time as a part of the first.
struct Run {
    series: Vec<(f64, f64)>,
}

impl Run {
    /// Lets the first mode of `setup` ring from `speed_m_s` for `seconds`.
    fn new(setup: &Setup, speed_m_s: f64, seconds: f64) -> Result<Self, Error> {
        let mode = Mode::first(setup.resolved().glass);
        let mut simulator = Simulator::new(setup)?;
        simulator.set_velocity(|x| mode.velocity(x).map(|v| speed_m_s * v));
        let first = momentum(&simulator, &mode);
        let mut series = Vec::new();
        while simulator.time_s() < seconds {
            series.push((simulator.time_s(), momentum(&simulator, &mode) / first));
            simulator.step(|_| 0.0)?;
        }
        Ok(Self { series })
    }

    /// The oscillation near `guess` between two times.
    fn between(&self, guess: Tone, from_s: f64, to_s: f64) -> Result<Fit, Error> {
        let [from, to] = [from_s, to_s].map(|time| self.series.partition_point(|(t, _)| *t < time));
        let undetermined = || Error::Setup("a ringing does not determine an oscillation".into());
        fit(&self.series[from..to], guess, &[]).ok_or_else(undetermined)
    }

    /// The oscillation near `guess` once it has formed.
    fn tone(&self, guess: Tone) -> Result<Tone, Error> {
        self.between(guess, FORMED_S, f64::INFINITY).map(|fit| fit.tone)
    }

    /// Amplitude at `time_s` as a part of the first, from the period around it.
    fn amplitude(&self, time_s: f64) -> Result<f64, Error> {
        let guess = Tone { hz: Mode::first(GLASS).hz(), decay: 2.0 };
        let half = 0.5 / guess.hz;
        let found = self.between(guess, time_s - half, time_s + half)?;
        Ok(found.amplitude[0].hypot(found.amplitude[1]) * (-found.tone.decay * time_s).exp())
    }
}

/// The calm liquid, which slips on the wall, with `effects`.
fn calm(spacing_m: f64, effects: Effects) -> Setup {
    Setup { effects, ..setup(Rheology::newtonian(CALM_PA_S), spacing_m, false) }
}

/// Squared frequency with `effects` over without, less 1, and `theory` less 1.
fn stiffening(spacing_m: f64, speed_m_s: f64, effects: Effects, theory: f64) -> Result<[f64; 2], Error> {
    let guess = Tone { hz: Mode::first(GLASS).hz(), decay: 1.0 };
    let plain = Run::new(&calm(spacing_m, Effects::default()), speed_m_s, 0.8)?.tone(guess)?;
    let guess = Tone { hz: plain.hz * theory.sqrt(), ..guess };
    let with = Run::new(&calm(spacing_m, effects), speed_m_s, 0.8)?.tone(guess)?;
    Ok([(with.hz / plain.hz).powi(2) - 1.0, theory - 1.0])
}

/// Holds `law` against theory at `spacing_m`. Every law of the list has a case here, or this does not compile.
///
/// # Errors
/// When a case cannot be simulated to its end.
pub fn effect(law: Law, spacing_m: f64) -> Result<Vec<Held>, Error> {
    let on = |texts: &[&str]| {
        let mut effects = Effects::default();
        texts
            .iter()
            .try_for_each(|text| effects.parse(text))
            .map_err(|error| Error::Setup(format!("{error}")))?;
        Ok::<_, Error>(effects)
    };
    let (density, mu) = GLYCERINE;
    let glycerine = |effects| Setup { effects, ..setup(Rheology::newtonian(mu), spacing_m, true) };
    let k = Mode::first(GLASS).wave_number();
    let one = |what, [measured, theory]: [f64; 2]| vec![Held { what, measured, theory }];
    let stiffer =
        |what, effects, theory| Ok::<_, Error>(one(what, stiffening(spacing_m, 0.1, effects, theory)?));
    match law {
        Law::Viscosity => {
            let theory = Theory { viscosity: 0.6, slip_m: 0.0, memory: None };
            linear(&glycerine(on(&["viscosity=0.6"])?), theory)
        }
        Law::WallSlip => {
            let theory = Theory { viscosity: mu, slip_m: 0.005, memory: None };
            linear(&glycerine(on(&["wall_slip=0.005"])?), theory)
        }
        Law::Viscoelastic => {
            let theory = Theory { viscosity: mu, slip_m: 0.0, memory: Some((10.0, 0.05)) };
            linear(&glycerine(on(&["viscoelastic=10,0.05"])?), theory)
        }
        Law::ShearThinning => envelopes(&glycerine(on(&["viscosity=1.2", "shear_thinning=0.5"])?)),
        Law::YieldStress => envelopes(&glycerine(on(&["viscosity=0.5", "yield_stress=0.4"])?)),
        Law::SurfaceTension => {
            let theory = 1.0 + k * k / (density * GRAVITY_M_S2);
            stiffer("w^2 ratio at 1 N/m", on(&["surface_tension=1"])?, theory)
        }
        Law::PinnedLine => stiffer("w^2 ratio at 15 N/m2", on(&["pinned_line=15"])?, sprung(15.0)),
        Law::ContactLine => {
            let line = Sliding { force_n_m: 0.02, reach_m: 1e-4 };
            friction(spacing_m, on(&["contact_line=0.02,0.0001"])?, line)
        }
        Law::Foam => foam(spacing_m, on(&["foam=0.15"])?, 0.15),
        Law::ContainerTilt => Ok(one("slope at rest", [slope(&inclined(spacing_m, 0.1)?), 0.1_f64.tan()])),
        Law::VerticalAcceleration => {
            let theory = 1.0 + 3.0 / GRAVITY_M_S2;
            stiffer("w^2 ratio at 3 m/s2", on(&["vertical_acceleration=3"])?, theory)
        }
        Law::Fill => {
            let theory = (k * 0.03).tanh() / (k * GLASS.fill_m).tanh();
            stiffer("w^2 ratio, 30 mm", on(&["fill=0.03"])?, theory)
        }
    }
}

/// Liquid of the linear theory.
#[derive(Clone, Copy, Debug)]
struct Theory {
    /// Viscosity, Pa s.
    viscosity: f64,
    /// Slip length, m.
    slip_m: f64,
    /// Modulus (Pa) and relaxation time (s) of a Maxwell stress.
    memory: Option<(f64, f64)>,
}

/// Line that slides.
#[derive(Clone, Copy, Debug)]
struct Sliding {
    /// Force per length, N/m.
    force_n_m: f64,
    /// Deflection at which it slides, m.
    reach_m: f64,
}

/// Decay and, with relaxation, frequency of a liquid that is linear.
fn linear(setup: &Setup, liquid: Theory) -> Result<Vec<Held>, Error> {
    let Theory { viscosity, slip_m, memory } = liquid;
    let liquid = |memory: Option<(f64, f64)>| Linear {
        nu: viscosity / GLYCERINE.0,
        slip_m,
        memory: memory.map(|(modulus, time)| (modulus / GLYCERINE.0, time)),
    };
    let missing = || Error::Setup("the linear theory finds no oscillation".into());
    let theory = |memory| linear_mode(&GLASS, &liquid(memory)).ok_or_else(missing);
    let with = theory(memory)?;
    let run = Run::new(setup, 0.05, 0.7)?;
    if memory.is_none() {
        let found = run.tone(with)?;
        return Ok(vec![Held { what: "decay, 1/s", measured: found.decay, theory: with.decay }]);
    }
    let plain = theory(None)?;
    let faded = |run: Run, guess| run.between(guess, FADED_S, f64::INFINITY).map(|fit| fit.tone);
    let found = faded(run, with)?;
    let bare = faded(Run::new(&Setup { effects: Effects::default(), ..setup.clone() }, 0.05, 0.7)?, plain)?;
    Ok(vec![
        Held { what: "rise of frequency, Hz", measured: found.hz - bare.hz, theory: with.hz - plain.hz },
        Held {
            what: "added decay, 1/s",
            measured: found.decay - bare.decay,
            theory: with.decay - plain.decay,
        },
    ])
}

/// A Herschel-Bulkley liquid from two speeds: k = 1 Pa s^n, n = 0.5, tau0 = 0.15 Pa.
pub(super) fn herschel_bulkley(spacing_m: f64) -> Result<Vec<Held>, Error> {
    let law = Rheology { consistency: 1.0, index: 0.5, yield_stress: 0.15, largest: 20.0 };
    envelopes(&setup(law, spacing_m, true))
}

/// Mean decays of a liquid of variable viscosity from two speeds over one period.
fn envelopes(setup: &Setup) -> Result<Vec<Held>, Error> {
    let scene =
        Scene { glass: GLASS, density_kg_m3: GLYCERINE.0, rheology: setup.resolved().liquid.rheology };
    let diverged = || Error::Setup("the theory of a law of flow is not finite".into());
    let period = 1.0 / Mode::first(GLASS).hz();
    let (seconds, guess) = (FORMED_S + 1.02 * period, Tone { hz: 0.93 / period, decay: 4.0 });
    let decay = |run: Run| run.between(guess, FORMED_S, FORMED_S + period).map(|fit| fit.tone.decay);
    let mut held = Vec::new();
    for (what, speed) in [("decay from 0.2 m/s, 1/s", 0.2), ("decay from 0.35 m/s, 1/s", 0.35)] {
        let theory = ring_by_law(&scene, speed, seconds).ok_or_else(diverged)?;
        let theory = Run { series: theory.iter().map(|now| (now.time_s, now.momentum)).collect() };
        let run = Run::new(setup, speed, seconds)?;
        held.push(Held { what, measured: decay(run)?, theory: decay(theory)? });
    }
    Ok(held)
}

/// Speed lost in a period under a sliding contact line, from the run's own decay without it.
fn friction(spacing_m: f64, effects: Effects, line: Sliding) -> Result<Vec<Held>, Error> {
    const SPEED_M_S: f64 = 0.12;
    let hz = Mode::first(GLASS).hz();
    let (start, span) = (FORMED_S + 0.5 / hz, 1.0 / hz);
    let end = start + span;
    let plain = Run::new(&calm(spacing_m, Effects::default()), SPEED_M_S, end + 0.6 / hz)?;
    let gamma = (plain.amplitude(start)? / plain.amplitude(end)?).ln() / span;
    let run = Run::new(&calm(spacing_m, effects), SPEED_M_S, end + 0.6 / hz)?;
    let line = sliding(line.force_n_m, line.reach_m);
    let theory = Run { series: rubbed(SPEED_M_S, gamma, end + 0.6 / hz, line) };
    let lost = |run: &Run| Ok::<_, Error>(SPEED_M_S * (run.amplitude(start)? - run.amplitude(end)?));
    Ok(vec![Held { what: "speed lost, m/s", measured: lost(&run)?, theory: lost(&theory)? }])
}

/// Exponent of the envelope under foam and its strength, from two speeds.
fn foam(spacing_m: f64, effects: Effects, beta: f64) -> Result<Vec<Held>, Error> {
    let hz = Mode::first(GLASS).hz();
    let (start, span) = (FORMED_S + 0.5 / hz, 1.0 / hz);
    let end = start + span;
    // Decay and the speed that it belongs to.
    let decay = |run: &Run, speed: f64| {
        let (first, last) = (run.amplitude(start)?, run.amplitude(end)?);
        Ok::<_, Error>([(first / last).ln() / span, speed * (first * last).sqrt()])
    };
    let mut found = Vec::new();
    for speed in [0.05, 0.25] {
        let ring = |effects| Run::new(&calm(spacing_m, effects), speed, end + 0.6 / hz);
        let [gamma, _] = decay(&ring(Effects::default())?, speed)?;
        let [with, at] = decay(&ring(effects)?, speed)?;
        let theory = Run { series: rubbed(speed, gamma, end + 0.6 / hz, foaming(beta)) };
        let [should, there] = decay(&theory, speed)?;
        found.push([[with - gamma, at], [should - gamma, there]]);
    }
    // V' ~ V^p: the decay falls with V^(p-1).
    let exponent = |k: usize| {
        let [[slow, low], [fast, high]] = [found[0][k], found[1][k]];
        1.0 + (fast / slow).ln() / (high / low).ln()
    };
    Ok(vec![
        Held { what: "exponent", measured: exponent(0), theory: exponent(1) },
        Held { what: "added decay at 0.25 m/s, 1/s", measured: found[1][0][0], theory: found[1][1][0] },
    ])
}
