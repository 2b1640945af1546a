//! Measurements of `meniscus bench`: the paper's chain on this program's kernels and on its peers, the whole turn from
//! payloads, and the memory and start-up time of a runtime with a paper-size blob.
//!
//! Everything that is divided by something else was measured in turns with it, round after round, so that what else
//! the machine does falls on both.

pub mod chain;
pub mod factor;
pub mod networks;
pub mod peers;
pub mod runtime;
pub mod turn;

use meniscus_numerics::statistics::quantile;
use std::hint::black_box;
use std::time::Instant;

/// Times of calls, nanoseconds.
#[derive(Clone, Debug, Default)]
pub struct Times(pub Vec<u64>);

impl Times {
    /// Adds `count` calls.
    pub fn take(&mut self, count: usize, mut call: impl FnMut()) {
        for _ in 0..count {
            let start = Instant::now();
            call();
            self.0.push(u64::try_from(start.elapsed().as_nanos()).unwrap_or(u64::MAX));
        }
    }

    /// The time that a share of the calls stayed within, microseconds; NaN of no calls.
    #[must_use]
    pub fn quantile_us(&self, share: f64) -> f64 {
        quantile(self.0.iter().copied(), share).map_or(f64::NAN, |ns| ns as f64 / 1e3)
    }

    /// The median, microseconds.
    #[must_use]
    pub fn median_us(&self) -> f64 {
        self.quantile_us(0.5)
    }
}

/// Reads every word of eight bytes once, in two streams as the kernels do, and gives a sum that depends on all.
#[must_use]
pub fn read_once(bytes: &[u8]) -> u64 {
    let words = black_box(bytes).as_chunks::<8>().0;
    let (first, second) = words.split_at(words.len() / 2);
    let sum = |sum: u64, word: &[u8; 8]| sum.wrapping_add(u64::from_le_bytes(*word));
    let both = first.iter().zip(second).fold(0, |all, (a, b)| sum(sum(all, a), b));
    second.iter().skip(first.len()).fold(both, sum)
}

/// Root mean square and largest difference of two fields, group by group, as shares of the group's range in `one`.
#[must_use]
pub fn differences(one: &[f32], other: &[f32]) -> [(f64, f64); 5] {
    let (mut start, mut all) = (0, [(0.0, 0.0); 5]);
    for (widths, slot) in networks::DECODERS.iter().zip(&mut all) {
        let end = start + widths.last().copied().unwrap_or(0);
        let (a, b) = (&one[start..end], &other[start..end]);
        let (low, high) =
            a.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), x| (low.min(*x), high.max(*x)));
        let range = f64::from(high - low);
        let off = || a.iter().zip(b).map(|(x, y)| f64::from(x - y).abs());
        let square: f64 = off().map(|d| d * d).sum();
        *slot = ((square / a.len() as f64).sqrt() / range, off().fold(0.0, f64::max) / range);
        start = end;
    }
    all
}

#[cfg(test)]
mod tests {
    use super::chain::Packed;
    use super::factor::factored;
    use super::networks::Networks;
    use super::*;
    use meniscus::latent::nn::Element;

    #[test]
    fn coarser_chains_stay_near_the_plain_one() {
        let networks = Networks::new(1);
        let plain = Packed::new(&networks, |_| Element::F32);
        let plain = plain.chain().expect("the layers fit");
        let (cut, ranks) = factored(&networks, &plain, 0.005);
        assert!(ranks.iter().all(|(rank, error)| *rank >= 1 && *error <= 0.005), "{ranks:?}");
        let window = Networks::window(1000);
        let mut due = chain::Chain::field();
        plain.run(&window, &mut due);
        let coarse = |layer: &networks::Layer| match layer.name.as_str() {
            name if name.starts_with("spnn") || name.starts_with("head") => Element::F32,
            name if name.starts_with("gru") => Element::Bf16,
            _ => Element::I8,
        };
        for (packed, most) in [
            (Packed::new(&cut, |_| Element::F32), 0.02),
            (Packed::new(&networks, |_| Element::Bf16), 0.05),
            (Packed::new(&networks, coarse), 0.05),
        ] {
            let chain = packed.chain().expect("the layers fit");
            let mut field = chain::Chain::field();
            chain.run(&window, &mut field);
            for (rms, largest) in differences(&due, &field) {
                assert!(rms > 0.0 && largest < most, "{rms} {largest} of the range, for at most {most}");
            }
        }
    }

    #[test]
    fn every_word_is_read_once() {
        for words in [0_u64, 1, 2, 7] {
            let bytes: Vec<u8> = (1..=words).flat_map(u64::to_le_bytes).collect();
            assert_eq!(read_once(&bytes), words * (words + 1) / 2);
        }
    }

    #[test]
    fn quantiles_are_those_of_the_sorted_list() {
        let times = Times((1..=1001).rev().map(|k| k * 1000).collect());
        assert_eq!(
            (times.median_us(), times.quantile_us(0.999), times.quantile_us(1.0)),
            (501.0, 1000.0, 1001.0)
        );
        assert!(Times::default().median_us().is_nan());
    }
}
