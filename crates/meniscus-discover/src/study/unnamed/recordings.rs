//! Recordings of the other solver as the workflow gets them.

use super::laws::HiddenLaw;
use super::solver::{DENSITY_KG_M3, DEPTH_M, Glass, RADIUS_M};
use crate::recordings::motion_plan::MotionPlan;
use crate::recordings::record::{Record, channels};
use crate::recordings::stated::{CALLIPERS_M, Known};
use crate::recordings::tables::drive_of;
use crate::study::motions::{MotionKind, motions};
use meniscus::surface::{POINTS, SurfaceProfile};
use meniscus::units::{FRAME_INTERVAL_S, Micros};
use meniscus_data::motion::Motion;
use meniscus_numerics::random::normal;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Noise of one point of a profile, m.
const NOISE_M: f64 = 3e-4;

/// Parts by which a glass differs from the next: frequencies, dampings, second order.
const DIFFERS: [f64; 3] = [0.001, 0.01, 0.05];

/// Returns glass and liquid as they are stated.
pub(super) fn known(viscosity_pa_s: f64) -> Known {
    Known {
        radius_m: RADIUS_M,
        radius_error_m: CALLIPERS_M,
        fill_m: DEPTH_M,
        density_kg_m3: DENSITY_KG_M3,
        viscosity_pa_s,
        motion_share: [1.0; 2],
    }
}

/// Returns the glass of `seed`.
pub(super) fn glass(viscosity_pa_s: f64, seed: u64) -> Glass {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    Glass { viscosity_pa_s, differs: DIFFERS.map(|part| part * normal(&mut random)) }
}

/// Returns the recordings of the four motions of the study in `glass`, which moves `gain` times as far as is stated.
pub(super) fn records(glass: &Glass, law: Option<&HiddenLaw>, gain: f64, seed: u64) -> Vec<Record> {
    let plans = motions(MotionKind::Single);
    plans
        .iter()
        .enumerate()
        .filter_map(|(i, plan)| record(glass, plan, law, gain, 100 * seed + i as u64))
        .collect()
}

/// Returns the profiles of `glass` on the path `plan` with the noise of `seed`.
#[must_use]
pub fn profiles(glass: &Glass, plan: &MotionPlan, law: Option<&HiddenLaw>, seed: u64) -> Vec<SurfaceProfile> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let frame = |(number, (heights, place)): (usize, ([f64; POINTS], f64))| {
        let mut noise = || NOISE_M * normal(&mut random);
        SurfaceProfile {
            height_m: heights.map(|z| (DEPTH_M + z + noise()) as f32),
            variance_m2: [(NOISE_M * NOISE_M) as f32; POINTS],
            valid: [true; POINTS],
            glass_x_m: Some((place + 0.3 * noise()) as f32),
            sequence: number as u32,
            captured: Micros((number as f64 * FRAME_INTERVAL_S * 1e6) as u64),
        }
    };
    glass.run(plan, law).into_iter().enumerate().map(frame).collect()
}

/// Returns one recording with the noise of `seed`, in `glass`, which moves `gain` times as far as `plan` states.
fn record(glass: &Glass, plan: &MotionPlan, law: Option<&HiddenLaw>, gain: f64, seed: u64) -> Option<Record> {
    let profiles: Vec<Option<SurfaceProfile>> =
        profiles(glass, &stronger(plan, gain), law, seed).into_iter().map(Some).collect();
    Some(Record {
        name: format!("jolt of {:.2} m/s2", plan.jolts[0].strength_m_s2),
        interval_s: FRAME_INTERVAL_S,
        channels: channels(&profiles, DEPTH_M),
        drive: drive_of(&Motion::sampled(&plan.samples())?, plan.seconds),
        rest_frames: (plan.jolts[0].start_s / FRAME_INTERVAL_S) as usize,
    })
}

/// Returns `plan` with all jolts `gain` times as strong.
fn stronger(plan: &MotionPlan, gain: f64) -> MotionPlan {
    let mut out = plan.clone();
    out.jolts.iter_mut().for_each(|jolt| jolt.strength_m_s2 *= gain);
    out
}
