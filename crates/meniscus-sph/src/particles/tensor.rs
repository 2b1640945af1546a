//! Symmetric tensors of second order, as six numbers.

use super::lanes::Lane;

/// A symmetric matrix: xx, xy, xz, yy, yz, zz.
pub(crate) type Symmetric<T = f64> = [T; 6];

/// The unit matrix.
pub(crate) const UNIT: Symmetric = [1.0, 0.0, 0.0, 1.0, 0.0, 1.0];

/// Returns the tensor that the row begins with.
#[inline(always)]
pub(crate) fn first<T: Lane>(row: &[T; 8]) -> Symmetric<T> {
    [row[0], row[1], row[2], row[3], row[4], row[5]]
}

/// Returns `m x`.
#[inline(always)]
pub(crate) fn times<T: Lane>(m: &Symmetric<T>, x: &[T; 3]) -> [T; 3] {
    [
        m[0] * x[0] + m[1] * x[1] + m[2] * x[2],
        m[1] * x[0] + m[3] * x[1] + m[4] * x[2],
        m[2] * x[0] + m[4] * x[1] + m[5] * x[2],
    ]
}

/// Returns `f v (x) x` made symmetric, with its off-diagonal elements twice, as [`trace`] wants it.
#[inline(always)]
pub(crate) fn strain<T: Lane>(f: T, d: &[T; 3], v: &[T; 3]) -> Symmetric<T> {
    let [x, y, z] = [f * d[0], f * d[1], f * d[2]];
    let [u, v, w] = *v;
    [u * x, u * y + v * x, u * z + w * x, v * y, v * z + w * y, w * z]
}

/// Returns `tr(L t)` with `t` of [`strain`].
#[inline(always)]
pub(crate) fn trace<T: Lane>(l: &Symmetric<T>, t: &Symmetric<T>) -> T {
    (l[0] * t[0] + l[1] * t[1] + l[2] * t[2]) + (l[3] * t[3] + l[4] * t[4] + l[5] * t[5])
}

/// Returns `R m R` with `R = 1 - 2 n n^T`: `m` behind a mirror of unit normal `n`.
pub(crate) fn mirrored(m: &Symmetric, n: &[f64; 3]) -> Symmetric {
    let y = times(m, n);
    let along = 2.0 * (n[0] * y[0] + n[1] * y[1] + n[2] * y[2]);
    let taken = |i: usize, j: usize| 2.0 * (n[i] * y[j] + y[i] * n[j] - along * n[i] * n[j]);
    [
        m[0] - taken(0, 0),
        m[1] - taken(0, 1),
        m[2] - taken(0, 2),
        m[3] - taken(1, 1),
        m[4] - taken(1, 2),
        m[5] - taken(2, 2),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_product_and_a_trace_are_those_of_the_full_matrix() {
        let m: Symmetric = [1.0, 0.5, -0.2, 2.0, 0.7, 3.0];
        let product = times(&m, &[1.0, 10.0, 100.0]);
        assert!(product.iter().zip([-14.0, 90.5, 306.8]).all(|(a, b)| (a - b).abs() < 1e-12), "{product:?}");
        // tr(m v d^T) = d . m v
        let (d, v) = ([0.3, -1.0, 2.0], [1.5, 0.25, -0.5]);
        let due: f64 = d.iter().zip(times(&m, &v)).map(|(d, mv)| 2.0 * d * mv).sum();
        assert!((trace(&m, &strain(2.0, &d, &v)) - due).abs() < 1e-14);
    }

    #[test]
    fn a_mirror_at_45_degrees_exchanges_two_axes_and_two_mirrors_none() {
        let half = 0.5_f64.sqrt();
        let m = [1.0, 0.5, -0.2, 2.0, 0.7, 3.0];
        let seen = mirrored(&m, &[half, half, 0.0]);
        let known = [2.0, 0.5, -0.7, 1.0, 0.2, 3.0];
        assert!(seen.iter().zip(known).all(|(a, b)| (a - b).abs() < 1e-12), "{seen:?}");
        let n = [0.6, 0.0, 0.8];
        let back = mirrored(&mirrored(&m, &n), &n);
        assert!(back.iter().zip(m).all(|(a, b)| (a - b).abs() < 1e-12), "{back:?}");
    }
}
