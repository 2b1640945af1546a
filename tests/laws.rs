//! The laws hold for any blob: random weights, mild and hostile, under random motion.

mod support;

use meniscus::blob::{EmbeddedEffect, EmbeddedEffects, Model, Tensor};
use meniscus::latent::generic::{LatentState, StepOutcome};
use meniscus::reduced::Rheology;
use meniscus::reduced::effects::find;
use meniscus_data::blob_file::write::{Part, blob};
use meniscus_platform::files::AlignedBytes;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Steps in all, over all blobs of a size; a fifth with effects, whose steps cost Newton's iteration.
const STEPS: usize = 100_000;

/// Blobs of a size.
const BLOBS: u64 = 20;

/// Largest |dE - work| of a step over the energies that took part in it.
const ROUNDING: f64 = 1e-12;

/// Walks every blob that `make` makes of a seed through its share of `steps` and gives the number of steps that
/// were not solved plainly.
fn walk(size: f32, steps: usize, make: impl Fn(u64, f32) -> AlignedBytes) -> usize {
    let mut unsolved = 0;
    for seed in 0..BLOBS {
        let bytes = make(seed, size);
        let model = Model::load(&bytes).expect("a sound blob");
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut state = LatentState::default();
        for step in 0..steps / BLOBS as usize {
            let before = state;
            let energy_before = model.generic.energy(&before);
            let audit = model.generic.step(&mut state, 4.0 * random.random::<f64>() - 2.0);
            let energy_after = model.generic.energy(&state);
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
        walk(0.1, STEPS, support::random_blob),
        0,
        "the step has a solution and must find it, though the preconditioner is noise"
    );
}

#[test]
fn hostile_blobs_keep_the_laws_by_their_fallbacks() {
    let unsolved = walk(3.0, STEPS, support::random_blob);
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
    let unsolved = walk(0.1, STEPS / 5, with_effects);
    assert!(unsolved < STEPS / 5000, "{unsolved} steps were not solved");
    walk(3.0, STEPS / 5, with_effects);
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
        moved += (state.latent - before).norm();
    }
    assert!((model.generic.energy(&state) / start - 1.0).abs() < 1e-10);
    assert!(state.heat < 1e-7 * start, "heat without friction: {:e} of {start:e}", state.heat);
    assert!(moved > 100.0 * state.latent.norm(), "the state must keep turning");
}
