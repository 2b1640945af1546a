//! The laws hold for any blob: random weights, mild and hostile, under random motion.

mod support;

use meniscus::blob::{EmbeddedEffect, EmbeddedEffects, Model, Tensor};
use meniscus::latent::generic::{Latent, LatentState, StepOutcome};
use meniscus::real::{Real, narrow};
use meniscus::reduced::Rheology;
use meniscus::reduced::effects::find;
use meniscus_data::blob_file::write::{Part, blob};
use meniscus_platform::files::AlignedBytes;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Steps in all, over all blobs of a size; a fifth with effects, whose steps cost Newton's iteration. Fewer where each one takes
/// long, as in mutation testing.
const STEPS: usize = if cfg!(debug_assertions) { 4_000 } else { 100_000 };

/// Blobs of a size.
const BLOBS: u64 = 20;

/// Largest |dE - work| of a step over the energies that took part in it.
const ROUNDING: f64 = 1e-12;

/// H(x) + s with what memories hold, H in the precision `R`.
fn energy<R: Real>(model: &Model<'_>, state: &LatentState) -> f64 {
    let stored = model.generic.slots.as_ref().map_or(0.0, |slots| slots.stored(&state.held));
    model.generic.potential.value(&narrow::<R, _, _>(&state.latent)).wide() + state.heat + stored
}

/// Walks every blob that `make` makes of a seed through its share of `steps` and gives the number of steps that
/// were not solved plainly in the precision `R`. The books are those of H as that precision has it.
fn walk<R: Real>(size: f32, steps: usize, make: impl Fn(u64, f32) -> AlignedBytes) -> usize {
    let mut unsolved = 0;
    for seed in 0..BLOBS {
        let bytes = make(seed, size);
        let model = Model::load(&bytes).expect("a sound blob");
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut state = LatentState::default();
        for step in 0..steps / BLOBS as usize {
            let before = state;
            let energy_before = energy::<R>(&model, &before);
            let audit = model.generic.step_in::<R>(&mut state, 4.0 * random.random::<f64>() - 2.0);
            let energy_after = energy::<R>(&model, &state);
            let at = || format!("size {size}, seed {seed}, step {step}: {audit:?}");

            assert!(state.latent.iter().all(|x| x.is_finite()) && state.heat.is_finite(), "{}", at());
            assert!(state.heat >= before.heat, "entropy fell: {}", at());
            assert!(audit.heat >= 0.0, "{}", at());
            let scale = energy_before.abs() + energy_after.abs() + audit.work.abs();
            let residual = (energy_after - energy_before - audit.work).abs();
            assert!(residual <= ROUNDING * scale, "energy is off by {residual:e} of {scale:e}: {}", at());
            unsolved += usize::from(audit.outcome != StepOutcome::Solved);
        }
    }
    unsolved
}

#[test]
fn mild_blobs_keep_the_laws() {
    assert_eq!(
        walk::<f64>(0.1, STEPS, support::random_blob),
        0,
        "the step has a solution and must find it, though the preconditioner is noise"
    );
}

#[test]
fn the_laws_hold_in_single_precision() {
    let unsolved = walk::<f32>(0.1, STEPS, support::random_blob);
    assert_eq!(unsolved, 0, "rounding must not keep a step of a mild blob from its solution");
    walk::<f32>(3.0, STEPS, support::random_blob);
    walk::<f32>(0.1, STEPS / 5, with_effects);
}

/// Iterations that a step takes at most, from a slosh of any size down to `least`.
fn most_iterations<R: Real>(model: &Model<'_>, least: f64) -> u32 {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let sizes = std::iter::successors(Some(0.1), |size| Some(0.1 * size)).take_while(|size| *size >= least);
    let iterations = sizes.map(|size| {
        let latent = Latent::from_fn(|_, _| size * (2.0 * random.random::<f64>() - 1.0));
        let audit = model.generic.step_in::<R>(&mut LatentState { latent, ..LatentState::default() }, 0.0);
        assert_eq!(audit.outcome, StepOutcome::Solved, "size {size:e}: {audit:?}");
        audit.iterations
    });
    iterations.max().expect("some sizes")
}

/// A glass that has come to rest must cost no more than one that sloshes. The gradient once lost its digits by cancellation there:
/// from 1e-4 down no step was solved, and each took all iterations.
#[test]
fn a_step_is_solved_however_small_the_slosh() {
    for seed in 0..BLOBS {
        let bytes = support::random_blob(seed, 0.1);
        let model = Model::load(&bytes).expect("a sound blob");
        // Squares of smaller numbers leave the range of the precision.
        let most = most_iterations::<f64>(&model, 1e-140).max(most_iterations::<f32>(&model, 1e-12));
        let lively = most_iterations::<f64>(&model, 1e-2);
        assert!(most <= lively + 2, "seed {seed}: {most} iterations, {lively} in a lively slosh");
    }
}

#[test]
fn hostile_blobs_keep_the_laws_by_their_fallbacks() {
    let unsolved = walk::<f64>(3.0, STEPS, support::random_blob);
    assert!(unsolved > STEPS / 10, "these blobs must need the fallbacks, or nothing is tested: {unsolved}");
}

/// A random blob that names four effects of random values: one of the liquid, the two that remember, one of gravity.
fn with_effects(seed: u64, size: f32) -> AlignedBytes {
    let mut random = ChaCha8Rng::seed_from_u64(seed ^ 0xeffec7);
    let mut header = support::header();
    let mut parts = support::parts(seed, size);
    // A = first latent in cm, B = second in dm/s; the rest of each direction may point anywhere.
    let mut rows = vec![0.0_f32; 4 * 13];
    (rows[0], rows[14], rows[26], rows[40]) = (0.01, 0.1, 100.0, 10.0);
    for along in [26, 39] {
        (2..13).for_each(|k| rows[along + k] = 20.0 * random.random::<f32>() - 10.0);
    }
    parts.push(Part { tensor: Tensor::ModeMap, rows: 4, columns: 13, values: rows });
    let liquid = ["viscosity", "shear_thinning", "yield_stress", "wall_slip", "surface_film", "foam"];
    let first = liquid[random.random_range(0..liquid.len())];
    let effects = [first, "viscoelastic", "contact_line", "vertical_acceleration"];
    let consistency = 10.0_f64.powf(random.random_range(-3.0..0.5));
    let named = effects.iter().map(|name| {
        let entry = find(name).expect("in the library");
        let mut values = entry.neutral();
        for (value, parameter) in values.iter_mut().zip(entry.parameters) {
            let (least, largest) = parameter.range;
            if parameter.name != "share" {
                *value = least + (largest - least) * random.random::<f64>().powi(3);
            }
        }
        EmbeddedEffect { name: (*name).try_into().expect("short"), values }
    });
    header.embedded = Some(EmbeddedEffects {
        density_kg_m3: 1261.0,
        liquid: Rheology::newtonian(consistency),
        effects: named.collect(),
    });
    AlignedBytes::copy(&blob(header, &parts).expect("the parts fit a blob"))
}

/// Friction that depends on the state, a bent energy and memories: the laws hold whatever effects a blob names.
#[test]
fn blobs_with_effects_keep_the_laws() {
    let unsolved = walk::<f64>(0.1, STEPS / 5, with_effects);
    assert!(5000 * unsolved <= STEPS, "{unsolved} steps were not solved");
    walk::<f64>(3.0, STEPS / 5, with_effects);
}

/// A random blob of a liquid whose friction depends on the rate of shear, yield stresses among them.
fn with_friction_law(seed: u64, size: f32) -> AlignedBytes {
    let mut random = ChaCha8Rng::seed_from_u64(seed ^ 0xf1_0e5);
    let mut parts = support::parts(seed, size);
    let typical = 10.0_f32.powf(random.random_range(-3.0..3.0));
    let floor = 10.0_f32.powf(random.random_range(-2.0..0.0));
    let (yield_share, index) = (random.random::<f32>(), random.random_range(0.1..1.5));
    let values = vec![typical, floor, yield_share, index];
    parts.push(Part { tensor: Tensor::FrictionLaw, rows: 4, columns: 1, values });
    AlignedBytes::copy(&blob(support::header(), &parts).expect("the parts fit a blob"))
}

/// Friction by a law of flow: the laws hold whatever its numbers are.
#[test]
fn blobs_with_a_friction_law_keep_the_laws() {
    let unsolved = walk::<f64>(0.1, STEPS / 10, with_friction_law);
    assert!(5000 * unsolved <= STEPS, "{unsolved} steps were not solved");
    walk::<f64>(3.0, STEPS / 10, with_friction_law);
    walk::<f32>(0.1, STEPS / 20, with_friction_law);
}

/// Without friction the step must turn for ever: no heat, and no energy lost.
#[test]
fn without_friction_nothing_is_lost() {
    let mut parts = support::parts(7, 0.3);
    for part in &mut parts {
        match part.tensor {
            Tensor::FrictionFactor => part.values.fill(0.0),
            Tensor::Preconditioner => {
                part.values.fill(0.0);
                (0..13).for_each(|k| part.values[14 * k] = 1.0);
            }
            _ => {}
        }
    }
    let bytes = blob(support::header(), &parts).expect("the parts fit a blob");
    let bytes = AlignedBytes::copy(&bytes);
    let model = Model::load(&bytes).expect("a sound blob");
    let mut state = LatentState::default();
    model.generic.step(&mut state, 3.0);
    let start = model.generic.energy(&state);
    assert!(start > 0.0);
    let mut moved = 0.0;
    for _ in 0..10_000 {
        let before = state.latent;
        let audit = model.generic.step(&mut state, 0.0);
        assert_ne!(audit.outcome, StepOutcome::Backtracked, "{audit:?}");
        // What the nudge is for: without it a rounding error raises the energy now and then.
        assert!(audit.heat >= 0.0, "{audit:?}");
        moved += (state.latent - before).norm();
    }
    assert!((model.generic.energy(&state) / start - 1.0).abs() < 1e-10);
    assert!(state.heat < 1e-7 * start, "heat without friction: {:e} of {start:e}", state.heat);
    assert!(moved > 100.0 * state.latent.norm(), "the state must keep turning");
}

/// A drive beyond all numbers leaves the state as it was, and the books empty.
#[test]
fn a_step_without_a_number_at_its_end_is_held() {
    let bytes = support::random_blob(3, 0.1);
    let model = Model::load(&bytes).expect("a sound blob");
    let mut state = LatentState::default();
    model.generic.step(&mut state, 1.0);
    for u in [f64::MAX, f64::INFINITY, f64::NAN] {
        let before = state;
        let audit = model.generic.step(&mut state, u);
        assert_eq!((audit.outcome, state), (StepOutcome::Held, before), "{u}");
        assert_eq!((audit.work, audit.heat, audit.energy_residual), (0.0, 0.0, 0.0), "{u}");
    }
    assert_eq!(model.generic.step(&mut state, 1.0).outcome, StepOutcome::Solved);
}
