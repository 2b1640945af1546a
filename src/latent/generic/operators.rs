//! The operators L (skew) and D = C C^T (positive semidefinite), built from triangles so that no
//! blob can hold anything else.

use super::newton::Square;

/// L and D of a model.
///
/// ```
/// use meniscus::latent::generic::Operators;
///
/// let operators = Operators::from_triangles(&[0.5], &[2.0]);
/// // L is skew, D = C C^T.
/// assert_eq!((operators.skew[(1, 0)], operators.skew[(0, 1)]), (0.5, -0.5));
/// assert_eq!(operators.friction[(0, 0)], 4.0);
/// assert_eq!(operators.difference()[(0, 0)], -4.0);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Operators {
    /// L = -L^T: reversible motion.
    pub skew: Square,
    /// D = C C^T: friction.
    pub friction: Square,
    /// C.
    pub(super) factor: Square,
    /// L - D, what the step applies.
    difference: Square,
}

impl Operators {
    /// From the strict lower triangle of L (78 numbers) and the lower triangle of C (91 numbers),
    /// rows first; numbers that are missing count as zero.
    #[must_use]
    pub fn from_triangles(skew_lower: &[f32], friction_factor: &[f32]) -> Self {
        let strict = triangle(skew_lower, 1);
        let c = triangle(friction_factor, 0);
        let skew = strict - strict.transpose();
        let friction = c * c.transpose();
        Self { skew, friction, factor: c, difference: skew - friction }
    }

    /// L - D.
    #[must_use]
    pub fn difference(&self) -> &Square {
        &self.difference
    }
}

/// The lower triangular matrix whose entries on and below sub-diagonal `below` are `entries`, rows first.
fn triangle(entries: &[f32], below: usize) -> Square {
    let mut square = Square::zeros();
    let mut entries = entries.iter();
    for (i, mut row) in square.row_iter_mut().enumerate() {
        let count = (i + 1).saturating_sub(below);
        for (slot, entry) in row.iter_mut().take(count).zip(&mut entries) {
            *slot = f64::from(*entry);
        }
    }
    square
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::latent::generic::{LATENTS, Latent};
    use nalgebra::{DMatrix, SymmetricEigen};

    /// A deterministic set of triangles without structure.
    fn operators() -> Operators {
        let number = |k: usize| ((k * 7919 % 104_729) as f32 / 104_729.0) - 0.5;
        let skew: heapless::Vec<f32, 78> = (0..78).map(number).collect();
        let factor: heapless::Vec<f32, 91> = (100..191).map(number).collect();
        Operators::from_triangles(&skew, &factor)
    }

    #[test]
    fn skew_is_skew_and_friction_is_positive() {
        let operators = operators();
        assert_eq!(operators.skew, -operators.skew.transpose());
        assert_eq!(operators.friction, operators.friction.transpose());
        let least = SymmetricEigen::new(operators.friction).eigenvalues.min();
        assert!(least > -1e-12, "least eigenvalue of D: {least}");
        assert_eq!(operators.skew[(2, 1)], f64::from((2 * 7919) as f32 / 104_729.0 - 0.5));
    }

    /// The degeneracy that the paper only penalises: here it is an identity.
    #[test]
    fn full_operators_are_degenerate() {
        let operators = operators();
        let g = Latent::from_fn(|i, _| libm::sin(3.0 * i as f64 + 1.0));
        let d = &operators.friction;
        let dg = d * g;
        let mut m_full = DMatrix::zeros(LATENTS + 1, LATENTS + 1);
        m_full.view_mut((0, 0), (LATENTS, LATENTS)).copy_from(d);
        m_full.view_mut((0, LATENTS), (LATENTS, 1)).copy_from(&-dg);
        m_full.view_mut((LATENTS, 0), (1, LATENTS)).copy_from(&-dg.transpose());
        m_full[(LATENTS, LATENTS)] = g.dot(&dg);
        let mut l_full = DMatrix::zeros(LATENTS + 1, LATENTS + 1);
        l_full.view_mut((0, 0), (LATENTS, LATENTS)).copy_from(&operators.skew);
        let grad_e = nalgebra::DVector::from_iterator(LATENTS + 1, g.iter().copied().chain([1.0]));
        let mut grad_s = nalgebra::DVector::zeros(LATENTS + 1);
        grad_s[LATENTS] = 1.0;
        assert!((m_full * grad_e).amax() < 1e-14);
        assert_eq!((l_full * grad_s).amax(), 0.0);
    }
}
