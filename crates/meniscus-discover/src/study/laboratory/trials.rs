//! Trials of the second laboratory: what is hidden in which glass.

use super::camera::Faults;
use super::glass::LaboratoryGlass;
use crate::recordings::motion_plan::MotionPlan;
use crate::study::unnamed::laws::{HiddenLaw, JUDGED};
use meniscus_numerics::random::normal;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// Stated viscosity of the liquid in question, Pa s.
pub(super) const VISCOSITY_PA_S: f64 = 0.05;

/// Viscosities of the references, Pa s.
pub(super) const REFERENCES_PA_S: [f64; 9] = [0.05, 0.042, 0.06, 0.05, 0.042, 0.06, 0.05, 0.046, 0.054];

/// Parts by which a glass differs from the next: frequencies, dampings, second order.
const DIFFERS: [f64; 3] = [0.001, 0.01, 0.05];

/// Sizes at which each effect is hidden.
const SIZES: [f64; 2] = [1.0, 2.0];

/// Size of the laws that no library holds.
const LAW_SIZE: f64 = 0.95;

/// Number of clean glasses, and first seeds of the references, the clean glasses and the others.
const CLEAN: u64 = 24;
const REFERENCE_SEED: u64 = 1;
const CLEAN_SEED: u64 = 600;
const HIDDEN_SEED: u64 = 700;
const OUTSIDE_SEED: u64 = 800;

/// Group of trials with one purpose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum TrialPurpose {
    /// An effect of the library is hidden.
    Hidden,
    /// Nothing is hidden.
    Clean,
    /// A force is hidden that no library holds.
    Outside,
}

/// Effect of the library as this laboratory hides it.
#[derive(Clone, Copy, Debug)]
struct Effect {
    /// Its name in the library.
    name: &'static str,
    /// Its coordinate in the library where it is absent, and the step to the reference size.
    absent: f64,
    step: f64,
    /// Puts the coordinate into a glass and before a camera.
    apply: fn(f64, &mut LaboratoryGlass, &mut Faults),
}

const EFFECTS: [Effect; 16] = [
    effect("viscosity", 1.0, 0.3, |x, glass, _| glass.liquid.consistency *= x),
    effect("wall_slip", 0.0, 0.0015, |x, glass, _| glass.liquid.slip_m = x),
    effect("shear_thinning", 1.0, -0.25, |x, glass, _| glass.liquid.index = x),
    effect("yield_stress", 0.0, 0.5, |x, glass, _| glass.liquid.yield_pa = x),
    effect("contact_line", 0.0, 0.01, |x, glass, _| glass.line.sliding_n_m = x),
    effect("foam", 0.0, 0.03, |x, glass, _| glass.line.foam = x),
    effect("surface_tension", 0.0, 0.15, |x, glass, _| glass.liquid.tension_n_m = x),
    effect("pinned_line", 0.0, 10.0, |x, glass, _| glass.line.spring_n_m2 = x),
    effect("viscoelastic", 0.0, 4.0, |x, glass, _| {
        (glass.liquid.modulus_pa, glass.liquid.relaxation_s) = (x, 0.06);
    }),
    effect("vertical_acceleration", 0.0, 0.4, |x, glass, _| glass.gravity_m_s2 += x),
    effect("radius", 0.0, 0.001, |x, glass, _| glass.radius_m += x),
    effect("fill", 0.0, 0.003, |x, glass, _| glass.fill_m += x),
    effect("actuation_gain", 1.0, 0.08, |x, _, faults| faults.gain = x),
    effect("camera_latency", 0.0, 0.025, |x, _, faults| faults.latency_s = x),
    effect("camera_pitch", 0.0, 0.035, |x, _, faults| faults.pitch_rad = x),
    effect("camera_slope", 0.0, 0.05, |x, _, faults| faults.roll_rad = x),
];

const fn effect(
    name: &'static str,
    absent: f64,
    step: f64,
    apply: fn(f64, &mut LaboratoryGlass, &mut Faults),
) -> Effect {
    Effect { name, absent, step, apply }
}

/// One trial.
#[derive(Clone, Debug)]
pub struct LaboratoryTrial {
    /// TrialPurpose.
    pub purpose: TrialPurpose,
    /// Name of the effect or force; empty where nothing is hidden.
    pub name: &'static str,
    /// Size in reference sizes.
    pub size: f64,
    /// Coordinate of the effect in the library.
    pub truth: Option<f64>,
    /// Effects that are taken out of the library because they are the same force.
    pub same: &'static [&'static str],
    /// LaboratoryGlass.
    pub glass: LaboratoryGlass,
    /// Camera and motion.
    pub faults: Faults,
    /// Seed of the noise.
    pub seed: u64,
}

/// Returns the motions of each glass; the last one is held out.
#[must_use]
pub fn motions() -> Vec<MotionPlan> {
    [0.35, 0.7, 1.2, 0.95].map(|strength| MotionPlan::jolt(0.3, strength, 2.4)).to_vec()
}

/// Returns the glass of `seed`.
fn glass(viscosity_pa_s: f64, seed: u64) -> LaboratoryGlass {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    LaboratoryGlass {
        differs: DIFFERS.map(|part| part * normal(&mut random)),
        ..LaboratoryGlass::plain(viscosity_pa_s)
    }
}

/// Returns the glasses of the references with their seeds.
#[must_use]
pub fn references() -> Vec<(LaboratoryGlass, u64)> {
    (REFERENCE_SEED..).zip(REFERENCES_PA_S).map(|(seed, viscosity)| (glass(viscosity, seed), seed)).collect()
}

/// Returns all trials.
#[must_use]
pub fn laboratory_trials() -> Vec<LaboratoryTrial> {
    let plain = |purpose: TrialPurpose, seed: u64| LaboratoryTrial {
        purpose,
        name: "",
        size: 0.0,
        truth: None,
        same: &[],
        glass: glass(VISCOSITY_PA_S, seed),
        faults: Faults::NONE,
        seed,
    };
    let mut out = Vec::new();
    let hidden = SIZES.into_iter().flat_map(|size| EFFECTS.map(|effect| (size, effect)));
    for (seed, (size, effect)) in (HIDDEN_SEED..).zip(hidden) {
        let truth = effect.absent + size * effect.step;
        let mut trial = plain(TrialPurpose::Hidden, seed);
        (effect.apply)(truth, &mut trial.glass, &mut trial.faults);
        out.push(LaboratoryTrial { name: effect.name, size, truth: Some(truth), ..trial });
    }
    out.extend((0..CLEAN).map(|i| plain(TrialPurpose::Clean, CLEAN_SEED + i)));
    for (seed, law) in (OUTSIDE_SEED..).zip(JUDGED) {
        let mut trial = plain(TrialPurpose::Outside, seed);
        trial.glass.law = Some(HiddenLaw { size: LAW_SIZE, ..law });
        out.push(LaboratoryTrial { name: law.name, size: LAW_SIZE, same: law.same, ..trial });
    }
    out
}
