//! A friction law in burn tensors, many states at once.

use crate::operators::friction_law::LEAST_FLOOR;
use crate::operators::precondition::LEVELS;
use burn::tensor::Tensor;
use burn::tensor::activation::sigmoid;
use meniscus::units::FRAME_INTERVAL_S;

/// A friction law as tensors.
#[derive(Clone)]
pub(super) struct LawTensors {
    /// dt D.
    pub(super) friction: Tensor<2>,
    /// 1/p1 `[1, 1]`, in the unit of `friction`.
    inverse_typical: Tensor<2>,
    /// e^2 `[1, 1]`.
    floor_square: Tensor<2>,
    /// y `[1, 1]`.
    yield_share: Tensor<2>,
    /// (n - 1)/2 `[1, 1]`.
    power: Tensor<2>,
}

impl LawTensors {
    /// From the numbers `[1, 4]` of [`super::friction_law::free`] and dt D.
    pub(super) fn new(numbers: &Tensor<2>, friction: Tensor<2>) -> Self {
        let number = |k: usize| numbers.clone().narrow(1, k, 1);
        Self {
            friction,
            inverse_typical: number(0).neg().exp() * FRAME_INTERVAL_S.recip() as f32,
            floor_square: (number(1).exp() + LEAST_FLOOR as f32).square(),
            yield_share: sigmoid(number(2)),
            power: sigmoid(number(3)) - 0.5,
        }
    }

    /// The same numbers with no graph behind them.
    pub(super) fn frozen(&self) -> Self {
        let bare = |tensor: &Tensor<2>| tensor.clone().inner();
        Self {
            friction: bare(&self.friction),
            inverse_typical: bare(&self.inverse_typical),
            floor_square: bare(&self.floor_square),
            yield_share: bare(&self.yield_share),
            power: bare(&self.power),
        }
    }

    /// phi of every row `[batch, 1]` for `rubs` = dt D dH and `gradient` = dH.
    pub(super) fn factor(&self, rubs: Tensor<2>, gradient: Tensor<2>) -> Tensor<2> {
        let p = (rubs * gradient).sum_dim(1);
        let square = p.matmul(self.inverse_typical.clone()) + self.floor_square.clone();
        let thins = square.clone().log().matmul(self.power.clone()).exp();
        let shear = self.yield_share.clone() * -1.0 + 1.0;
        thins.matmul(shear) + square.sqrt().recip().matmul(self.yield_share.clone())
    }
}

/// Returns how near phi of every row `[batch, 1]` is to each of [`LEVELS`] on a logarithmic scale: 1 at the level, 0 from the next one on.
/// Beyond the last level it counts as the last.
pub(super) fn nearness(factor: Tensor<2>) -> [Tensor<2>; LEVELS.len()] {
    let level = |of: f64| of.ln() as f32;
    let apart = level(LEVELS[1] / LEVELS[0]);
    let place = factor.log().clamp(level(LEVELS[0]), level(LEVELS[LEVELS.len() - 1]));
    LEVELS.map(|at| ((place.clone() - level(at)).abs() * -apart.recip() + 1.0).clamp_min(0.0))
}
