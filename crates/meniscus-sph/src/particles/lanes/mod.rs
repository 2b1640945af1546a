//! Eight numbers at a time: turning rows into columns and back, as the processor's vectors do it.
//!
//! The numbers of a neighbour lie side by side (a row), and a formula runs down the neighbours (a column). Turning eight
//! rows of eight numbers into columns takes 24 instructions in single precision, and 128 where there are no wide vectors. It moves
//! numbers and computes none, so that every width gives the same bits.
#![allow(
    unsafe_code,
    reason = "vector instructions may only run where the processor has them, which `widest` asks"
)]

#[cfg(target_arch = "x86_64")]
mod x86;

use super::state::Particle;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// Number that rows and columns are made of: `f64`, or `f32` in the sums over pairs.
pub(crate) trait Lane:
    Copy
    + Default
    + Send
    + Sync
    + Into<f64>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
{
    /// Rounds a number in double precision.
    fn of(x: f64) -> Self;

    /// Returns the square root.
    fn root(self) -> Self;

    /// Returns the number, and 0 where it is negative.
    fn positive(self) -> Self;

    /// Turns eight rows into columns with the vectors of `W`: `to[c][k] = from[k][c]`.
    fn transpose<W: Width>(from: [&[Self; 8]; 8], to: [&mut [Self; 8]; 8]);
}

/// Implements [`Lane`] for a number, which [`Width`] turns by the function of that name.
macro_rules! lane {
    ($number:ty, $transpose:ident) => {
        impl Lane for $number {
            #[inline(always)]
            fn of(x: f64) -> Self {
                x as Self
            }

            #[inline(always)]
            fn root(self) -> Self {
                self.sqrt()
            }

            #[inline(always)]
            fn positive(self) -> Self {
                self.max(0.0)
            }

            #[inline(always)]
            fn transpose<W: Width>(from: [&[Self; 8]; 8], to: [&mut [Self; 8]; 8]) {
                W::$transpose(from, to);
            }
        }
    };
}

lane!(f64, transpose);
lane!(f32, transpose_single);

/// A row of `N` numbers, of which eight in single precision are half a cache line.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(32))]
pub(crate) struct Row<const N: usize, T = f64>(pub(crate) [T; N]);

/// A row in single precision.
pub(crate) type Single<const N: usize> = Row<N, f32>;

/// A row of nothing but zeros.
impl<const N: usize, T: Lane> Default for Row<N, T> {
    fn default() -> Self {
        Self([T::default(); N])
    }
}

impl<const N: usize> Single<N> {
    /// Rounds a row.
    #[inline(always)]
    pub(crate) fn of(numbers: [f64; N]) -> Self {
        Self(numbers.map(f32::of))
    }
}

impl<const N: usize, T: Lane> Row<N, T> {
    /// Adds `numbers`, from the first on.
    #[inline(always)]
    pub(crate) fn give<const M: usize>(&mut self, numbers: [T; M]) {
        const { assert!(M <= N) };
        for (to, x) in self.0.iter_mut().zip(numbers) {
            *to += x;
        }
    }
}

/// A row of four numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(16))]
pub(crate) struct Quad(pub(crate) [f32; 4]);

impl Quad {
    /// Rounds a vector.
    #[inline(always)]
    pub(crate) fn of(v: &[f64; 3]) -> Self {
        Self([f32::of(v[0]), f32::of(v[1]), f32::of(v[2]), 0.0])
    }
}

/// Returns a particle as a row: position (3), velocity (3), volume, and `last`.
#[inline(always)]
pub(crate) fn row(p: &Particle, last: f64) -> Single<8> {
    let ([x, y, z], [u, v, w]) = (p.x, p.v);
    Row::of([x, y, z, u, v, w, p.volume, last])
}

/// Eight points that may be near to another.
pub(crate) struct Eight<'a> {
    /// Their numbers.
    pub(crate) numbers: &'a [u32; 8],
    /// Squares of their distances, m2.
    pub(crate) distance2: &'a [f64; 8],
    /// Number of those that count; what is behind them does not.
    pub(crate) first: usize,
}

/// The vectors that a piece of work is compiled for.
pub(crate) trait Width {
    /// Turns eight rows into columns: `to[c][k] = from[k][c]`.
    fn transpose(from: [&[f64; 8]; 8], to: [&mut [f64; 8]; 8]);

    /// Turns eight rows in single precision into columns: `to[c][k] = from[k][c]`.
    fn transpose_single(from: [&[f32; 8]; 8], to: [&mut [f32; 8]; 8]);

    /// Puts those of `eight` to the front of `out` whose distance squared is below `reach2` and whose numbers are not below `from`; returns
    /// how many there are.
    fn pick(eight: &Eight<'_>, reach2: f64, from: u32, out: &mut [u32; 8]) -> usize;

    /// Turns eight rows of four numbers into columns: `to[c][k] = from[k][c]`.
    fn columns(from: [&[f32; 4]; 8], to: [&mut [f32; 8]; 4]);

    /// Turns four columns into rows: `to[k][c] = from[c][k]`.
    fn rows(from: [&[f32; 8]; 4], to: [&mut [f32; 4]; 8]);
}

/// Those that every processor has.
pub(crate) struct Narrow;

impl Width for Narrow {
    #[inline(always)]
    fn transpose(from: [&[f64; 8]; 8], to: [&mut [f64; 8]; 8]) {
        plain(from, to);
    }

    #[inline(always)]
    fn transpose_single(from: [&[f32; 8]; 8], to: [&mut [f32; 8]; 8]) {
        plain(from, to);
    }

    #[inline(always)]
    fn pick(eight: &Eight<'_>, reach2: f64, from: u32, out: &mut [u32; 8]) -> usize {
        plain_pick(eight, reach2, from, out)
    }

    #[inline(always)]
    fn columns(from: [&[f32; 4]; 8], to: [&mut [f32; 8]; 4]) {
        plain(from, to);
    }

    #[inline(always)]
    fn rows(from: [&[f32; 8]; 4], to: [&mut [f32; 4]; 8]) {
        plain(from, to);
    }
}

/// Turns rows into columns, or columns into rows, one number after the other.
#[inline(always)]
fn plain<T: Copy, const M: usize, const N: usize>(from: [&[T; M]; N], to: [&mut [T; N]; M]) {
    for (c, to) in to.into_iter().enumerate() {
        for (to, from) in to.iter_mut().zip(from) {
            *to = from[c];
        }
    }
}

/// [`Width::pick`], one number after the other.
#[inline(always)]
fn plain_pick(eight: &Eight<'_>, reach2: f64, from: u32, out: &mut [u32; 8]) -> usize {
    let mut count = 0;
    for (number, d2) in eight.numbers.iter().zip(eight.distance2).take(eight.first) {
        out[count.min(7)] = *number;
        count += usize::from(*d2 < reach2 && *number >= from);
    }
    count
}

/// A piece of work that gains from wide vectors. `run` has to be `#[inline(always)]`, and so has all that it calls, or it is
/// compiled for narrow vectors alone.
pub(crate) trait Work {
    /// Does the work with the vectors of `W`.
    fn run<W: Width>(self);
}

/// Widest vectors that a test allows, bits. All give the same bits, so that it does not disturb other tests.
#[cfg(test)]
pub(crate) static MOST: std::sync::atomic::AtomicU32 = std::sync::atomic::AtomicU32::new(512);

/// Whether vectors of so many `bits` may be used, as far as tests are concerned.
#[inline(always)]
#[cfg_attr(not(target_arch = "x86_64"), expect(dead_code, reason = "there is one width"))]
fn allowed(bits: u32) -> bool {
    #[cfg(test)]
    return bits <= MOST.load(std::sync::atomic::Ordering::Relaxed);
    #[cfg(not(test))]
    return bits <= 512;
}

/// Whether the processor has all that work for vectors of 512 bits is compiled for.
#[cfg(target_arch = "x86_64")]
fn has_512() -> bool {
    use std::arch::is_x86_feature_detected;
    is_x86_feature_detected!("avx512f")
        && is_x86_feature_detected!("avx512vl")
        && is_x86_feature_detected!("avx2")
        && is_x86_feature_detected!("popcnt")
}

/// Does `work` with the widest vectors of this processor that the program allows.
#[inline]
pub(crate) fn widest(work: impl Work) {
    #[cfg(target_arch = "x86_64")]
    if meniscus::latent::nn::is_wide() && allowed(256) {
        if has_512() && allowed(512) {
            // SAFETY: checked on the line above.
            return unsafe { x86::with_512(work) };
        }
        // SAFETY: whoever allowed wide vectors promised that AVX2 is there.
        return unsafe { x86::with_256(work) };
    }
    work.run::<Narrow>();
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Turns and picks numbers.
    struct Turn<'a>(&'a mut Vec<f64>);

    impl Work for Turn<'_> {
        #[inline(always)]
        fn run<W: Width>(self) {
            let rows: [[f64; 8]; 8] = std::array::from_fn(|k| std::array::from_fn(|c| (10 * k + c) as f64));
            let mut columns = [[0.0; 8]; 8];
            W::transpose(rows.each_ref(), columns.each_mut());
            self.0.extend(columns.as_flattened());
            let rows: [[f32; 8]; 8] = rows.map(|row| row.map(f32::of));
            let mut columns = [[0.0; 8]; 8];
            W::transpose_single(rows.each_ref(), columns.each_mut());
            self.0.extend(columns.as_flattened().iter().map(|x| f64::from(*x)));
            let columns: [[f32; 8]; 4] =
                std::array::from_fn(|c| std::array::from_fn(|k| (10 * k + c) as f32));
            let mut rows = [[0.0; 4]; 8];
            W::rows(columns.each_ref(), rows.each_mut());
            self.0.extend(rows.as_flattened().iter().map(|x| f64::from(*x)));
            let mut back = [[0.0; 8]; 4];
            W::columns(rows.each_ref(), back.each_mut());
            assert_eq!(back, columns);
            let numbers: [u32; 8] = std::array::from_fn(|k| 5 * k as u32);
            let distance2 = &[3.0, 9.0, 4.0, f64::NAN, 2.0, 5.0, 1.0, 6.0];
            for (from, reach2, first) in [(0, 5.0, 8), (11, 7.0, 9), (0, 100.0, 8), (0, 0.0, 8), (0, 5.0, 3)]
            {
                let mut out = [0; 8];
                let count = W::pick(&Eight { numbers: &numbers, distance2, first }, reach2, from, &mut out);
                self.0.extend(out[..count].iter().map(|j| f64::from(*j)));
            }
        }
    }

    /// Results of every width that this processor has for the same numbers.
    fn of_each() -> Vec<(&'static str, Vec<f64>)> {
        let run = |name, with: &dyn Fn(Turn<'_>)| {
            let mut found = Vec::new();
            with(Turn(&mut found));
            (name, found)
        };
        let mut all = vec![run("narrow", &|turn| turn.run::<Narrow>())];
        #[cfg(target_arch = "x86_64")]
        {
            if std::is_x86_feature_detected!("avx2") {
                // SAFETY: checked on the line above.
                all.push(run("256 bit", &|turn| unsafe { x86::with_256(turn) }));
            }
            if has_512() {
                // SAFETY: checked on the line above.
                all.push(run("512 bit", &|turn| unsafe { x86::with_512(turn) }));
            }
        }
        all
    }

    #[test]
    fn rows_become_columns_and_the_near_are_picked_with_vectors_of_any_width() {
        for (width, found) in of_each() {
            let whole = (0..128).map(|n| (10 * (n % 8) + n % 64 / 8) as f64);
            let halves = (0..32).map(|n| (10 * (n / 4) + n % 4) as f64);
            let near = [&[0, 10, 20, 30][..], &[20, 25, 30, 35], &[0, 5, 10, 20, 25, 30, 35], &[], &[0, 10]]
                .concat();
            let due = whole.chain(halves).chain(near.into_iter().map(f64::from));
            assert_eq!(found, due.collect::<Vec<_>>(), "{width}");
        }
    }
}
