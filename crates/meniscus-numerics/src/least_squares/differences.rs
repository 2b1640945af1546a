//! Derivatives of a residual by forward differences.

use nalgebra::{DMatrix, DVector};

/// Returns the Jacobian `J_ij = (r_i(p + h_j e_j) - r_i(p)) / h_j` of `residual_at` at `parameters`, where `residual` is
/// `r(p)` and `widths` holds the `h_j`, which may be negative and are not zero.
///
/// The error is of first order in `h_j`; a width of about a fiftieth of what a parameter is known to serves a search.
///
/// ```
/// use meniscus_numerics::least_squares::forward_differences;
/// use nalgebra::{DVector, dvector};
///
/// let residual_at = |p: &DVector<f64>| dvector![3.0 * p[0] - p[1]];
/// let p = dvector![1.0, 2.0];
/// let jacobian = forward_differences(&p, &residual_at(&p), &dvector![0.5, -0.25], residual_at);
/// assert_eq!((jacobian[(0, 0)], jacobian[(0, 1)]), (3.0, -1.0));
/// ```
#[must_use]
pub fn forward_differences(
    parameters: &DVector<f64>,
    residual: &DVector<f64>,
    widths: &DVector<f64>,
    mut residual_at: impl FnMut(&DVector<f64>) -> DVector<f64>,
) -> DMatrix<f64> {
    let mut jacobian = DMatrix::zeros(residual.len(), parameters.len());
    for (j, &width) in widths.iter().enumerate() {
        let mut shifted = parameters.clone();
        shifted[j] += width;
        jacobian.set_column(j, &((residual_at(&shifted) - residual) / width));
    }
    jacobian
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dvector;

    #[test]
    fn differences_approach_the_derivatives_with_their_widths() {
        let residual_at = |p: &DVector<f64>| dvector![p[0].exp() * p[1], p[1].sin()];
        let p = dvector![0.3, 1.2];
        let error = |width: f64| {
            let found = forward_differences(&p, &residual_at(&p), &dvector![width, -width], residual_at);
            let exact = nalgebra::dmatrix![1.2 * 0.3_f64.exp(), 0.3_f64.exp(); 0.0, 1.2_f64.cos()];
            (found - exact).norm()
        };
        assert!(error(1e-6) < 2e-6);
        let order = (error(1e-2) / error(1e-3)).log10();
        assert!((order - 1.0).abs() < 0.05, "{order}");
    }
}
