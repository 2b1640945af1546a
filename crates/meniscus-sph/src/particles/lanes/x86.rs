//! The vectors of AVX2 and AVX-512.
//!
//! Each type is named by the function alone that compiles work for its instructions, so that a type is never used without them.
#![allow(unsafe_code, reason = "vector instructions are named, and read and write by pointers")]

use super::{Width, Work, plain_pick};
use std::arch::x86_64::*;

#[target_feature(enable = "avx2")]
pub(super) fn with_256(work: impl Work) {
    work.run::<Wide256>();
}

#[target_feature(enable = "avx512f,avx512vl,avx2")]
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
    fn pick(numbers: &[u32; 8], distance2: &[f64; 8], reach2: f64, from: u32, out: &mut [u32; 8]) -> usize {
        plain_pick(numbers, distance2, reach2, from, out)
    }

    #[inline(always)]
    fn rows(from: [&[f64; 8]; 4], to: [&mut [f64; 4]; 8]) {
        let to = to.map(|to| to.as_mut_ptr());
        // SAFETY: the type is named by `with_256` alone; rows have four numbers and columns eight.
        unsafe {
            for rows in [0, 4] {
                turn(from.map(|from| from.as_ptr().add(rows)), std::array::from_fn(|k| to[rows + k]));
            }
        }
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
    fn pick(numbers: &[u32; 8], distance2: &[f64; 8], reach2: f64, from: u32, out: &mut [u32; 8]) -> usize {
        // SAFETY: the type is named by `with_512` alone; every pointer is to eight numbers.
        unsafe {
            let numbers = _mm256_loadu_si256(numbers.as_ptr().cast());
            let near = _mm512_loadu_pd(distance2.as_ptr());
            let near = _mm512_cmp_pd_mask::<_CMP_LT_OQ>(near, _mm512_set1_pd(reach2));
            let after = _mm256_cmpge_epu32_mask(numbers, _mm256_set1_epi32(from.cast_signed()));
            let picked = _mm256_maskz_compress_epi32(near & after, numbers);
            _mm256_storeu_si256(out.as_mut_ptr().cast(), picked);
            (near & after).count_ones() as usize
        }
    }

    #[inline(always)]
    fn rows(from: [&[f64; 8]; 4], to: [&mut [f64; 4]; 8]) {
        // SAFETY: the type is named by `with_512` alone; rows have four numbers and columns eight.
        unsafe {
            let turned = fours(from.map(|from| _mm512_loadu_pd(from.as_ptr())));
            let [a, b, c, d, e, f, g, h] = to;
            for (both, (low, high)) in turned.into_iter().zip([(a, e), (b, f), (c, g), (d, h)]) {
                _mm256_storeu_pd(low.as_mut_ptr(), _mm512_castpd512_pd256(both));
                _mm256_storeu_pd(high.as_mut_ptr(), _mm512_extractf64x4_pd::<1>(both));
            }
        }
    }
}

/// Turns the four by four numbers of each half of four vectors.
#[inline]
#[target_feature(enable = "avx512f")]
fn fours([a, b, c, d]: [__m512d; 4]) -> [__m512d; 4] {
    let (low, high) = (_mm512_unpacklo_pd(a, b), _mm512_unpackhi_pd(a, b));
    let (low_2, high_2) = (_mm512_unpacklo_pd(c, d), _mm512_unpackhi_pd(c, d));
    let first = _mm512_setr_epi64(0, 1, 8, 9, 4, 5, 12, 13);
    let second = _mm512_setr_epi64(2, 3, 10, 11, 6, 7, 14, 15);
    [
        _mm512_permutex2var_pd(low, first, low_2),
        _mm512_permutex2var_pd(high, first, high_2),
        _mm512_permutex2var_pd(low, second, low_2),
        _mm512_permutex2var_pd(high, second, high_2),
    ]
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
