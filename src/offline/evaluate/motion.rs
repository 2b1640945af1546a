//! What it is worth to know how the glass moves, and from where.
//!
//! The same recording, seen by the same camera, is estimated four times: with the motion off the edges of the
//! glass, from an IMU, from the robot's command, and without any.

use crate::model::Model;
use crate::offline::baseline::linear_with_motion;
use crate::offline::camera::START;
use crate::offline::prelude::*;
use crate::offline::recording::Recording;
use crate::offline::score::{Score, score};
use crate::offline::train::correct::Sightings;
use crate::offline::train::normal;
use crate::offline::watching::turns_with;
use crate::runtime::Drive;
use crate::units::FRAME_INTERVAL_S;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Noise of the IMU, m/s2 rms at 60 Hz: 0.03 m/s2 is 120 ug/sqrt(Hz) over 60 Hz, a common MEMS part on a hand
/// that trembles, and its offset, which turns into a steady slope.
const IMU: (f64, f64) = (0.03, 0.02);

/// Where the motion comes from, and what the estimate is then worth.
#[derive(Clone, Debug)]
pub struct Source {
    /// `tracked`, `imu`, `command` or `none`.
    pub name: &'static str,
    /// Errors of surface and field.
    pub score: Score,
}

/// The four sources on one recording.
#[must_use]
pub fn sources(model: &Model<'_>, recording: &Recording, seen: &Sightings, seed: u64) -> Vec<Source> {
    let (before, now) = (delayed(&recording.glass_x_m), &recording.acceleration_m_s2);
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut noisy =
        |of: &[f64]| -> Vec<f64> { of.iter().map(|a| a + IMU.1 + IMU.0 * normal(&mut rng)).collect() };
    let imu = (noisy(&before), noisy(now));
    let linear = linear_with_motion(recording);
    let one = |name, drive: &dyn Fn(usize) -> Drive| {
        let turns = turns_with(model, seen, drive, |_, _, _| {});
        Source { name, score: score(model, recording, &linear, &turns, START) }
    };
    vec![
        one("tracked", &|_| Drive::Seen),
        one("imu", &|n| Drive::Known { before: imu.0[n], now: imu.1[n] }),
        one("command", &|n| Drive::Known { before: before[n], now: now[n] }),
        one("none", &|_| Drive::Unknown),
    ]
}

/// a_n = (X_n - 2 X_(n-1) + X_(n-2)) / dt^2: the acceleration one frame interval before each frame, m/s2.
pub(super) fn delayed(glass_x_m: &[f64]) -> Vec<f64> {
    let at = |n: usize, back: usize| glass_x_m[n.saturating_sub(back)];
    let second = |n| (at(n, 0) - 2.0 * at(n, 1) + at(n, 2)) / (FRAME_INTERVAL_S * FRAME_INTERVAL_S);
    (0..glass_x_m.len()).map(second).collect()
}
