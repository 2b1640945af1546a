//! Liquids that are thick, whose friction is done in stages: cost, and what the long step costs in accuracy.

use super::cost::Stopwatch;
use super::ring_down::{GLASS, setup};
use super::theory::Mode;
use crate::{Error, Setup, Simulator};
use meniscus_data::liquids::{Liquid, Rheology};

/// Speed of the first mode at the top of the wall, m/s.
const SPEED_M_S: f64 = 0.2;

/// Part of the longest step that a short step is.
const SHORT: f64 = 0.125;

/// A liquid with the yield stress of a thin ketchup.
const PLASTIC: Rheology = Rheology { consistency: 0.2, index: 1.0, yield_stress: 3.0, largest: 20.0 };

/// Figures of high-viscosity liquids.
#[derive(Clone, Copy, Debug)]
pub(super) struct Thick {
    /// Processor time for a simulated second of a liquid with a yield stress of 3 Pa, s.
    pub(super) plastic_cost: f64,
    /// The same of mayonnaise, s.
    pub(super) mayonnaise_cost: f64,
    /// Largest difference of speed between the longest step and an eighth of it, per cent of the first speed.
    pub(super) step_error: f64,
}

/// One mode that dies in a high-viscosity liquid: times (s), root mean square speeds as parts of the first, and processor time a second.
struct Dying {
    speeds: Vec<(f64, f64)>,
    cost: f64,
}

/// Simulates both liquids for `seconds`, the first with short steps, too.
pub(super) fn thick(spacing_m: f64, seconds: f64, mut watch: impl FnMut(f64)) -> Result<Thick, Error> {
    let plastic = setup(PLASTIC, spacing_m, true);
    let step_s = Some(SHORT * plastic.longest_step_s()?);
    let long = dying(&plastic, seconds)?;
    watch(0.2);
    let short = dying(&Setup { step_s, ..plastic.clone() }, seconds)?;
    watch(0.8);
    let mayonnaise = Liquid::load("mayonnaise").map_err(|error| Error::Setup(format!("{error}")))?;
    let mayonnaise = dying(&Setup { liquid: mayonnaise, ..plastic }, seconds)?;
    watch(1.0);
    let apart = long.speeds.iter().map(|(time, speed)| {
        let near = short.speeds.partition_point(|(at, _)| at < time).min(short.speeds.len() - 1);
        (speed - short.speeds[near].1).abs()
    });
    Ok(Thick {
        plastic_cost: long.cost,
        mayonnaise_cost: mayonnaise.cost,
        step_error: 100.0 * apart.fold(0.0, f64::max),
    })
}

/// Lets the first mode of `setup` die for `seconds`.
fn dying(setup: &Setup, seconds: f64) -> Result<Dying, Error> {
    let mode = Mode::first(GLASS);
    let mut simulator = Simulator::new(setup)?;
    simulator.set_velocity(|x| mode.velocity(x).map(|v| SPEED_M_S * v));
    let first = simulator.energy().kinetic;
    let mut speeds = Vec::new();
    let stopwatch = Stopwatch::start();
    while simulator.time_s() < seconds {
        simulator.step(|_| 0.0)?;
        speeds.push((simulator.time_s(), (simulator.energy().kinetic / first).sqrt()));
    }
    Ok(Dying { speeds, cost: stopwatch.seconds() / simulator.time_s() })
}
