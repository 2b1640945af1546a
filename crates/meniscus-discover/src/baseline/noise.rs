//! Measurement noise, estimated from the frames in which the glass rests.

use crate::recordings::record::{Quantity, Record};
use std::collections::BTreeMap;

/// Measurement noise of one channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Standard deviation, m.
    pub sigma_m: f64,
    /// Correlation from frame to frame of its slow part.
    pub correlation: f64,
}

/// Returns the noise by channel before the glass moves: spread and correlation from frame to frame, pooled.
#[must_use]
pub fn rest_noise(records: &[Record]) -> BTreeMap<Quantity, Noise> {
    let mut sums: BTreeMap<Quantity, [f64; 4]> = BTreeMap::new();
    for record in records {
        for channel in &record.channels {
            let rest: Vec<f64> = channel.value.iter().take(record.rest_frames).flatten().copied().collect();
            if rest.len() < 4 {
                continue;
            }
            let mean = rest.iter().sum::<f64>() / rest.len() as f64;
            let [square, count, product, pairs] = sums.entry(channel.quantity).or_default();
            *square += rest.iter().map(|x| (x - mean).powi(2)).sum::<f64>();
            *count += rest.len() as f64 - 1.0;
            *product += rest.windows(2).map(|w| (w[0] - mean) * (w[1] - mean)).sum::<f64>();
            *pairs += rest.len() as f64 - 1.0;
        }
    }
    let noise = |[square, count, product, pairs]: [f64; 4]| {
        let variance = (square / count).max(1e-12);
        // Few frames determine a correlation badly, so it is drawn towards 0.3 with the weight of 30 pairs.
        let correlation = (product / pairs / variance * pairs + 0.3 * 30.0) / (pairs + 30.0);
        Noise { sigma_m: variance.sqrt().max(2e-5), correlation: correlation.clamp(0.0, 0.9) }
    };
    sums.into_iter().map(|(quantity, sum)| (quantity, noise(sum))).collect()
}
