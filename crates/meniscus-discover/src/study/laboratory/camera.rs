//! Profiles as a camera sees them, and its faults: rotations of the points of the line on the near wall.

use super::glass::{LaboratoryGlass, RADIUS_M};
use super::solver::Solver;
use crate::recordings::motion_plan::MotionPlan;
use crate::recordings::record::{Record, channels};
use crate::recordings::tables::drive_of;
use meniscus::surface::{POINTS, SurfaceProfile, profile_abscissa};
use meniscus::units::{FRAME_INTERVAL_S, Micros};
use meniscus_data::motion::Motion;
use meniscus_numerics::random::normal;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Noise of one point of a profile, m.
const NOISE_M: f64 = 3e-4;

/// Faults of camera and motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Faults {
    /// Rotation about the line of sight, rad.
    pub roll_rad: f64,
    /// Rotation downwards, rad.
    pub pitch_rad: f64,
    /// Age of a frame, s.
    pub latency_s: f64,
    /// Motion of the glass over the stated one.
    pub gain: f64,
}

impl Faults {
    /// All is as it is said.
    pub const NONE: Self = Self { roll_rad: 0.0, pitch_rad: 0.0, latency_s: 0.0, gain: 1.0 };
}

/// Returns the recordings of `glass` on the paths `plans`, judged as of a fill of `fill_m`, with the noise of `seed`.
#[must_use]
pub fn records(
    glass: &LaboratoryGlass,
    plans: &[MotionPlan],
    faults: &Faults,
    fill_m: f64,
    seed: u64,
) -> Vec<Record> {
    let one = |(i, plan): (usize, &MotionPlan)| record(glass, plan, faults, fill_m, 100 * seed + i as u64);
    plans.iter().enumerate().filter_map(one).collect()
}

/// Returns one recording.
fn record(
    glass: &LaboratoryGlass,
    plan: &MotionPlan,
    faults: &Faults,
    fill_m: f64,
    seed: u64,
) -> Option<Record> {
    let mut performed = plan.clone();
    for jolt in &mut performed.jolts {
        jolt.strength_m_s2 *= faults.gain;
        // A frame that is old shows what was.
        jolt.start_s += faults.latency_s;
    }
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let frame = |(number, (heights, place)): (usize, ([f64; POINTS], f64))| {
        let mut noise = || NOISE_M * normal(&mut random);
        Some(SurfaceProfile {
            height_m: seen(&heights, faults, fill_m).map(|z| (z + noise()) as f32),
            variance_m2: [(NOISE_M * NOISE_M) as f32; POINTS],
            valid: [true; POINTS],
            glass_x_m: Some((place + 0.3 * noise()) as f32),
            sequence: number as u32,
            captured: Micros((number as f64 * FRAME_INTERVAL_S * 1e6) as u64),
        })
    };
    let profiles: Vec<_> = Solver::new(glass, &performed).run().into_iter().enumerate().map(frame).collect();
    Some(Record {
        name: format!("jolt of {:.2} m/s2", plan.jolts[0].strength_m_s2),
        interval_s: FRAME_INTERVAL_S,
        channels: channels(&profiles, fill_m),
        drive: drive_of(&Motion::sampled(&plan.samples())?, plan.seconds),
        rest_frames: (plan.jolts[0].start_s / FRAME_INTERVAL_S) as usize,
    })
}

/// Returns `heights` (m over the bottom) as a camera with the `faults` sees them, turned about the middle of the near wall at
/// the height `fill_m`.
fn seen(heights: &[f64; POINTS], faults: &Faults, fill_m: f64) -> [f64; POINTS] {
    let ((sin, cos), (down, level)) = (faults.roll_rad.sin_cos(), faults.pitch_rad.sin_cos());
    let turned: Vec<[f64; 2]> = (0..POINTS)
        .map(|i| {
            let s = profile_abscissa(i);
            let (x, z) = (RADIUS_M * s, heights[i] - fill_m);
            // The wall recedes towards its sides.
            let behind = RADIUS_M * (1.0 - (1.0 - s * s).sqrt());
            let (x, z) = (x * cos - z * sin, z * cos + x * sin);
            [x, z * level + behind * down]
        })
        .collect();
    // Back to the abscissas of a profile, by straight lines.
    std::array::from_fn(|i| {
        let x = RADIUS_M * profile_abscissa(i);
        let right = turned.partition_point(|[at, _]| *at < x).clamp(1, POINTS - 1);
        let ([x0, z0], [x1, z1]) = (turned[right - 1], turned[right]);
        fill_m + z0 + (x - x0) / (x1 - x0) * (z1 - z0)
    })
}
