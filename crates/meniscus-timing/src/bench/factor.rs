//! The last layer of each decoder in two of lower rank, chosen by an error budget.
//!
//! ```text
//! W h + b = (W P) (P^T (h - m)) + (W m + b) + what is left
//! ```
//! m is the mean and P the first r principal directions of h over the windows, weighted by W^T W: of the field's
//! variance nothing more is kept by any other r directions. r is the smallest rank whose largest error on windows
//! that P has not seen stays within the budget times the range of the group.

use super::chain::Chain;
use super::networks::{Layer, Networks};
use nalgebra::{DMatrix, SymmetricEigen};

/// Windows that the directions are found on, and those that the rank is chosen by.
const WINDOWS: (usize, usize) = (400, 100);

/// `networks` with factored last layers, and the ranks and largest errors (as a share of the range) of the groups.
#[must_use]
pub fn factored(networks: &Networks, chain: &Chain<'_>, budget: f64) -> (Networks, Vec<(usize, f64)>) {
    let (found, held) = WINDOWS;
    let latents: Vec<[f32; 13]> =
        (0..found + held).map(|k| chain.step(&chain.encode(&Networks::window(k)))).collect();
    let mut networks = networks.clone();
    let mut ranks = Vec::new();
    for (group, decoder) in networks.decoders.iter_mut().enumerate() {
        let Some(last) = decoder.pop() else { continue };
        let h = DMatrix::from_columns(
            &latents
                .iter()
                .map(|x| {
                    let h = chain.last_input(group, x);
                    nalgebra::DVector::from_iterator(
                        last.columns,
                        h.iter().take(last.columns).map(|h| f64::from(*h)),
                    )
                })
                .collect::<Vec<_>>(),
        );
        let (inner, outer, rank) = factor(&last, &h, found, budget);
        ranks.push(rank);
        decoder.push(inner);
        decoder.push(outer);
    }
    (networks, ranks)
}

/// Returns `networks` with last layers of the given ranks, as training has found them for a liquid. The numbers in the
/// layers are made up: this is for the time that they take, and says nothing of an error.
#[must_use]
pub fn of_ranks(networks: &Networks, ranks: [usize; 5]) -> Networks {
    let mut networks = networks.clone();
    for (decoder, rank) in networks.decoders.iter_mut().zip(ranks) {
        let Some(last) = decoder.pop() else { continue };
        let number = |count: usize| (0..count).map(|at| 0.01 * ((at % 17) as f32 - 8.0)).collect();
        let layer = |part: &str, rows: usize, columns: usize, bias: Vec<f32>| Layer {
            name: format!("{}.{part}", last.name),
            rows,
            columns,
            weights: number(rows * columns),
            bias,
            relu: false,
        };
        decoder.push(layer("inner", rank, last.columns, vec![0.0; rank]));
        decoder.push(layer("outer", last.rows, rank, last.bias.clone()));
    }
    networks
}

/// The two layers in place of `last`, with their rank and largest error.
fn factor(last: &Layer, h: &DMatrix<f64>, found: usize, budget: f64) -> (Layer, Layer, (usize, f64)) {
    let k = last.columns;
    let w = DMatrix::from_row_iterator(last.rows, k, last.weights.iter().map(|w| f64::from(*w)));
    let mean = h.columns(0, found).column_mean();
    let mut centred = h.clone();
    centred.column_iter_mut().for_each(|mut column| column -= &mean);
    // The field's norm: |W h|^2 = h^T G h, G = U diag(d) U^T.
    let gram = SymmetricEigen::new(w.tr_mul(&w));
    let root = gram.eigenvalues.map(|d| d.max(0.0).sqrt());
    let inverse = root.map(|d| if d > 1e-9 { 1.0 / d } else { 0.0 });
    let to_norm = DMatrix::from_diagonal(&root) * gram.eigenvectors.transpose();
    let from_norm = &gram.eigenvectors * DMatrix::from_diagonal(&inverse);
    let z = &to_norm * &centred;
    let seen = z.columns(0, found);
    let spread = SymmetricEigen::new(seen * seen.transpose());
    let mut order: Vec<usize> = (0..k).collect();
    order.sort_by(|a, b| spread.eigenvalues[*b].total_cmp(&spread.eigenvalues[*a]));

    let held = z.columns(found, z.ncols() - found).into_owned();
    let directions = &w * &from_norm;
    let mut rest = &directions * &held;
    let range = {
        let field = &w * h;
        field.max() - field.min()
    };
    let (mut rank, mut error) = (0, rest.amax() / range);
    for &index in &order {
        if error <= budget {
            break;
        }
        let p = spread.eigenvectors.column(index);
        rest -= (&directions * p) * (p.transpose() * &held);
        (rank, error) = (rank + 1, rest.amax() / range);
    }
    let p = DMatrix::from_fn(k, rank.max(1), |i, j| spread.eigenvectors[(i, order[j])]);
    let inward = p.transpose() * &to_norm;
    let outward = &directions * &p;
    let shift = &inward * &mean;
    let base = &w * &mean;
    let layer = |part: &str, m: &DMatrix<f64>, bias: Vec<f32>| Layer {
        name: format!("{}.{part}", last.name),
        rows: m.nrows(),
        columns: m.ncols(),
        weights: m.transpose().iter().map(|w| *w as f32).collect(),
        bias,
        relu: false,
    };
    let inner = layer("inner", &inward, shift.iter().map(|s| -*s as f32).collect());
    let bias = last.bias.iter().zip(base.iter()).map(|(b, m)| (f64::from(*b) + m) as f32).collect();
    (inner, layer("outer", &outward, bias), (rank, error))
}
