//! Recordings by the reduced model itself.

use crate::baseline::predict::predict;
use crate::recordings::motion_plan::MotionPlan;
use crate::recordings::record::{Channel, Quantity, Record};
use crate::recordings::stated::Known;
use crate::recordings::tables::drive_of;
use meniscus::reduced::effects::Active;
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_data::motion::Motion;
use meniscus_numerics::random::normal;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Returns a recording of `plan` by the reduced model with the effects `active` and white noise of `noise_m`.
#[must_use]
pub fn synthetic_record(
    name: &str,
    known: &Known,
    plan: &MotionPlan,
    theta: &[f64],
    active: &[Active],
    noise_m: f64,
    seed: u64,
) -> Option<Record> {
    let motion = Motion::sampled(&plan.samples())?;
    let kinds = [Quantity::Level, Quantity::Slope, Quantity::Bow, Quantity::Place];
    let mut record = Record {
        name: name.into(),
        interval_s: FRAME_INTERVAL_S,
        channels: kinds.map(|quantity| Channel { quantity, value: vec![None; plan.frames()] }).to_vec(),
        drive: drive_of(&motion, plan.seconds),
        rest_frames: (plan.jolts[0].start_s / FRAME_INTERVAL_S) as usize,
    };
    let expected = predict(&record, known, theta, 0.0, active);
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    for (channel, expected) in record.channels.iter_mut().zip(expected) {
        channel.value = expected.iter().map(|z| Some(z + noise_m * normal(&mut random))).collect();
    }
    Some(record)
}
