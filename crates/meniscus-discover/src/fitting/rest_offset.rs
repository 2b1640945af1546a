//! Constant offsets that a fit leaves at rest.

use super::fit::Fitted;
use super::problem::Problem;
use crate::recordings::record::Quantity;
use nalgebra::DVector;
use std::collections::BTreeMap;

/// Constant that a fit leaves of one channel.
#[derive(Clone, Copy, Debug)]
pub struct Offset {
    /// Channel.
    pub quantity: Quantity,
    /// Offset, m.
    pub m: f64,
    /// Square of the offset in units of its variance.
    pub square: f64,
}

/// Constant offset of one channel that a fit leaves and clean glasses do not show.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RestOffset {
    /// Channel.
    pub quantity: Quantity,
    /// Offset, m.
    pub m: f64,
}

/// Returns the constants that `fitted` leaves of level, slope and bow in all recordings together.
///
/// With the whitened residual r and the whitened constant u, `d = u.r/u.u` and `d^2/var d = (u.r)^2/u.u`. The misfit
/// hides such a constant: an offset of twelve deviations raises the mean square of 1600 numbers by a tenth.
#[must_use]
pub fn rest_offsets(problem: &Problem, fitted: &Fitted) -> Vec<Offset> {
    let mut sums: BTreeMap<Quantity, [f64; 2]> = BTreeMap::new();
    let mut begun = 0;
    for ready in &problem.ready {
        let mut local = 0;
        for whiten in &ready.whiten {
            let n = whiten.nrows();
            let u = whiten * DVector::from_element(n, 1.0);
            let sum = sums.entry(ready.record.channels[ready.index[local].0].quantity).or_default();
            sum[0] += u.dot(&fitted.residual.rows(begun + local, n));
            sum[1] += u.norm_squared();
            local += n;
        }
        begun += local;
    }
    let one = |quantity: Quantity| {
        let [along, square] = *sums.get(&quantity)?;
        Some(Offset { quantity, m: along / square, square: along * along / square })
    };
    [Quantity::Level, Quantity::Slope, Quantity::Bow].into_iter().filter_map(one).collect()
}
