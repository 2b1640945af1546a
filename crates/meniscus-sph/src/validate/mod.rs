//! The simulator held against theory, case by case: what `meniscus simulate validate` runs.
//!
//! The references are linear: the inviscid dispersion relation, and a Ritz solution of the viscous
//! eigenvalue problem (zero stress at the surface; contact line pinned where walls do not slip, free
//! where they do). For the glass of the recordings (R = 35 mm, h = 70 mm):
//!
//! | | frequency, Hz | decay, 1/s | an independent solver |
//! |---|---|---|---|
//! | no viscosity | 3.613 | 0 | 3.613, 0 |
//! | glycerine, no slip | 3.401 | 6.69 | 3.399, 6.74; boundary layer and bulk 6.59 |
//! | glycerine, free slip | 3.484 | 2.94 | 3.484, 2.96 |
//!
//! What the rows mean: errors are absolute values in per cent, and the page gives their signs;
//! `thin_liquid_decay_error` is a liquid of 1 mPa s that sticks to the walls, whose Stokes layers are a tenth of the spacing;
//! `rest_noise` is the largest root mean square speed in half a second of rest; `energy_closure` is
//! glycerine under `strokes:7` for 2 s; `cpu_s_per_s` is the first case after settling, with all
//! threads, so that a loaded machine adds to it; `escapes` are the particles that go through the wall when the first mode of water starts at
//! 0.3 m/s; `energy_closure_breaking` is water under `strokes:7` for 2.5 s, whose waves break and spill; `spill_volume_error` and
//! `energy_closure_spills` are water in a glass filled to a centimetre below its rim, from 0.5 m/s;
//! `cpu_s_per_s_yield_stress` is a liquid of 3 Pa and 0.2 Pa s, whose speed at the longest step and at an eighth of it differs by
//! `thick_step_error` of the first; `two_core_speedup` is the time of the first case on one thread over its time on two threads,
//! `two_core_bound` twice the time on one thread over that of two such runs side by side, the most that a second thread can gain;
//! `small_tilt_error` is the slope at rest of a glass inclined by 0.02,
//! `wall_tilt_error` that of the contact line at 0.1, `wall_amplitude_error` the height of the first mode there;
//! `mode2_frequency_error` follows a stroke of the glass at the standard spacing, which has eight particles to that wave,
//! `mode2_frequency_error_fine` at the fine one; `mode1_error_cone` and `mode1_error_wine_glass` are against Ritz's method in such a
//! glass, `volume_error_shaped` and `centre_error_shaped` the volume and the height of the centre of mass (as a part of the fill) of
//! the settled liquid there; `herschel_bulkley_arrest` is when the speed of a
//! liquid with a yield stress stays below 3 % of its first, at 7 mm, `herschel_bulkley_arrest_error` its deviation from theory
//! (`by_law`); `herschel_bulkley_envelope` is the largest deviation of the decay from the same theory, from two speeds at 5 mm;
//! `effect_NAME` the largest deviation of an effect from its theory at 5 mm (see `effects`), with the figures on the page. The fine
//! spacing is 3.5 mm.

mod arrest;
mod at_the_wall;
mod basis;
mod by_law;
mod convergence;
mod cost;
mod determinism;
mod effects;
mod energy_closure;
mod escapes;
mod first_mode;
mod fit;
mod glasses;
mod held;
mod jet;
mod plots;
mod report;
mod rest_noise;
mod ring_down;
mod second_mode;
mod speedup;
mod spills;
mod theory;
mod thick;
mod viscous;
mod wall_force;

pub use convergence::{Converging, convergence, convergence_report};
pub use cost::Stopwatch;
pub use effects::effect;
pub use first_mode::FirstMode;
pub use fit::{Fit, fit};
pub use held::Held;
pub use plots::decay_png;
pub use report::report;
pub use ring_down::Ringing;
pub use theory::{Mode, Tone};
pub use viscous::{Linear, linear_mode, viscous_mode};

use crate::Error;
use meniscus::reduced::effects::LIBRARY;
use meniscus_data::liquids::Rheology;
use meniscus_report::checks::Check;
use ring_down::{GLASS, GLYCERINE, ring, setup};

/// Spacing of the recordings, m.
const STANDARD_M: f64 = 0.005;

/// Spacing of the fine runs, m.
const FINE_M: f64 = 0.0035;

/// Spacing where only a yes or no is asked, m.
const COARSE_M: f64 = 0.007;

/// Largest deviation of an effect from its theory, per cent.
const EFFECT_TARGET: f64 = 8.0;

/// Largest deviation of the time at which a liquid with a yield stress stands, at 7 mm, per cent.
const ARREST_TARGET: f64 = 20.0;

/// Results of the validation.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// The table.
    pub checks: Vec<Check>,
    /// The decays behind it.
    pub ringings: Vec<Ringing>,
    /// The figures behind the rows of effects, by name.
    pub held: Vec<(&'static str, Held)>,
}

/// Steps of the bar for the cases of `quick` or of the whole table: about seconds of processor time.
#[must_use]
pub fn work(quick: bool) -> f64 {
    WORK.iter().take(if quick { QUICK } else { WORK.len() }).sum()
}

/// Processor time of each case in order, roughly, s.
const WORK: [f64; 35] = [
    10.0, 9.0, 9.0, 15.0, 60.0, 10.0, 8.0, 10.0, 40.0, 12.0, 60.0, 12.0, 10.0, 5.0, 7.0, 60.0, 12.0, 15.0,
    5.0, 12.0, 28.0, 30.0, 10.0, 30.0, 30.0, 10.0, 15.0, 15.0, 15.0, 30.0, 12.0, 12.0, 6.0, 15.0, 15.0,
];

/// Number of quick cases.
const QUICK: usize = 4;

/// Tells how much of the work is done, case by case.
struct Progress<W> {
    watch: W,
    done: f64,
    case: usize,
}

impl<W: FnMut(f64, &str)> Progress<W> {
    /// Runs one case that tells the part of it that is done.
    fn case<T>(
        &mut self,
        name: &str,
        run: impl FnOnce(&mut dyn FnMut(f64)) -> Result<T, Error>,
    ) -> Result<T, Error> {
        let share = WORK[self.case];
        let Self { watch, done, .. } = self;
        watch(*done, name);
        // The first half of a case settles the liquid and says nothing.
        let result = run(&mut |part| watch(*done + share * (0.5 + 0.5 * part.min(1.0)), name))?;
        self.done += share;
        self.case += 1;
        Ok(result)
    }
}

/// Runs the table, the quick part of it or the whole; `watch` gets the work done, of [`work`], and
/// the name of the case.
///
/// # Errors
/// When a case cannot be simulated to its end: a particle escapes, or a number is not finite.
pub fn validate(quick: bool, watch: impl FnMut(f64, &str)) -> Result<Outcome, Error> {
    let mut progress = Progress { watch, done: 0.0, case: 0 };
    let mut out = Outcome::default();
    quick_rows(&mut progress, &mut out)?;
    if !quick {
        slow_rows(&mut progress, &mut out)?;
    }
    Ok(out)
}

/// First mode, glycerine, energy and cost.
fn quick_rows<W: FnMut(f64, &str)>(progress: &mut Progress<W>, out: &mut Outcome) -> Result<(), Error> {
    let mu = GLYCERINE.1;
    let free =
        progress.case("no viscosity", |w| ring("no viscosity, 5 mm", 0.0, STANDARD_M, true, 1.0, w))?;
    let stuck = progress.case("glycerine", |w| ring("glycerine, no slip", mu, STANDARD_M, true, 0.8, w))?;
    let slips = progress
        .case("glycerine, free slip", |w| ring("glycerine, free slip", mu, STANDARD_M, false, 0.8, w))?;
    let stirred = setup(Rheology::newtonian(mu), STANDARD_M, true);
    let closure = progress.case("energy", |w| energy_closure::energy_closure(&stirred, 2.0, w))?;
    out.checks.extend([
        Check::at_most("mode1_frequency_error", free.frequency_error().abs(), "%", 1.0),
        Check::at_most("glycerine_noslip_frequency_error", stuck.frequency_error().abs(), "%", 2.0),
        Check::at_most("glycerine_noslip_decay_error", stuck.decay_error().abs(), "%", 4.0),
        Check::at_most("glycerine_freeslip_frequency_error", slips.frequency_error().abs(), "%", 2.0),
        Check::at_most("glycerine_freeslip_decay_error", slips.decay_error().abs(), "%", 4.0),
        Check::at_most("numerical_viscosity", free.numerical_viscosity(), "m2/s", 5e-5),
        Check::at_most("energy_closure", closure, "%", 1.0),
        Check::at_most("cpu_s_per_s", free.cost, "s/s", 2.0),
    ]);
    out.ringings.extend([free, stuck, slips]);
    Ok(())
}

/// Runs the cases that take longer.
fn slow_rows<W: FnMut(f64, &str)>(progress: &mut Progress<W>, out: &mut Outcome) -> Result<(), Error> {
    let fine = progress.case("fine", |w| ring("no viscosity, 3.5 mm", 0.0, FINE_M, true, 0.8, w))?;
    let thin = progress.case("thin", |w| ring("1 mPa s, no slip", 1e-3, STANDARD_M, true, 1.0, w))?;
    let noise = progress.case("rest", |w| rest_noise::rest_noise(STANDARD_M, 0.5, w))?;
    let escaped = progress.case("escapes", |w| escapes::escapes(STANDARD_M, 0.3, 1.0, w))?;
    let breaking = escapes::water(GLASS, STANDARD_M)?;
    let breaking = progress.case("breaking waves", |w| energy_closure::energy_closure(&breaking, 2.5, w))?;
    let spill = progress.case("spills", |w| spills::spills(STANDARD_M, 0.8, w))?;
    let thick = progress.case("thick liquids", |w| thick::thick(STANDARD_M, 0.3, w))?;
    let tilt = progress.case("small tilt", |_| at_the_wall::small_tilt(STANDARD_M))?;
    let leaning = progress.case("contact line at rest", |_| at_the_wall::wall_tilt(STANDARD_M))?;
    let wave =
        progress.case("contact line of a wave", |w| at_the_wall::wall_amplitude(STANDARD_M, 0.4, w))?;
    let second = progress.case("second mode", |w| second_mode::second_mode(STANDARD_M, 1.0, w))?;
    let second_fine = progress.case("second mode, fine", |w| second_mode::second_mode(FINE_M, 1.0, w))?;
    let cone = progress.case("cone", |w| glasses::shaped(glasses::CONE, STANDARD_M, 0, 1.0, w))?;
    let wine =
        progress.case("wine glass", |w| glasses::shaped(glasses::wine_glass()?, STANDARD_M, 0, 1.0, w))?;
    let same = progress.case("threads", |_| determinism::same_bits(COARSE_M))?;
    let speedup = progress.case("second thread", |w| speedup::speedup(STANDARD_M, 0.3, w))?;
    let stopped = progress.case("yield stress", |w| arrest::arrest(COARSE_M, 1.0, w))?;
    let hz = Mode::second(GLASS).hz();
    let off = |second: Option<Fit>| second.map_or(f64::NAN, |fit| 100.0 * (fit.tone.hz / hz - 1.0).abs());
    out.checks.extend([
        Check::at_most("numerical_viscosity_fine", fine.numerical_viscosity(), "m2/s", 2e-5),
        Check::at_most("thin_liquid_decay_error", thin.decay_error().abs(), "%", 15.0),
        Check::at_most("rest_noise", noise, "mm/s", 2.0),
        Check::exactly("escapes", escaped as f64, "1", 0.0),
        Check::informational("spilled", spill.volume_ml, "ml"),
        Check::at_most("spill_volume_error", spill.volume_error, "%", 2.0),
        Check::at_most("energy_closure_breaking", breaking, "%", 1.0),
        Check::at_most("energy_closure_spills", spill.closure, "%", 1.0),
        Check::at_most("cpu_s_per_s_yield_stress", thick.plastic_cost, "s/s", 4.0),
        Check::at_most("cpu_s_per_s_mayonnaise", thick.mayonnaise_cost, "s/s", 8.0),
        Check::at_most("thick_step_error", thick.step_error, "%", 3.0),
        Check::at_most("small_tilt_error", tilt.error().abs(), "%", 2.0),
        Check::at_most("wall_tilt_error", leaning.error().abs(), "%", 2.0),
        Check::at_most("wall_amplitude_error", wave.error().abs(), "%", 2.0),
        Check::at_most("mode2_frequency_error", off(second), "%", 1.5),
        Check::at_most("mode2_frequency_error_fine", off(second_fine), "%", 0.7),
        Check::at_most("mode1_error_cone", cone.frequency_error.abs(), "%", 2.0),
        Check::at_most("mode1_error_wine_glass", wine.frequency_error.abs(), "%", 2.0),
        Check::at_most("volume_error_shaped", cone.volume_error.max(wine.volume_error), "%", 0.1),
        Check::at_most("centre_error_shaped", cone.centre_error.max(wine.centre_error), "%", 0.1),
        Check::exactly("serial_parallel_identical", f64::from(u8::from(same)), "1", 1.0),
        Check::at_least("two_core_speedup", speedup.threads, "1", 1.8),
        Check::informational("two_core_bound", speedup.bound, "1"),
        Check::at_most("herschel_bulkley_arrest", stopped.plastic_s, "s", 0.7),
        Check::at_most("herschel_bulkley_arrest_error", stopped.error().abs(), "%", ARREST_TARGET),
        Check::informational("newtonian_speed_after_arrest", stopped.newtonian, "1"),
    ]);
    out.ringings.extend([fine, thin]);
    let held = progress.case("Herschel-Bulkley", |_| effects::herschel_bulkley(STANDARD_M))?;
    out.checks.push(row("herschel_bulkley_envelope", &held));
    for effect in &LIBRARY {
        let Some(law) = effect.simulator.law() else { continue };
        let held = progress.case(effect.name, |_| effects::effect(law, STANDARD_M))?;
        out.checks.push(row(&format!("effect_{}", effect.name), &held));
        out.held.extend(held.into_iter().map(|held| (effect.name, held)));
    }
    Ok(())
}

/// The largest deviation of an effect from its theory.
fn row(name: &str, held: &[Held]) -> Check {
    // Not a number stays one, so that what could not be compared is not passed over.
    let worse = |a: f64, b: f64| if a >= b || a.is_nan() { a } else { b };
    let largest = held.iter().map(|held| held.error().abs()).fold(0.0, worse);
    Check::at_most(name, largest, "%", EFFECT_TARGET)
}
