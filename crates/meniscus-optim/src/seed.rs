//! Seeds of the stages of one run.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A seed for one stage out of the seed of the run.
#[must_use]
pub fn derive_seed(seed: u64, stage: u64) -> u64 {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(stage);
    rng.random()
}
