//! Quadratic least squares with lower bounds, by an active set.
//!
//! ```text
//! q(x) = x^T A x/2 - b^T x  ->  least,      x_i >= l_i
//! (A x - b)_i = 0  where x_i > l_i,         (A x - b)_i >= 0  where x_i = l_i        (Karush, Kuhn, Tucker)
//! ```
//! (Lawson and Hanson 1974, chapter 23, with bounds other than zero and unknowns without one.) A number on its bound is
//! set free where that lowers q; on the way to the least of the free ones the first bound that is met holds its number.

use nalgebra::{DMatrix, DVector};

/// Rounds for each unknown; an active set that is not cycling needs one or two.
const ROUNDS: usize = 12;

/// Slope of q, relative to the largest entry of b, that counts as none.
const FLAT: f64 = 1e-11;

/// Returns the least of `x^T A x/2 - b^T x` with `x_i >= least_i`; minus infinity is no bound.
///
/// None where `a` is not positive definite on the free unknowns, or the rounds do not suffice.
///
/// ```
/// use meniscus_numerics::least_squares::bounded;
/// use nalgebra::{dmatrix, dvector};
///
/// // Without bounds the least lies at (3, -1); with x_1 >= 0 it moves along x_0 too.
/// let (a, b) = (dmatrix![2.0, 1.0; 1.0, 2.0], dvector![5.0, 1.0]);
/// let x = bounded(&a, &b, &[f64::NEG_INFINITY, 0.0]).unwrap();
/// assert!((x - dvector![2.5, 0.0]).norm() < 1e-12);
/// ```
#[must_use]
pub fn bounded(a: &DMatrix<f64>, b: &DVector<f64>, least: &[f64]) -> Option<DVector<f64>> {
    let count = b.len();
    let mut free: Vec<bool> = least.iter().map(|l| *l == f64::NEG_INFINITY).collect();
    let mut x = DVector::from_iterator(count, least.iter().map(|l| if l.is_finite() { *l } else { 0.0 }));
    let flat = FLAT * b.amax().max(f64::MIN_POSITIVE);
    for _ in 0..ROUNDS * count.max(1) {
        let aim = least_of_free(a, b, &x, &free)?;
        // The bound that is met first on the way from x to the aim.
        let met = (0..count).filter(|i| free[*i] && aim[*i] < least[*i]);
        let part = |i: usize| (x[i] - least[i]) / (x[i] - aim[i]);
        if let Some(first) = met.min_by(|i, j| part(*i).total_cmp(&part(*j))) {
            let way = part(first).clamp(0.0, 1.0);
            x += (&aim - &x) * way;
            (x[first], free[first]) = (least[first], false);
            continue;
        }
        x = aim;
        let slope = b - a * &x;
        let steepest = (0..count).filter(|i| !free[*i]).max_by(|i, j| slope[*i].total_cmp(&slope[*j]));
        match steepest.filter(|i| slope[*i] > flat) {
            Some(released) => free[released] = true,
            None => return Some(x),
        }
    }
    None
}

/// Returns `x` with its `free` numbers at the least of q, the others where they are.
fn least_of_free(
    a: &DMatrix<f64>,
    b: &DVector<f64>,
    x: &DVector<f64>,
    free: &[bool],
) -> Option<DVector<f64>> {
    let places: Vec<usize> = (0..free.len()).filter(|i| free[*i]).collect();
    let held = DVector::from_fn(x.len(), |i, _| if free[i] { 0.0 } else { x[i] });
    let pull = b - a * held;
    let square = DMatrix::from_fn(places.len(), places.len(), |i, j| a[(places[i], places[j])]);
    let right = DVector::from_fn(places.len(), |i, _| pull[places[i]]);
    let solved = square.cholesky()?.solve(&right);
    let mut out = x.clone();
    places.iter().zip(solved.iter()).for_each(|(place, value)| out[*place] = *value);
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::normal;
    use rand::SeedableRng;

    #[test]
    fn the_conditions_of_a_least_hold_for_random_problems() {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(11);
        let mut on_bound = 0;
        for size in [1, 2, 5, 12, 20] {
            for _ in 0..40 {
                let root = DMatrix::from_fn(size + 3, size, |_, _| normal(&mut random));
                let a = root.transpose() * &root;
                let b = DVector::from_fn(size, |_, _| 3.0 * normal(&mut random));
                let least: Vec<f64> =
                    (0..size).map(|i| if i % 3 == 0 { f64::NEG_INFINITY } else { 0.1 * i as f64 }).collect();
                let x = bounded(&a, &b, &least).expect("definite");
                let slope = &a * &x - &b;
                for i in 0..size {
                    assert!(x[i] >= least[i]);
                    if x[i] > least[i] + 1e-9 {
                        assert!(slope[i].abs() < 1e-7, "{} of {size}: {}", i, slope[i]);
                    } else {
                        on_bound += 1;
                        assert!(slope[i] > -1e-7, "{} of {size}: {}", i, slope[i]);
                    }
                }
            }
        }
        assert!(on_bound > 100, "the bounds matter: {on_bound}");
    }

    #[test]
    fn a_matrix_that_is_not_definite_has_no_least() {
        let a = DMatrix::from_diagonal(&DVector::from_vec(vec![1.0, -1.0]));
        let b = DVector::from_vec(vec![1.0, 1.0]);
        assert_eq!(bounded(&a, &b, &[f64::NEG_INFINITY; 2]), None);
    }
}
