//! The vectors of AVX2 and AVX-512.
//!
//! Each type is named by the function alone that compiles work for its instructions, so that a type is never used without them.
#![allow(unsafe_code, reason = "vector instructions are named, and read and write by pointers")]

use super::{Eight, Width, Work, plain_pick};
use std::arch::x86_64::*;

#[target_feature(enable = "avx2")]
pub(super) fn with_256(work: impl Work) {
    work.run::<Wide256>();
}

#[target_feature(enable = "avx512f,avx512vl,avx2,popcnt")]
pub(super) fn with_512(work: impl Work) {
    work.run::<Wide512>();
}

/// Those of AVX2. Named by [`with_256`] alone, so that they are there.
struct Wide256;

impl Width for Wide256 {
    #[inline(always)]
    fn transpose(from: [&[f64; 8]; 8], to: [&mut [f64; 8]; 8]) {
        let from = from.map(|from| from.as_ptr());
        let to = to.map(|to| to.as_mut_ptr());
        // SAFETY: the type is named by `with_256` alone; every pointer is to eight numbers, of which four are read or written
        // from the first or the fifth on.
        unsafe {
            for (rows, columns) in [(0, 0), (0, 4), (4, 0), (4, 4)] {
                turn(
                    std::array::from_fn(|k| from[rows + k].add(columns)),
                    std::array::from_fn(|c| to[columns + c].add(rows)),
                );
            }
        }
    }

    #[inline(always)]
    fn pick(eight: &Eight<'_>, reach2: f64, from: u32, out: &mut [u32; 8]) -> usize {
        plain_pick(eight, reach2, from, out)
    }

    #[inline(always)]
    fn transpose_single(from: [&[f32; 8]; 8], to: [&mut [f32; 8]; 8]) {
        // SAFETY: the type is named by `with_256` alone.
        unsafe { turn_single(from, to) };
    }

    #[inline(always)]
    fn columns(from: [&[f32; 4]; 8], to: [&mut [f32; 8]; 4]) {
        // SAFETY: the type is named by `with_256` alone.
        unsafe { quads(from, to) };
    }

    #[inline(always)]
    fn rows(from: [&[f32; 8]; 4], to: [&mut [f32; 4]; 8]) {
        // SAFETY: the type is named by `with_256` alone.
        unsafe { fours(from, to) };
    }
}

/// Turns four rows of four numbers.
///
/// # Safety
/// Four numbers can be read at each of `from` and written at each of `to`.
#[inline]
#[target_feature(enable = "avx2")]
unsafe fn turn(from: [*const f64; 4], to: [*mut f64; 4]) {
    // SAFETY: the caller's promise.
    unsafe {
        let [a, b, c, d] = from.map(|from| _mm256_loadu_pd(from));
        let (low, high) = (_mm256_unpacklo_pd(a, b), _mm256_unpackhi_pd(a, b));
        let (low_2, high_2) = (_mm256_unpacklo_pd(c, d), _mm256_unpackhi_pd(c, d));
        _mm256_storeu_pd(to[0], _mm256_permute2f128_pd::<0x20>(low, low_2));
        _mm256_storeu_pd(to[1], _mm256_permute2f128_pd::<0x20>(high, high_2));
        _mm256_storeu_pd(to[2], _mm256_permute2f128_pd::<0x31>(low, low_2));
        _mm256_storeu_pd(to[3], _mm256_permute2f128_pd::<0x31>(high, high_2));
    }
}

/// Those of AVX-512. Named by [`with_512`] alone, so that they are there.
struct Wide512;

impl Width for Wide512 {
    #[inline(always)]
    fn transpose(from: [&[f64; 8]; 8], to: [&mut [f64; 8]; 8]) {
        // SAFETY: the type is named by `with_512` alone; every pointer is to eight numbers.
        unsafe {
            let r = from.map(|from| _mm512_loadu_pd(from.as_ptr()));
            // Columns 2l and 2l + 1 of lane l, of two rows each.
            let low: [__m512d; 4] = std::array::from_fn(|k| _mm512_unpacklo_pd(r[2 * k], r[2 * k + 1]));
            let high: [__m512d; 4] = std::array::from_fn(|k| _mm512_unpackhi_pd(r[2 * k], r[2 * k + 1]));
            let [a, b, c, d] = quarters(low);
            let [e, f, g, h] = quarters(high);
            for (column, to) in [a, e, b, f, c, g, d, h].into_iter().zip(to) {
                _mm512_storeu_pd(to.as_mut_ptr(), column);
            }
        }
    }

    #[inline(always)]
    fn pick(eight: &Eight<'_>, reach2: f64, from: u32, out: &mut [u32; 8]) -> usize {
        // SAFETY: the type is named by `with_512` alone; every pointer is to eight numbers.
        unsafe {
            let numbers = _mm256_loadu_si256(eight.numbers.as_ptr().cast());
            let distance2 = _mm512_loadu_pd(eight.distance2.as_ptr());
            let near = _mm512_cmp_pd_mask::<_CMP_LT_OQ>(distance2, _mm512_set1_pd(reach2));
            let after = _mm256_cmpge_epu32_mask(numbers, _mm256_set1_epi32(from.cast_signed()));
            let first = ((1_u16 << eight.first.min(8)) - 1) as u8;
            let picked = near & after & first;
            _mm256_storeu_si256(out.as_mut_ptr().cast(), _mm256_maskz_compress_epi32(picked, numbers));
            picked.count_ones() as usize
        }
    }

    #[inline(always)]
    fn transpose_single(from: [&[f32; 8]; 8], to: [&mut [f32; 8]; 8]) {
        // SAFETY: the type is named by `with_512` alone, which has AVX2.
        unsafe { turn_single(from, to) };
    }

    #[inline(always)]
    fn columns(from: [&[f32; 4]; 8], to: [&mut [f32; 8]; 4]) {
        // SAFETY: the type is named by `with_512` alone, which has AVX2.
        unsafe { quads(from, to) };
    }

    #[inline(always)]
    fn rows(from: [&[f32; 8]; 4], to: [&mut [f32; 4]; 8]) {
        // SAFETY: the type is named by `with_512` alone, which has AVX2.
        unsafe { fours(from, to) };
    }
}

/// Four numbers of each half of four rows, as columns: those of row `k` of each half are the elements `k` of that half.
#[inline]
#[target_feature(enable = "avx2")]
fn halves([a, b, c, d]: [__m256; 4]) -> [__m256; 4] {
    let (low, high) = (_mm256_unpacklo_ps(a, b), _mm256_unpackhi_ps(a, b));
    let (low_2, high_2) = (_mm256_unpacklo_ps(c, d), _mm256_unpackhi_ps(c, d));
    [
        _mm256_shuffle_ps::<0x44>(low, low_2),
        _mm256_shuffle_ps::<0xee>(low, low_2),
        _mm256_shuffle_ps::<0x44>(high, high_2),
        _mm256_shuffle_ps::<0xee>(high, high_2),
    ]
}

/// Turns eight rows of eight numbers.
#[inline]
#[target_feature(enable = "avx2")]
fn turn_single(from: [&[f32; 8]; 8], to: [&mut [f32; 8]; 8]) {
    // SAFETY: every pointer is to eight numbers.
    unsafe {
        let r = from.map(|from| _mm256_loadu_ps(from.as_ptr()));
        // Columns c and c + 4 of the first four rows, and of the last four.
        let first = halves([r[0], r[1], r[2], r[3]]);
        let last = halves([r[4], r[5], r[6], r[7]]);
        let [low_0, low_1, low_2, low_3, high_0, high_1, high_2, high_3] = to;
        let columns = [(low_0, high_0), (low_1, high_1), (low_2, high_2), (low_3, high_3)];
        for ((a, b), (low, high)) in first.into_iter().zip(last).zip(columns) {
            _mm256_storeu_ps(low.as_mut_ptr(), _mm256_permute2f128_ps::<0x20>(a, b));
            _mm256_storeu_ps(high.as_mut_ptr(), _mm256_permute2f128_ps::<0x31>(a, b));
        }
    }
}

/// Turns eight rows of four numbers into columns.
#[inline]
#[target_feature(enable = "avx2")]
fn quads(from: [&[f32; 4]; 8], to: [&mut [f32; 8]; 4]) {
    // SAFETY: rows have four numbers and columns eight.
    unsafe {
        // Rows k and k + 4 side by side: the half of each that is read second costs no shuffle.
        let both = std::array::from_fn(|k| {
            let [first, second] = [k, k + 4].map(|k| _mm_loadu_ps(from[k].as_ptr()));
            _mm256_insertf128_ps::<1>(_mm256_castps128_ps256(first), second)
        });
        for (column, to) in halves(both).into_iter().zip(to) {
            _mm256_storeu_ps(to.as_mut_ptr(), column);
        }
    }
}

/// Turns four columns of eight numbers into rows.
#[inline]
#[target_feature(enable = "avx2")]
fn fours(from: [&[f32; 8]; 4], to: [&mut [f32; 4]; 8]) {
    // SAFETY: columns have eight numbers and rows four.
    unsafe {
        let rows = halves(from.map(|from| _mm256_loadu_ps(from.as_ptr())));
        let [a, b, c, d, e, f, g, h] = to;
        for (both, (low, high)) in rows.into_iter().zip([(a, e), (b, f), (c, g), (d, h)]) {
            _mm_storeu_ps(low.as_mut_ptr(), _mm256_castps256_ps128(both));
            _mm_storeu_ps(high.as_mut_ptr(), _mm256_extractf128_ps::<1>(both));
        }
    }
}

/// Lane `l` of each of four vectors, for every `l`.
#[inline]
#[target_feature(enable = "avx512f")]
fn quarters([a, b, c, d]: [__m512d; 4]) -> [__m512d; 4] {
    let even = [_mm512_shuffle_f64x2::<0x88>(a, b), _mm512_shuffle_f64x2::<0x88>(c, d)];
    let odd = [_mm512_shuffle_f64x2::<0xdd>(a, b), _mm512_shuffle_f64x2::<0xdd>(c, d)];
    [
        _mm512_shuffle_f64x2::<0x88>(even[0], even[1]),
        _mm512_shuffle_f64x2::<0x88>(odd[0], odd[1]),
        _mm512_shuffle_f64x2::<0xdd>(even[0], even[1]),
        _mm512_shuffle_f64x2::<0xdd>(odd[0], odd[1]),
    ]
}
