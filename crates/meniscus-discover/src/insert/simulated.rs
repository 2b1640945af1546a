//! A recording of a discovery simulated again, with the effects that were found.
//!
//! The simulator carries effects of the liquid, fill, inclination and lift, and another radius is that of its glass. Gain and
//! delay of the commanded motion and the effects of the camera are applied around it, by the formulas of [`meniscus::reduced::effects`]. A delay is a shift in
//! time of what was simulated, so that it needs no further simulation.

pub use super::course::Course;

use super::simulator::{GlassSimulator, Particles, SimulatorFault};
use crate::recordings::record::{Quantity, Record, parts};
use crate::recordings::stated::Known;
use meniscus::blob::ObservationModel;
use meniscus::reduced as slosh;
use meniscus::reduced::effects::{Active, Port, Simulator as Carried, Slot, View};
use meniscus::reduced::{Baseline, Cylinder, ReducedModel};
use meniscus::surface::POINTS;
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_data::effects::Effects;
use meniscus_data::glass::{Glass, WallShape};
use meniscus_data::liquids::{Liquid, Rheology};
use meniscus_sph::Setup;
use std::sync::atomic::AtomicBool;

/// Resolution of a simulation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resolution {
    /// Spacing of the particles, m.
    pub spacing_m: f64,
    /// Seed of their packing.
    pub seed: u64,
}

/// Height of the rim over the fill: high enough for any slosh that a discovery can use, m.
const ROOM_M: f64 = 0.05;

/// Frames that are simulated beyond the end of a recording, for lags of its clock.
const SPARE_FRAMES: usize = 3;

/// Glass of liquid with effects, ready to be simulated, and how the camera sees it.
#[derive(Clone, Debug)]
pub struct SimulatedGlass {
    /// Set-up of the simulator.
    pub setup: Setup,
    fill_m: f64,
    port: Port,
    view: View,
    observation_model: ObservationModel,
}

impl SimulatedGlass {
    /// Returns the glass and liquid of `known` with `effects`.
    ///
    /// # Errors
    /// In words, when the simulator does not carry an effect or a value is out of its range.
    pub fn new(known: &Known, effects: &[Active], resolution: Resolution) -> Result<Self, String> {
        Self::of(&Particles, known, effects, resolution)
    }

    /// Returns the glass and liquid of `known` with `effects`, for `simulator`.
    ///
    /// # Errors
    /// In words, when the simulator does not carry an effect or a value is out of its range.
    pub fn of(
        simulator: &dyn GlassSimulator,
        known: &Known,
        effects: &[Active],
        resolution: Resolution,
    ) -> Result<Self, String> {
        let inside = simulator.carried(effects, &known.stated())?;
        let vessel =
            Cylinder { radius_m: known.radius_m, depth_m: known.fill_m, density_kg_m3: known.density_kg_m3 };
        let resists = slosh::Rheology::newtonian(known.viscosity_pa_s);
        let reduced = ReducedModel::new(vessel, resists, &Baseline::default(), effects, FRAME_INTERVAL_S);
        let mut simulated = vessel;
        for Active { entry, values } in effects {
            // A fill is an effect of the simulator; a radius is that of its glass.
            if let (Carried::Absent(_), Slot::Vessel(change)) = (entry.simulator, entry.slot) {
                change(values, &mut simulated);
            }
        }
        let glass = Glass {
            radius_m: simulated.radius_m,
            fill_m: known.fill_m,
            rim_m: known.fill_m + ROOM_M,
            wall: WallShape::UPRIGHT,
        };
        let liquid = Liquid {
            name: "as stated".into(),
            density_kg_m3: known.density_kg_m3,
            rheology: Rheology::newtonian(known.viscosity_pa_s),
            effects: Effects::default(),
        };
        let setup = Setup {
            glass,
            liquid,
            spacing_m: resolution.spacing_m,
            seed: resolution.seed,
            no_slip: true,
            effects: inside,
            step_s: None,
        };
        let (port, view) = (reduced.port, reduced.view);
        let observation_model = ObservationModel::new(simulated.radius_m, known.fill_m, &reduced);
        Ok(Self { setup, fill_m: known.fill_m, port, view, observation_model })
    }

    /// Returns the motion of `record` as the glass makes it, as times and positions.
    ///
    /// # Errors
    /// In words, when the glass moves otherwise than along x.
    pub fn course(&self, record: &Record) -> Result<Course, String> {
        if record.drive.holds() != [false; 2] || !record.drive.is_planar() {
            return Err(format!("{}: only a glass that is moved along x is simulated again", record.name));
        }
        let seconds = record.interval_s * record.frames() as f64;
        let frames = (seconds / FRAME_INTERVAL_S).ceil() as usize + SPARE_FRAMES;
        let samples = (0..=4 * (frames + 60))
            .map(|n| 0.25 * f64::from(n as u32) * FRAME_INTERVAL_S)
            .map(|t| (t, self.port.gain * record.drive.at(t).3))
            .collect();
        Ok(Course { samples, frames })
    }

    /// Returns each channel of `record`, m, from the simulated `heights` of its course. `lag_s` is the delay of its frames
    /// against their times.
    ///
    /// # Errors
    /// In words, when a surface cannot be evaluated.
    pub fn channels(&self, record: &Record, heights: &[f32], lag_s: f64) -> Result<Vec<Vec<f64>>, String> {
        let mut simulated: Vec<[f64; 4]> = Vec::with_capacity(heights.len() / POINTS);
        for profile in heights.as_chunks::<POINTS>().0 {
            let surface = self.observation_model.to_measured(profile);
            let height = |i: usize| f64::from(surface[i]) - self.fill_m;
            let [level, slope, bow, _] =
                parts((0..POINTS).map(|i| (i, height(i)))).ok_or("the surface was not found")?;
            let highest = (0..POINTS).map(height).fold(f64::NEG_INFINITY, f64::max);
            simulated.push([level, slope, bow, highest]);
        }
        let shift = lag_s + self.port.delay_s + self.view.latency_s;
        let time = |frame: usize| frame as f64 * record.interval_s - shift;
        let series = |column: usize| -> Vec<f64> {
            let frames = 0..record.frames();
            frames.map(|frame| between(&simulated, column, time(frame) / FRAME_INTERVAL_S)).collect()
        };
        let scale = self.view.scale * self.port.gain;
        let one = |quantity: Quantity| match quantity {
            Quantity::Level => series(0),
            Quantity::Slope => series(1),
            Quantity::Bow => series(2),
            Quantity::Peak => series(3),
            Quantity::Place => {
                (0..record.frames()).map(|frame| scale * record.drive.at(time(frame)).3).collect()
            }
        };
        Ok(record.channels.iter().map(|channel| one(channel.quantity)).collect())
    }
}

/// Glass of liquid with effects, and how finely it is simulated.
#[derive(Clone, Copy, Debug)]
pub struct SimulatedCase<'a> {
    /// Glass and liquid.
    pub known: &'a Known,
    /// Effects.
    pub effects: &'a [Active],
    /// Resolution.
    pub resolution: Resolution,
}

/// Returns each channel of `record` by `simulator` for `case`, m. `lag_s` as in [`super::latent::roll_out`]; `stop` ends the work.
///
/// # Errors
/// [`SimulatorFault`], when the simulator does not carry an effect, a value is out of its range, or it stops.
pub fn simulate(
    simulator: &dyn GlassSimulator,
    case: &SimulatedCase<'_>,
    record: &Record,
    lag_s: f64,
    stop: Option<&AtomicBool>,
) -> Result<Vec<Vec<f64>>, SimulatorFault> {
    let here = SimulatorFault::Here;
    let glass = SimulatedGlass::of(simulator, case.known, case.effects, case.resolution).map_err(here)?;
    let course = glass.course(record).map_err(here)?;
    let heights = simulator.run(&glass.setup, &[&course], stop).map_err(|fault| match fault {
        SimulatorFault::Here(reason) => here(format!("{}: {reason}", record.name)),
        other => other,
    })?;
    let heights = heights.first().ok_or_else(|| here("nothing was recorded".into()))?;
    glass.channels(record, heights, lag_s).map_err(here)
}

/// Returns `column` of `frames` at the fractional frame `at`: cubic through the nearest four, constant beyond the ends.
///
/// The simulated surface holds nothing above 20 Hz, and a slosh of 4 Hz is met to 0.05 % of its height.
fn between(frames: &[[f64; 4]], column: usize, at: f64) -> f64 {
    let last = frames.len().saturating_sub(1);
    let at = at.clamp(0.0, last as f64);
    let low = (at as usize).min(last.saturating_sub(1));
    let x = at - low as f64;
    let value = |n: isize| frames[(low as isize + n).clamp(0, last as isize) as usize][column];
    let [a, b, c, d] = [-1, 0, 1, 2].map(value);
    -x * (x - 1.0) * (x - 2.0) / 6.0 * a + (x + 1.0) * (x - 1.0) * (x - 2.0) / 2.0 * b
        - (x + 1.0) * x * (x - 2.0) / 2.0 * c
        + (x + 1.0) * x * (x - 1.0) / 6.0 * d
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slosh_between_frames_is_met_to_a_thousandth_of_its_height() {
        let wave = |n: f64| (std::f64::consts::TAU * 4.0 * n * FRAME_INTERVAL_S).sin();
        let frames: Vec<[f64; 4]> = (0..60).map(|n| [0.0, wave(f64::from(n)), 0.0, 0.0]).collect();
        for tenth in 20..560 {
            let at = 0.1 * f64::from(tenth);
            assert!((between(&frames, 1, at) - wave(at)).abs() < 1e-3, "{at}");
        }
        // Before the first frame the glass rests, after the last one nothing is known.
        assert_eq!(between(&frames, 1, -3.0), frames[0][1]);
        assert_eq!(between(&frames, 1, 99.0), frames[59][1]);
    }
}
