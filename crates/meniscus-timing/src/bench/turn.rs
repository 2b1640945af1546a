//! The whole turn, from the payload that completes a pair of images to the field, as the worker takes it.

use super::{Times, read_once};
use meniscus::blob::Model;
use meniscus::runtime::{Estimator, InputSource, Mode, ProfileSensor, Stages, Tracker};
use meniscus::surface::{Config, ConfigError};
use meniscus::usb::uvc::Stream;
use meniscus_data::recording::Recording;
use meniscus_hil::FaultList;
use meniscus_platform::allocations::allocations_of_this_thread;
use meniscus_platform::clock::Monotonic;
use meniscus_virtual::camera::SimulatedCamera;
use meniscus_virtual::render::SceneSettings;
use std::collections::BTreeMap;
use std::hint::black_box;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Bytes that are read between two turns to leave nothing of the last one in the caches next to the core.
const EVICTION: usize = 64 << 20;

/// Frames of a camera as payloads, first to last.
pub type Payloads = Vec<(Stream, Vec<u8>)>;

/// The first `frames` frames that a simulated camera sends of `recording`.
#[must_use]
pub fn payloads(recording: &Recording, scene: SceneSettings, frames: usize) -> Payloads {
    let mut all = Vec::new();
    SimulatedCamera::new(recording, scene, FaultList::default())
        .send_first(frames, |stream, payload| all.push((stream, payload.to_vec())));
    all
}

/// Turns that tracked: what they cost.
#[derive(Clone, Debug, Default)]
pub struct Turns {
    /// Whole turns.
    pub whole: Times,
    /// Which payload of the pass each of them was completed by.
    pub payloads: Vec<usize>,
    /// Their stages.
    pub stages: Vec<Stages>,
    /// Allocations of all of them.
    pub allocations: u64,
}

impl Turns {
    /// The median of a stage, microseconds.
    #[must_use]
    pub fn stage_us(&self, stage: fn(&Stages) -> u64) -> f64 {
        let mut all: Vec<u64> = self.stages.iter().map(stage).collect();
        all.sort_unstable();
        all.get(all.len() / 2).map_or(f64::NAN, |us| *us as f64)
    }

    /// The median over the passes of that frame whose median is largest, microseconds; NaN of no turns. What the machine does
    /// beside falls on another frame in every pass; what a frame costs by itself falls on it in all.
    #[must_use]
    pub fn slowest_frame_us(&self) -> f64 {
        let mut frames: BTreeMap<usize, Times> = BTreeMap::new();
        for (payload, ns) in self.payloads.iter().zip(&self.whole.0) {
            frames.entry(*payload).or_default().0.push(*ns);
        }
        frames.values().map(Times::median_us).fold(f64::NAN, f64::max)
    }
}

/// State of the near caches before a turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Caches {
    /// As the turn before left them.
    Warm,
    /// Emptied.
    Cold,
}

/// Extent of a measurement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Passes {
    /// Times that the payloads are played, to a new tracker each.
    pub count: usize,
    /// State of the near caches before every turn.
    pub caches: Caches,
}

/// Plays `payloads` as fast as they are taken. Ends early when `stop` is set.
///
/// # Errors
/// [`ConfigError`], when glass or camera cannot be.
pub fn turns(
    model: &Model<'_>,
    config: meniscus::surface::Settings,
    payloads: &Payloads,
    passes: Passes,
    stop: &AtomicBool,
) -> Result<Turns, ConfigError> {
    let config = Config::new(config)?;
    let (width, height) = config.image_size();
    let (mut depth, mut infrared) = (vec![0; 2 * width * height], vec![0; width * height]);
    let mut field = vec![0.0; model.field_len()];
    let evict = if passes.caches == Caches::Cold { vec![1_u8; EVICTION] } else { Vec::new() };
    let mut clock = Monotonic::start();
    let room = passes.count * payloads.len();
    let mut all = Turns {
        whole: Times(Vec::with_capacity(room)),
        payloads: Vec::with_capacity(room),
        stages: Vec::with_capacity(room),
        ..Turns::default()
    };
    for _ in 0..passes.count {
        let sensor = ProfileSensor::new(config, &mut depth, &mut infrared);
        let mut tracker = Tracker::new(Estimator::new(model), sensor);
        for (index, (stream, payload)) in payloads.iter().enumerate() {
            if stop.load(Ordering::Relaxed) {
                return Ok(all);
            }
            black_box(read_once(&evict));
            let before = allocations_of_this_thread();
            let start = Instant::now();
            let mut taken = None;
            tracker.accept(*stream, payload, InputSource::tracked, &mut clock, &mut field, |turn, _| {
                taken = Some((start.elapsed(), turn.estimate));
            });
            let allocations = allocations_of_this_thread() - before;
            if let Some((time, estimate)) = taken.filter(|(_, estimate)| estimate.mode == Mode::Tracking) {
                all.whole.0.push(u64::try_from(time.as_nanos()).unwrap_or(u64::MAX));
                all.payloads.push(index);
                all.stages.push(estimate.stages);
                all.allocations += allocations;
            }
        }
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_that_is_slow_in_every_pass_is_distinguished_from_one_that_was_held_up_once() {
        let mut turns = Turns::default();
        for pass in 0..5 {
            for payload in 0..4 {
                let held_up = if (pass, payload) == (2, 1) { 90_000 } else { 0 };
                turns.whole.0.push(if payload == 3 { 2000 } else { 1000 } + held_up);
                turns.payloads.push(payload);
            }
        }
        assert_eq!((turns.slowest_frame_us(), turns.whole.quantile_us(1.0)), (2.0, 91.0));
        assert!(Turns::default().slowest_frame_us().is_nan());
    }
}
