//! The laws hold for any blob: random weights, mild and hostile, under random motion.
#![allow(clippy::disallowed_methods, reason = "only storey 1 must compute the same bits on every platform")]

mod support;

use meniscus::generic::{Outcome, State};
use meniscus::model::Model;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Steps in all, over all blobs of a size.
const STEPS: usize = 100_000;

/// Blobs of a size.
const BLOBS: u64 = 20;

/// Largest |dE - work| of a step over the energies that took part in it.
const ROUNDING: f64 = 1e-12;

/// Walks every blob of `size` through its share of [`STEPS`] and gives the number of steps that were
/// not solved plainly.
fn walk(size: f32) -> usize {
    let mut unsolved = 0;
    for seed in 0..BLOBS {
        let bytes = support::random_blob(seed, size);
        let model = Model::load(&bytes).expect("a sound blob");
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut state = State::default();
        for step in 0..STEPS / BLOBS as usize {
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
            unsolved += usize::from(audit.outcome != Outcome::Solved);
        }
    }
    unsolved
}

#[test]
fn mild_blobs_keep_the_laws() {
    assert_eq!(walk(0.1), 0, "the step has a solution and must find it, though the preconditioner is noise");
}

#[test]
fn hostile_blobs_keep_the_laws_by_their_fallbacks() {
    let unsolved = walk(3.0);
    assert!(unsolved > STEPS / 10, "these blobs must need the fallbacks, or nothing is tested: {unsolved}");
}

/// Without friction the step must turn for ever: no heat, and no energy lost.
#[test]
fn without_friction_nothing_is_lost() {
    let mut parts = support::parts(7, 0.3);
    for part in &mut parts {
        match part.tensor {
            meniscus::model::Tensor::FrictionFactor => part.values.fill(0.0),
            meniscus::model::Tensor::Preconditioner => {
                part.values.fill(0.0);
                (0..13).for_each(|k| part.values[14 * k] = 1.0);
            }
            _ => {}
        }
    }
    let blob = meniscus::offline::export::blob(support::header(), &parts).expect("the parts fit a blob");
    let bytes = meniscus::host::files::AlignedBytes::copy(&blob);
    let model = Model::load(&bytes).expect("a sound blob");
    let mut state = State::default();
    model.generic.step(&mut state, 3.0);
    let start = model.generic.energy(&state);
    assert!(start > 0.0);
    let mut moved = 0.0;
    for _ in 0..10_000 {
        let before = state.latent;
        let audit = model.generic.step(&mut state, 0.0);
        assert_ne!(audit.outcome, Outcome::Backtracked, "{audit:?}");
        moved += (state.latent - before).norm();
    }
    assert!((model.generic.energy(&state) / start - 1.0).abs() < 1e-10);
    assert!(state.heat < 1e-7 * start, "heat without friction: {:e} of {start:e}", state.heat);
    assert!(moved > 100.0 * state.latent.norm(), "the state must keep turning");
}
