//! The product with weights of a byte, summed in whole numbers.
//!
//! ```text
//! s = max |x| / 32767,  q = x / s to the nearest whole number
//! y_i = y_i + scale_i s sum_j k_ij q_j         k of 8 bits, q of 16, sums of 32
//! ```
//! x loses at most 1 / 65534 of its largest number, a weight 1 / 254 of its row's. Whole numbers add up to the same in any
//! order, so every processor gives the same bits.
#![allow(unsafe_code, reason = "a function compiled for AVX2 is called; the argument stands at the call")]

use super::packing::PANEL;

/// Columns that a sum of 32 bits has room for: 512 * 128 * 32767 < 2^31.
const MOST: usize = 512;

/// Weights in panels, a scale a row.
#[derive(Clone, Copy)]
pub(super) struct Bytes<'a> {
    pub(super) panels: &'a [[i8; PANEL]],
    pub(super) scales: &'a [[f32; PANEL]],
    pub(super) columns: usize,
}

impl Bytes<'_> {
    /// y = y + diag(scale) K x.
    pub(super) fn accumulate(&self, x: &[f32], y: &mut [f32]) {
        let x = x.get(..self.columns).unwrap_or(x);
        let mut room = [0_i16; MOST];
        for (part, x) in x.chunks(MOST).enumerate() {
            let step = rounded(x, &mut room);
            let q = room.get(..x.len()).unwrap_or_default();
            let product = Product { weights: *self, first: part * MOST, q, step, y: &mut *y };
            #[cfg(target_arch = "x86_64")]
            if super::is_wide() {
                // SAFETY: whoever allowed wide vectors promised that AVX2 is there.
                unsafe { avx2::run(product) };
                continue;
            }
            portable(product);
        }
    }
}

/// x as whole numbers of the step that is returned. Where a number of x is none, neither is the step.
fn rounded(x: &[f32], q: &mut [i16]) -> f32 {
    const LARGEST: f32 = i16::MAX as f32;
    let larger = |most: f32, x: &f32| if x.abs() > most || x.is_nan() { x.abs() } else { most };
    let most = x.iter().fold(0.0, larger);
    // Of a number too small for its reciprocal nothing is left but a product that is too small as well.
    let inverse = if most > f32::MIN_POSITIVE { LARGEST / most } else { 0.0 };
    for (q, x) in q.iter_mut().zip(x) {
        let scaled = x * inverse;
        *q = (scaled + 0.5_f32.copysign(scaled)) as i16;
    }
    most / LARGEST
}

/// A product with up to [`MOST`] columns, from column `first` on.
struct Product<'a> {
    weights: Bytes<'a>,
    first: usize,
    q: &'a [i16],
    step: f32,
    y: &'a mut [f32],
}

impl Product<'_> {
    /// `sums` of every panel, which gets its columns, added to y at their scales.
    #[inline(always)]
    fn with(self, sums: impl Fn(&[[i8; PANEL]], &[i16]) -> [i32; PANEL]) {
        let panels = self.weights.panels.chunks_exact(self.weights.columns.max(1));
        for ((out, panel), scales) in self.y.chunks_mut(PANEL).zip(panels).zip(self.weights.scales) {
            let panel = panel.get(self.first..).unwrap_or_default();
            let panel = panel.get(..self.q.len()).unwrap_or(panel);
            for ((o, sum), scale) in out.iter_mut().zip(sums(panel, self.q)).zip(scales) {
                *o += sum as f32 * (scale * self.step);
            }
        }
    }
}

/// As the compiler finds it.
fn portable(product: Product<'_>) {
    product.with(|panel, q| {
        let mut sums = [0_i32; PANEL];
        for (column, &q) in panel.iter().zip(q) {
            for (sum, &k) in sums.iter_mut().zip(column) {
                *sum += i32::from(k) * i32::from(q);
            }
        }
        sums
    });
}

/// The same by the instruction that adds two neighbouring products. The compiler does not find it, as it does not know that
/// columns may be taken in pairs; what it finds takes twice as long (docs/bench).
#[cfg(target_arch = "x86_64")]
mod avx2 {
    use super::{PANEL, Product};
    use core::arch::x86_64::{
        __m128i, __m256i, _mm256_add_epi32, _mm256_cvtepi8_epi16, _mm256_madd_epi16,
        _mm256_permute2x128_si256, _mm256_set1_epi32, _mm256_unpackhi_epi16, _mm256_unpacklo_epi16,
    };

    #[target_feature(enable = "avx2")]
    pub(super) fn run(product: Product<'_>) {
        product.with(|panel, q| {
            // Rows 0..4 and 8..12, 4..8 and 12..16 of the upper half of the panel, the same of the lower.
            let mut sums: [__m256i; 4] = bytemuck::cast([0_i32; PANEL]);
            let (pairs, last) = panel.as_chunks::<2>();
            let (twos, odd) = q.as_chunks::<2>();
            for (pair, two) in pairs.iter().zip(twos) {
                add(&mut sums, pair, *two);
            }
            if let ([column], [q]) = (last, odd) {
                add(&mut sums, &[*column, [0; PANEL]], [*q, 0]);
            }
            let [a, b, c, d] = sums;
            bytemuck::cast([
                _mm256_permute2x128_si256::<0x20>(a, b),
                _mm256_permute2x128_si256::<0x31>(a, b),
                _mm256_permute2x128_si256::<0x20>(c, d),
                _mm256_permute2x128_si256::<0x31>(c, d),
            ])
        });
    }

    /// sums + k_j q_j + k_j+1 q_j+1.
    #[inline]
    #[target_feature(enable = "avx2")]
    fn add(sums: &mut [__m256i; 4], pair: &[[i8; PANEL]; 2], q: [i16; 2]) {
        let q = _mm256_set1_epi32(bytemuck::cast(q));
        let [one, other]: [[__m128i; 2]; 2] = bytemuck::cast(*pair);
        let (halves, _) = sums.as_chunks_mut::<2>();
        for ((half, one), other) in halves.iter_mut().zip(one).zip(other) {
            let (one, other) = (_mm256_cvtepi8_epi16(one), _mm256_cvtepi8_epi16(other));
            let [outer, inner] = half;
            *outer = _mm256_add_epi32(*outer, _mm256_madd_epi16(_mm256_unpacklo_epi16(one, other), q));
            *inner = _mm256_add_epi32(*inner, _mm256_madd_epi16(_mm256_unpackhi_epi16(one, other), q));
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
    use std::vec;
    use std::vec::Vec;

    /// Weights with every value, the largest of them in the first column.
    fn weights(rows: usize, columns: usize) -> (Vec<[i8; PANEL]>, Vec<[f32; PANEL]>) {
        let panels = rows.div_ceil(PANEL);
        let k = |at: usize, row: usize| {
            if at.is_multiple_of(columns) { -128 } else { (37 * at + 91 * row) as i8 }
        };
        (
            (0..panels * columns).map(|at| core::array::from_fn(|row| k(at, row))).collect(),
            vec![core::array::from_fn(|row| 0.01 + 0.001 * row as f32); panels],
        )
    }

    #[test]
    fn sums_are_those_of_the_definition_for_any_number_of_columns() {
        for (rows, columns) in [(1, 1), (40, 2), (32, 7), (64, 512), (33, 513), (70, 1100)] {
            let (panels, scales) = weights(rows, columns);
            let bytes = Bytes { panels: &panels, scales: &scales, columns };
            let x: Vec<f32> = (0..columns)
                .map(|j| if j == 0 { 3.0 } else { (j as f32 * 0.37).rem_euclid(2.0) - 1.0 })
                .collect();
            let mut y = vec![1.0_f32; rows];
            bytes.accumulate(&x, &mut y);
            let size: f64 = x.iter().map(|x| 127.0 * f64::from(x.abs())).sum();
            for (i, said) in y.iter().enumerate() {
                let column = |j: usize| f64::from(panels[(i / PANEL) * columns + j][i % PANEL]);
                let sum: f64 = x.iter().enumerate().map(|(j, x)| column(j) * f64::from(*x)).sum();
                let scale = f64::from(scales[i / PANEL][i % PANEL]);
                let off = (f64::from(*said) - 1.0 - scale * sum).abs();
                assert!(off <= scale * size * 2e-4, "{rows} x {columns}, row {i}: {said} is off by {off}");
            }
        }
    }

    /// The largest sum that can be stays one: -128 times 32767, 512 times.
    #[test]
    fn the_largest_sum_has_room() {
        let panels = vec![[-128_i8; PANEL]; MOST];
        let bytes = Bytes { panels: &panels, scales: &[[1.0; PANEL]], columns: MOST };
        let mut y = [0.0; 1];
        bytes.accumulate(&[-2.0; MOST], &mut y);
        assert!((y[0] - 128.0 * 2.0 * MOST as f32).abs() < 1.0, "{y:?}");
    }

    #[test]
    fn what_is_no_number_stays_none_and_nothing_stays_nothing() {
        let (panels, scales) = weights(4, 3);
        let bytes = Bytes { panels: &panels, scales: &scales, columns: 3 };
        for none in [f32::NAN, f32::INFINITY] {
            let mut y = [0.0; 4];
            bytes.accumulate(&[1.0, none, 2.0], &mut y);
            assert!(y.iter().all(|y| !y.is_finite()), "{none}: {y:?}");
        }
        for nothing in [0.0, -0.0, 1e-41] {
            let mut y = [0.5; 4];
            bytes.accumulate(&[nothing; 3], &mut y);
            assert_eq!(y, [0.5; 4], "{nothing}");
        }
    }

    #[cfg(target_arch = "x86_64")]
    #[test]
    fn wide_and_narrow_give_the_same_bits() {
        if !std::is_x86_feature_detected!("avx2") {
            return std::println!("skipped: this processor has no AVX2");
        }
        for columns in [1, 2, 25, 200] {
            let (panels, scales) = weights(70, columns);
            let q: Vec<i16> = (0..columns).map(|j| (j as i16).wrapping_mul(12_345)).collect();
            let mut results = [[0.25_f32; 70], [0.25_f32; 70]];
            let [narrow, wide] = &mut results;
            let weights = Bytes { panels: &panels, scales: &scales, columns };
            portable(Product { weights, first: 0, q: &q, step: 0.1, y: narrow });
            // SAFETY: asked for above.
            unsafe { avx2::run(Product { weights, first: 0, q: &q, step: 0.1, y: wide }) };
            assert_eq!(narrow.map(f32::to_bits), wide.map(f32::to_bits), "{columns} columns");
        }
    }
}
