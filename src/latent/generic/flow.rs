//! Matrix of a step, with what effects and the law of flow make of friction.

use super::newton::Square;
use super::{FrictionLaw, Latent, Operators};

/// (L - D1 - c e_v e_v^T), D1 and f e_v of one step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Flow {
    pub(super) matrix: Square,
    pub(super) friction: Square,
    pub(super) pull: Latent,
}

impl Flow {
    /// L - D of a step without effects.
    pub(super) fn plain(operators: &Operators) -> Self {
        Self { matrix: *operators.difference(), friction: operators.friction, pull: Latent::zeros() }
    }

    /// The matrix with phi D1 in the place of D1, under `law` at the mean gradient `gradient` of H.
    pub(super) fn under(&self, law: &FrictionLaw, operators: &Operators, gradient: &Latent) -> Square {
        let p = gradient.dot(&(operators.friction * gradient));
        self.matrix - self.friction * (law.factor(p) - 1.0)
    }

    /// The slope of `under(...) gradient` in the gradient.
    pub(super) fn slope_under(&self, law: &FrictionLaw, operators: &Operators, gradient: &Latent) -> Square {
        let rubs = operators.friction * gradient;
        let thins = (self.friction * gradient) * rubs.transpose() * (2.0 * law.slope(gradient.dot(&rubs)));
        self.under(law, operators, gradient) - thins
    }
}
