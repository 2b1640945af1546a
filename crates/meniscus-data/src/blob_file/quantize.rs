//! A blob stored coarser: bf16 or i8 weights, and bases of no higher rank than an error budget asks for.
//!
//! The laws are not touched: H, L, D, the port, the preconditioner and the gain keep their f32 bits. What gets
//! coarser is the GRU, the trunk and the bases; the GRU at most bf16, as its errors come back with every frame;
//! the surface's basis and that of e, of a few columns, stay f32, as they weigh nothing.
//!
//! A basis B (numbers x k) with coefficients c = T x + F u + W3 h + b3 is cut to rank r in the field's own norm:
//!
//! ```text
//! B^T B = U diag(d) U^T        z = diag(sqrt d) U^T c        |B c| = |z|
//! sum over frames z z^T = V diag(..) V^T                     P = the first r columns of V
//! B' = B U diag(1 / sqrt d) P                                c' = P^T diag(sqrt d) U^T c
//! ```
//! so that c' takes the place of c in T, F, W3 and b3. r is the smallest rank whose largest error over the frames
//! stays within the budget times the range of the group (largest minus smallest number over the frames).

use crate::blob_file::read::parts;
use crate::blob_file::write::{ExportError, Part, stored};
use crate::recording::GROUP_NAMES;
use meniscus::blob::{LoadError, Model, Tensor};
use meniscus::latent::decoder::{Coefficients, ENERGY_GROUP};
use meniscus::latent::nn::Element;
use meniscus::runtime::Estimate;
use nalgebra::{DMatrix, SymmetricEigen};

/// Groups that have a basis of their own to cut: q, v, sigma, tau.
const CUT: [u8; 4] = [0, 1, 3, 4];

/// Eigenvalues of B^T B below this share of the largest are no direction of the basis.
const SILENT: f64 = 1e-12;

/// Why a model was not quantised.
#[derive(Debug)]
pub enum QuantizeError {
    /// The model is refused.
    Load(LoadError),
    /// The new blob could not be written down.
    Export(ExportError),
    /// The run that the ranks are chosen by has fewer frames with an estimate than a choice needs.
    TooShort(usize),
}

impl std::fmt::Display for QuantizeError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Load(error) => write!(f, "{error}"),
            Self::Export(error) => write!(f, "{error}"),
            Self::TooShort(frames) => write!(
                f,
                "the recording gives {frames} frames with an estimate, and the ranks are chosen by at least 60: \
                 take a longer one"
            ),
        }
    }
}

impl std::error::Error for QuantizeError {}

/// In what each tensor goes when the weights go in `to`.
#[must_use]
pub fn element_of(to: Element, tensor: Tensor) -> Element {
    match (to, tensor) {
        (Element::F32, _) => Element::F32,
        (_, Tensor::GroupBasis(group)) if usize::from(group) == ENERGY_GROUP || group == 5 => Element::F32,
        (Element::I8, Tensor::GruInput(_) | Tensor::GruHidden(_)) => Element::Bf16,
        (to, _) => to,
    }
}

/// Result of a quantisation.
#[derive(Clone, Debug)]
pub struct Quantized {
    /// The blob.
    pub blob: Vec<u8>,
    /// Rank of q, v, e, sigma, tau before and after.
    pub ranks: [(usize, usize); 5],
}

/// `blob` with its weights in `to`; with a `budget` (a share of each group's range) its bases are cut first, by
/// the estimates of a run.
///
/// # Errors
/// [`QuantizeError`].
pub fn quantize(
    blob: &[u8],
    to: Element,
    budget: Option<f64>,
    run: &[Estimate],
) -> Result<Quantized, QuantizeError> {
    let (header, mut all) = parts(blob).map_err(QuantizeError::Load)?;
    let model = Model::load(blob).map_err(QuantizeError::Load)?;
    let before = model.decoder.groups.map(|group| group.basis.columns());
    if let Some(budget) = budget {
        if run.len() < 60 {
            return Err(QuantizeError::TooShort(run.len()));
        }
        let coefficients: Vec<Coefficients> = run
            .iter()
            .map(|estimate| model.decoder.coefficients(&estimate.latent.map(|x| x as f32), estimate.port))
            .collect();
        let mut turned = Vec::new();
        for group in CUT {
            let first = model.decoder.groups[usize::from(group)].first;
            turned.push((first, cut(&mut all, group, first, &coefficients, budget)));
        }
        turn_trunk(&mut all, &turned);
    }
    let blob = stored(header, &all, |tensor| element_of(to, tensor)).map_err(QuantizeError::Export)?;
    let mut ranks = before.map(|rank| (rank, rank));
    for (group, (_, after)) in ranks.iter_mut().enumerate() {
        let tensor = Tensor::GroupBasis(group as u8);
        *after = all.iter().find(|part| part.tensor == tensor).map_or(0, |part| part.columns);
    }
    Ok(Quantized { blob, ranks })
}

/// Cuts the basis of `group` in place; gives the matrix (r x k) that turns its old coefficients into the new.
fn cut(all: &mut [Part], group: u8, first: usize, run: &[Coefficients], budget: f64) -> DMatrix<f64> {
    let place = all.iter_mut().find(|part| part.tensor == Tensor::GroupBasis(group));
    let Some(part) = place else { return DMatrix::zeros(0, 0) };
    let k = part.columns;
    let basis = DMatrix::from_row_iterator(part.rows, k, part.values.iter().map(|v| f64::from(*v)));
    let c = DMatrix::from_fn(k, run.len(), |i, frame| f64::from(run[frame][first + i]));
    let gram = SymmetricEigen::new(basis.tr_mul(&basis));
    let floor = SILENT * gram.eigenvalues.max();
    let root = gram.eigenvalues.map(|d| if d > floor { d.sqrt() } else { 0.0 });
    let inverse = root.map(|d| if d > 0.0 { 1.0 / d } else { 0.0 });
    let to_norm = DMatrix::from_diagonal(&root) * gram.eigenvectors.transpose();
    let from_norm = &gram.eigenvectors * DMatrix::from_diagonal(&inverse);
    let z = &to_norm * &c;
    let spread = SymmetricEigen::new(&z * z.transpose());
    let mut order: Vec<usize> = (0..k).collect();
    order.sort_by(|a, b| spread.eigenvalues[*b].total_cmp(&spread.eigenvalues[*a]));
    // The field of each frame, its range, and what each further direction takes off the error.
    let directions = &basis * &from_norm;
    let mut rest = &basis * &c;
    let limit = budget * (rest.max() - rest.min());
    let mut kept = 0;
    for &index in &order {
        kept += 1;
        let p = spread.eigenvectors.column(index);
        rest -= (&directions * p) * (p.transpose() * &z);
        if rest.amax() <= limit {
            break;
        }
    }
    let p = DMatrix::from_fn(k, kept, |i, j| spread.eigenvectors[(i, order[j])]);
    let turned = &directions * &p;
    part.columns = kept;
    part.values = (0..part.rows * kept).map(|n| turned[(n / kept, n % kept)] as f32).collect();
    p.transpose() * to_norm
}

/// Puts the new coefficients into T, F, W3 and b3. What lies between the cut groups (e) and behind them (the surface) stays.
fn turn_trunk(all: &mut [Part], turned: &[(usize, DMatrix<f64>)]) {
    let tensors = [Tensor::TrunkLinear, Tensor::TrunkPort, Tensor::TrunkWeight(2), Tensor::TrunkBias(2)];
    for part in all.iter_mut().filter(|part| tensors.contains(&part.tensor)) {
        let columns = part.columns;
        let mut values = Vec::new();
        let mut end = 0;
        for (first, turn) in turned {
            values.extend_from_slice(&part.values[end * columns..first * columns]);
            for row in turn.row_iter() {
                for j in 0..columns {
                    let old = |i: usize| f64::from(part.values[(first + i) * columns + j]);
                    values.push(row.iter().enumerate().map(|(i, w)| w * old(i)).sum::<f64>() as f32);
                }
            }
            end = first + turn.ncols();
        }
        values.extend_from_slice(&part.values[end * columns..]);
        part.rows = values.len() / columns;
        part.values = values;
    }
}

/// Error that a coarser model adds to a group.
#[derive(Clone, Copy, Debug, Default)]
pub struct Added {
    /// Root mean square of the difference, as a share of the group's range.
    pub rms: f64,
    /// Largest difference, as a share of the group's range.
    pub most: f64,
}

/// The difference of the fields of two models, group by group, over the same latents, port values and heats: what
/// trunk and bases add, the encoder apart.
#[must_use]
pub fn added(one: &Model<'_>, other: &Model<'_>, run: &[Estimate]) -> [Added; 5] {
    let (mut a, mut b) = (vec![0.0; one.field_len()], vec![0.0; other.field_len()]);
    let mut sums = [(0.0_f64, 0.0_f64, f32::INFINITY, f32::NEG_INFINITY, 0.0_f64); GROUP_NAMES.len()];
    let lengths = one.decoder.groups.map(|group| group.rest.len());
    for estimate in run {
        for (model, field) in [(one, &mut a), (other, &mut b)] {
            let c = model.decoder.coefficients(&estimate.latent.map(|x| x as f32), estimate.port);
            model.decoder.field(&c, estimate.heat_j as f32, field);
        }
        let (mut a, mut b) = (&a[..], &b[..]);
        for ((square, most, low, high, count), length) in sums.iter_mut().zip(lengths) {
            let ((here, left), (there, right)) = (a.split_at(length), b.split_at(length));
            for (x, y) in here.iter().zip(there) {
                let difference = f64::from(x - y).abs();
                *square += difference * difference;
                *most = most.max(difference);
                (*low, *high) = (low.min(*x), high.max(*x));
            }
            *count += length as f64;
            (a, b) = (left, right);
        }
    }
    sums.map(|(square, most, low, high, count)| {
        let range = f64::from(high - low).max(f64::MIN_POSITIVE);
        Added { rms: (square / count.max(1.0)).sqrt() / range, most: most / range }
    })
}
