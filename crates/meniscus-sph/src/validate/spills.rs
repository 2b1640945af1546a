//! Liquid that leaves over the rim: its volume against a count of the particles by their paths, and the books of energy.
//!
//! The count does not read what the simulator books. It follows every particle; one that is gone has spilled if it was last seen
//! outside of the glass, or above the rim on its way out within a step, and is lost if it was not: then the volumes differ.

use super::escapes::water;
use super::ring_down::GLASS;
use super::theory::Mode;
use crate::{Error, Simulator, relative_closure};
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
    /// Relative error of that volume against the particles counted by their paths, per cent.
    pub(super) volume_error: f64,
    /// Largest closure error of the energy over the largest energy of the slosh, per cent.
    pub(super) closure: f64,
}

/// Lets the first mode of water in a nearly full glass start at 0.5 m/s, and follows it for `seconds`.
///
/// # Errors
/// As for [`Simulator::step`].
pub(super) fn spills(spacing_m: f64, seconds: f64, mut watch: impl FnMut(f64)) -> Result<Spill, Error> {
    let glass = Glass { fill_m: FILL_M, ..GLASS };
    let mut simulator = Simulator::new(&water(glass, spacing_m)?)?;
    let mode = Mode::first(glass);
    simulator.set_velocity(|x| mode.velocity(x).map(|v| SPEED_M_S * v));
    let mut paths = Paths::new(&simulator);
    let mut books: Vec<EnergyBook> = Vec::new();
    while simulator.time_s() < seconds {
        simulator.step(|_| 0.0)?;
        paths.follow(&simulator);
        books.push(simulator.energy());
        watch(simulator.time_s() / seconds);
    }
    let (volume, counted) = (simulator.spilled().volume_m3, paths.spilled_m3(&simulator));
    Ok(Spill {
        volume_ml: 1e6 * volume,
        volume_error: 100.0 * (volume / counted - 1.0).abs(),
        closure: 100.0 * relative_closure(&books),
    })
}

/// Where each particle was last seen and where it goes within a step, m, and its volume at rest, m3.
struct Paths {
    last: Vec<[[f64; 3]; 2]>,
    volume: Vec<f64>,
    time_s: f64,
}

impl Paths {
    fn new(simulator: &Simulator) -> Self {
        let rest = simulator.liquid.density_kg_m3;
        let (last, volume) = simulator.motion().map(|(x, _, m)| ([x; 2], m / rest)).unzip();
        Self { last, volume, time_s: simulator.time_s() }
    }

    fn follow(&mut self, simulator: &Simulator) {
        let step_s = simulator.time_s() - self.time_s;
        self.time_s = simulator.time_s();
        for ((x, v, _), number) in simulator.motion().zip(&simulator.number) {
            self.last[*number as usize] = [x, std::array::from_fn(|k| x[k] + step_s * v[k])];
        }
    }

    /// Volume of the particles that are gone and went over the rim, m3.
    fn spilled_m3(&self, simulator: &Simulator) -> f64 {
        let mut there = vec![false; self.last.len()];
        simulator.number.iter().for_each(|number| there[*number as usize] = true);
        let outside = |x: &[f64; 3]| x[0].hypot(x[1]) > GLASS.radius_at(x[2]);
        let went = |[last, next]: &[[f64; 3]; 2]| outside(last) || (last[2] > GLASS.rim_m && outside(next));
        let all = self.last.iter().zip(&self.volume).zip(there);
        let spilled = all.filter(|((path, _), there)| !there && went(path));
        spilled.map(|((_, volume), _)| volume).sum()
    }
}
