//! Liquid that leaves over the rim: its volume and energy against what is left.

use super::ring_down::GLASS;
use super::theory::Mode;
use crate::{Error, Setup, Simulator, relative_closure};
use meniscus_data::effects::Effects;
use meniscus_data::liquids::Liquid;
use meniscus_data::recording::{EnergyBook, Glass};

/// Speed of the first mode at the top of the wall, m/s: a wave of twice the height of the rim above the fill.
const SPEED_M_S: f64 = 0.5;

/// Height of the liquid, m.
const FILL_M: f64 = 0.1;

/// Figures of a spill.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spill {
    /// Volume that left, ml.
    pub(super) volume_ml: f64,
    /// Relative error of that volume against the mass that is left in the glass, per cent.
    pub(super) volume_error: f64,
    /// Largest closure error of the energy over the largest energy of the slosh, per cent.
    pub(super) closure: f64,
}

/// Lets the first mode of water in a nearly full glass start at 0.5 m/s, and follows it for `seconds`.
///
/// # Errors
/// As for [`Simulator::step`].
pub(super) fn spills(spacing_m: f64, seconds: f64, mut watch: impl FnMut(f64)) -> Result<Spill, Error> {
    let liquid = Liquid::load("water").map_err(|error| Error::Setup(format!("{error}")))?;
    let density = liquid.density_kg_m3;
    let glass = Glass { fill_m: FILL_M, ..GLASS };
    let mut simulator = Simulator::new(&Setup {
        glass,
        liquid,
        spacing_m,
        seed: 0,
        no_slip: true,
        effects: Effects::default(),
        step_s: None,
    })?;
    let mode = Mode::first(glass);
    simulator.set_velocity(|x| mode.velocity(x).map(|v| SPEED_M_S * v));
    let left = |simulator: &Simulator| simulator.motion().map(|(_, _, m)| m).sum::<f64>() / density;
    let all = left(&simulator);
    let mut books: Vec<EnergyBook> = Vec::new();
    while simulator.time_s() < seconds {
        simulator.step(|_| 0.0)?;
        books.push(simulator.energy());
        watch(simulator.time_s() / seconds);
    }
    let (volume, counted) = (simulator.spilled().volume_m3, all - left(&simulator));
    Ok(Spill {
        volume_ml: 1e6 * volume,
        volume_error: 100.0 * (volume / counted - 1.0).abs(),
        closure: 100.0 * relative_closure(&books),
    })
}
