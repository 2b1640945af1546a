//! Randomness that is fast and replays: a table of normal numbers, read from hashed places.

use meniscus_numerics::random::normal;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Numbers in the table.
const TABLE: usize = 1 << 16;

/// Scrambles a number (the finaliser of splitmix64).
pub(crate) fn mix(mut x: u64) -> u64 {
    x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// A table of standard normal numbers.
#[derive(Clone, Debug)]
pub(crate) struct Noise {
    table: Vec<f32>,
}

impl Noise {
    /// The table that belongs to `seed`.
    pub(crate) fn new(seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        Self { table: (0..TABLE).map(|_| normal(&mut random) as f32).collect() }
    }

    /// `length` normal numbers that belong to `seed`, at most a quarter of the table.
    pub(crate) fn row(&self, seed: u64, length: usize) -> &[f32] {
        let start = mix(seed) as usize % (TABLE - length);
        &self.table[start..start + length]
    }

    /// Fills `out`, rows of `width`, with normal numbers of unit variance that are correlated over
    /// five by five pixels, as stereo matching makes them.
    pub(crate) fn correlated(&self, seed: u64, width: usize, scratch: &mut Vec<f32>, out: &mut [f32]) {
        let rows = out.len() / width;
        scratch.clear();
        // Sums of five along the row, of variance five.
        for row in 0..rows + 4 {
            let white = self.row(seed.wrapping_add(row as u64), width + 4);
            scratch.extend(white.windows(5).map(|five| five.iter().sum::<f32>()));
        }
        // Sums of five down the column, of variance twenty-five.
        for (row, out) in out.chunks_exact_mut(width).enumerate() {
            out.fill(0.0);
            for above in scratch[row * width..].chunks_exact(width).take(5) {
                out.iter_mut().zip(above).for_each(|(sum, x)| *sum += 0.2 * x);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn correlated_noise_has_unit_variance_and_correlated_neighbours() {
        let noise = Noise::new(3);
        let mut out = vec![0.0; 200 * 200];
        noise.correlated(7, 200, &mut Vec::new(), &mut out);
        let mean = |f: &dyn Fn(usize) -> f32| (0..39_000).map(f).sum::<f32>() / 39_000.0;
        let variance = mean(&|i| out[i] * out[i]);
        assert!((variance - 1.0).abs() < 0.15, "{variance}");
        // Windows one pixel apart share four of five columns.
        let neighbour = mean(&|i| out[i] * out[i + 1]);
        assert!((neighbour - 0.8).abs() < 0.15, "{neighbour}");
    }
}
