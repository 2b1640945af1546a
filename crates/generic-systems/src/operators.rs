//! Learnt parts of L and of friction: a perceptron of the features of the energy, tanh after either hidden layer.
//!
//! ```text
//! (l, c) = V3 tanh(V2 tanh(V1 f + c1) + c2) + c3         f halfway along the step
//! ```

use super::form::Form;
use nalgebra::{DMatrix, DVector};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Cells of a hidden layer.
const CELLS: usize = 16;

/// The perceptron.
#[derive(Clone, Debug)]
pub(super) struct Operators {
    layers: [(DMatrix<f64>, DVector<f64>); 3],
}

/// Output at one state, with the hidden layers.
pub(super) struct Said {
    hidden: [DVector<f64>; 2],
    /// l and c.
    pub(super) numbers: DVector<f64>,
}

impl Operators {
    /// Names and shapes of the weights, in their order, for `outputs` numbers.
    pub(super) fn shapes(form: &Form, outputs: usize) -> [(&'static str, usize, usize); 6] {
        [
            ("LC.V1", CELLS, form.seen()),
            ("LC.c1", 1, CELLS),
            ("LC.V2", CELLS, CELLS),
            ("LC.c2", 1, CELLS),
            ("LC.V3", outputs, CELLS),
            ("LC.c3", 1, outputs),
        ]
    }

    /// Weights to start from; `first` is what it says at first, nearly everywhere.
    pub(super) fn fresh(form: &Form, first: &[f64], rng: &mut ChaCha8Rng) -> Vec<f64> {
        let mut even = |count: usize, bound: f64| -> Vec<f64> {
            (0..count).map(|_| bound * (2.0 * rng.random::<f64>() - 1.0)).collect()
        };
        let [a, b] = [form.seen(), CELLS].map(|inputs| 1.0 / (inputs as f64).sqrt());
        let mut all = even(CELLS * form.seen(), 1.7 * a);
        all.extend(even(CELLS, 1.0));
        all.extend(even(CELLS * CELLS, 1.7 * b));
        all.extend(even(CELLS, 0.3));
        all.extend(even(first.len() * CELLS, 0.03 * b));
        all.extend(first);
        all
    }

    /// From the weights `w`.
    pub(super) fn new(form: &Form, outputs: usize, w: &[f64]) -> Self {
        let mut rest = w;
        let mut take = |count: usize| {
            let (own, others) = rest.split_at(count);
            rest = others;
            own
        };
        let mut layer = |rows: usize, columns: usize| {
            let weights = DMatrix::from_row_slice(rows, columns, take(rows * columns));
            (weights, DVector::from_column_slice(take(rows)))
        };
        Self { layers: [layer(CELLS, form.seen()), layer(CELLS, CELLS), layer(outputs, CELLS)] }
    }

    /// l and c at `f`.
    pub(super) fn say(&self, f: &DVector<f64>) -> Said {
        let [one, two, three] = &self.layers;
        let first = (&one.0 * f + &one.1).map(f64::tanh);
        let second = (&two.0 * &first + &two.1).map(f64::tanh);
        Said { numbers: &three.0 * &second + &three.1, hidden: [first, second] }
    }

    /// Adds to `out` what g . (l, c) at `f` rises by with every weight.
    pub(super) fn pull(&self, f: &DVector<f64>, said: &Said, g: &DVector<f64>, out: &mut [f64]) {
        let [_, two, three] = &self.layers;
        let [first, second] = &said.hidden;
        let back = |w: &DMatrix<f64>, g: &DVector<f64>, t: &DVector<f64>| {
            w.tr_mul(g).zip_map(t, |b, t| b * (1.0 - t * t))
        };
        let at_second = back(&three.0, g, second);
        let at_first = back(&two.0, &at_second, first);
        let mut rest = out;
        for (g, x) in [(&at_first, f), (&at_second, first), (g, second)] {
            let (own, others) = std::mem::take(&mut rest).split_at_mut(g.len() * (x.len() + 1));
            let (weights, bias) = own.split_at_mut(g.len() * x.len());
            for ((row, b), g) in weights.chunks_exact_mut(x.len()).zip(bias).zip(g) {
                row.iter_mut().zip(x).for_each(|(o, x)| *o += g * x);
                *b += g;
            }
            rest = others;
        }
    }
}
