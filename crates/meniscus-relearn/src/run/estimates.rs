//! Time and room that the stages are expected to take, from single runs on two cores of a virtual x86-64 machine: 3600 frames were
//! trained on in 273 s by the full schedule, and a second of water took 5 to 7 s of processor time. The sum was not held against a
//! whole run.

use crate::plan::Plan;
use crate::simulate::Workers;
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_data::recording::{Recording, STATE};
use meniscus_learn::Schedule;

/// Shortest step of a simulation that ends within a day, s.
pub(super) const SHORTEST_STEP_S: f64 = 1e-6;

/// Processor time of a low-viscosity liquid at a spacing of 5 mm in the usual glass: to settle, s, and for each second.
const PROCESSOR_S: [f64; 2] = [5.0, 6.5];

/// Radius and fill of the usual glass, m.
const USUAL_GLASS_M: [f64; 2] = [0.035, 0.070];

/// Processor time of a training by the full schedule on 3600 frames, s.
const TRAINING_S: f64 = 500.0;

/// Says what `missing` of `planned` simulations take.
pub(super) fn simulations(plan: &Plan, missing: usize, planned: usize, workers: Workers) -> String {
    let machine = std::thread::available_parallelism().map_or(1, usize::from);
    let processors = if workers.processors == 0 { machine } else { workers.processors };
    let here = missing.div_ceil(workers.shard.jobs);
    let [radius, fill] = USUAL_GLASS_M;
    let volume = (plan.glass.radius_m / radius).powi(2) * plan.glass.fill_m / fill;
    // The particles go with the cube of the spacing, the steps with its inverse.
    let each_s = (PROCESSOR_S[0] + PROCESSOR_S[1] * plan.seconds) * volume * (0.005 / plan.spacing_m).powi(4);
    let rounds = here.div_ceil(processors.min(here).max(1));
    let wall_s = each_s * rounds as f64;
    let megabytes = 4e-6 * (STATE as f64) * (plan.seconds / FRAME_INTERVAL_S) * here as f64;
    format!(
        "{here} of {planned} recordings of {} s, about {} on {processors} processors (a high-viscosity or yielding liquid takes \
         up to 20 times as long), {megabytes:.0} MB",
        plan.seconds,
        duration(wall_s)
    )
}

/// Says what a training by `schedule` takes.
pub(super) fn training(schedule: &Schedule, training: &[Recording]) -> String {
    let full = Schedule::FULL;
    let frames: usize = training.iter().map(Recording::frames).sum();
    let share = |part: usize, whole: usize| part as f64 / whole as f64;
    // The encoder passes over all frames; the other two draw batches of a fixed size.
    let encoder = 0.5 * share(schedule.encoder, full.encoder) * share(frames, 3600);
    let others =
        0.3 * share(schedule.rollout, full.rollout) + 0.2 * share(schedule.autoencoder, full.autoencoder);
    let wall_s = TRAINING_S * (encoder + others) / 1.5;
    format!("{} recordings, about {} on two processors", training.len(), duration(wall_s))
}

/// A duration in words.
fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 90.0 => format!("{s:.0} s"),
        s if s < 5400.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}
