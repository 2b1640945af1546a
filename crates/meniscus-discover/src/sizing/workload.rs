//! Work of simulations: an estimate before they start, corrected by those that are done.
//!
//! ```text
//! work = particles x steps x (1.5 s to settle + length)      particle steps
//! ```

use crate::insert::simulator::GlassSimulator;
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_sph::Setup;
use std::f64::consts::PI;

/// Time that a simulation takes to settle, s of simulated time.
const SETTLING_S: f64 = 1.5;

/// State of the simulations of a sizing, for people.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SimulationProgress {
    /// Simulations that were made or taken from the store.
    pub done: usize,
    /// Simulations that are expected in all; the search decides as it goes.
    pub expected: usize,
    /// Expected time that is left, s; none where nothing is known of it yet.
    pub left_s: Option<f64>,
}

/// Expected and finished work.
#[derive(Clone, Copy, Debug, Default)]
pub struct Workload {
    expected: f64,
    finished: f64,
    simulations: usize,
    done: usize,
    /// Time of the batches that have ended, s, and of the one under way.
    seconds: f64,
    batch_s: f64,
}

/// Returns the particle steps of `frames` frames in `glasses` settled glasses of `setup`.
fn work(setup: &Setup, frames: usize, glasses: usize) -> f64 {
    let glass = setup.glass;
    let particles = PI * glass.radius_m.powi(2) * glass.fill_m / setup.spacing_m.powi(3);
    // A set-up that is out of range costs nothing: it is refused.
    let Ok(step_s) = setup.longest_step_s() else { return 0.0 };
    particles * (frames as f64 * FRAME_INTERVAL_S + glasses as f64 * SETTLING_S) / step_s
}

impl Workload {
    /// Adds `glasses` settled glasses of `setup` with `frames` frames and `simulations` motions in all to what is expected.
    pub fn expect(&mut self, setup: &Setup, frames: usize, simulations: usize, glasses: usize) {
        self.expected += work(setup, frames, glasses);
        self.simulations += simulations;
    }

    /// Moves a finished job of one settled glass over; `batch_s` is the time since its batch began.
    pub(super) fn finish(&mut self, setup: &Setup, frames: usize, simulations: usize, batch_s: f64) {
        self.finished += work(setup, frames, 1);
        self.done += simulations;
        self.batch_s = batch_s;
    }

    /// Ends a batch that took `seconds`.
    pub(super) fn end_batch(&mut self, seconds: f64) {
        self.seconds += seconds;
        self.batch_s = 0.0;
    }

    /// Returns the expected time of all simulations by `simulator`, s, on `workers` processors, before any is done; none where
    /// it does not know its work.
    #[must_use]
    pub fn estimate_s(&self, simulator: &dyn GlassSimulator, workers: usize) -> Option<f64> {
        simulator.particle_step_s().map(|step_s| self.expected * step_s / workers.max(1) as f64)
    }

    /// Returns the number of simulations that are expected.
    #[must_use]
    pub fn simulations(&self) -> usize {
        self.simulations
    }

    /// Returns the state for people.
    #[must_use]
    pub fn progress(&self) -> SimulationProgress {
        let spent_s = self.seconds + self.batch_s;
        let left = (self.expected - self.finished).max(0.0);
        let left_s = (self.finished > 0.0).then(|| left * spent_s / self.finished);
        SimulationProgress { done: self.done, expected: self.simulations.max(self.done), left_s }
    }
}
