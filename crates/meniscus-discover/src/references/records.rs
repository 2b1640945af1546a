//! Simulated heights as recordings with the noise of the measured ones.
//!
//! ```text
//! e_n = sqrt(0.3) s z_n + sqrt(0.7) s w_n,    w_n = rho w_(n-1) + sqrt(1 - rho^2) z'_n,    z, z' normal
//! ```
//! It is the noise that the covariance of a fit expects, with the size and correlation of the measured rest frames.

use crate::baseline::noise::Noise;
use crate::recordings::record::{Channel, Quantity, Record};
use meniscus_numerics::random::normal;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeMap;

/// Part of the variance that is white, as in the covariance of a fit.
const WHITE: f64 = 0.3;

/// Returns the simulated `channels` as a recording like `like`, seen in the same frames, with `noise` from `seed`.
pub(crate) fn record(
    like: &Record,
    channels: Vec<Vec<f64>>,
    noise: &BTreeMap<Quantity, Noise>,
    seed: u64,
) -> Record {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut noisy = |(channel, series): (&Channel, Vec<f64>)| {
        let Noise { sigma_m, correlation } =
            noise.get(&channel.quantity).copied().unwrap_or(Noise { sigma_m: 0.0, correlation: 0.0 });
        let mut slow = normal(&mut random);
        let value = channel.value.iter().zip(series).map(|(seen, z)| {
            slow = correlation * slow + (1.0 - correlation * correlation).sqrt() * normal(&mut random);
            let error = sigma_m * (WHITE.sqrt() * normal(&mut random) + (1.0 - WHITE).sqrt() * slow);
            seen.map(|_| z + error)
        });
        Channel { quantity: channel.quantity, value: value.collect() }
    };
    Record {
        name: format!("{}, simulated", like.name),
        channels: like.channels.iter().zip(channels).map(&mut noisy).collect(),
        ..like.clone()
    }
}
