//! Weights of a base model as the start of a training on another liquid.
//!
//! ```text
//! decoder   c_new = P c_base(x),   P = S_new^T S_base group by group      (coefficients of the base's fields on the new bases)
//! encoder   x = T^+ z for the linear half, T the projected skip           (the blob has no encoder half of the autoencoder)
//! GRU       layers as they are: their inputs are in units of the slosh;   head by least squares on the new latents
//! ```
//! Operators are not taken over: the linear fit of the new recordings gives them a start of the new liquid's frequency and
//! damping.

use crate::TrainError;
use crate::data::dataset::Frame;
use crate::data::groups::TRUNK;
use crate::networks::noise::normal;
use meniscus::blob::Tensor as Name;
use meniscus::latent::encoder::GRU_LAYERS;
use meniscus::latent::generic::LATENTS;
use meniscus_data::blob_file::read;
use meniscus_data::blob_file::write::Part;
use meniscus_optim::weights::Matrix;
use meniscus_platform::files::AlignedBytes;
use nalgebra::DMatrix;
use rand_chacha::ChaCha8Rng;
use std::sync::Arc;

/// Weights that a training starts from.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Base {
    /// Random ones.
    #[default]
    Scratch,
    /// Those of a blob, where their shapes fit.
    Blob(Arc<[u8]>),
}

/// Group of the blob of each group of the trunk: the internal energy, which lies between, has no part in it.
const BLOB_GROUP: [u8; TRUNK.len()] = [0, 1, 3, 4, 5];

/// Group of the internal energy in the blob.
const HEAT: u8 = 2;

/// Ridge of the pseudo-inverse of the skip, relative to its largest singular value squared.
const RIDGE: f64 = 1e-6;

/// Deviation of the start of a half's last layer where the base has none, relative to the skip.
const FRESH: f64 = 1e-3;

/// Tensors of the base model.
#[derive(Debug)]
pub(crate) struct BaseWeights {
    parts: Vec<Part>,
}

impl BaseWeights {
    /// Tensors of `base`, if it is a blob.
    ///
    /// # Errors
    /// [`TrainError::Blob`], when it is refused.
    pub(crate) fn new(base: &Base) -> Result<Option<Self>, TrainError> {
        let Base::Blob(bytes) = base else { return Ok(None) };
        let (_, parts) = read::parts(&AlignedBytes::copy(bytes))?;
        Ok(Some(Self { parts }))
    }

    fn part(&self, name: Name) -> Option<&Part> {
        self.parts.iter().find(|part| part.tensor == name)
    }

    fn matrix(&self, name: Name) -> Option<Matrix> {
        self.part(name).map(|part| Matrix::new(part.rows, part.columns, part.values.clone()))
    }

    fn row(&self, name: Name) -> Option<Matrix> {
        self.part(name).map(|part| Matrix::new(1, part.values.len(), part.values.clone()))
    }

    /// Matrices of the GRU layers, without the head.
    pub(crate) fn recurrent(&self) -> Option<Vec<Matrix>> {
        let mut all = Vec::new();
        for layer in 0..GRU_LAYERS as u8 {
            all.push(self.matrix(Name::GruInput(layer))?);
            all.push(self.matrix(Name::GruHidden(layer))?);
            all.push(self.row(Name::GruInputBias(layer))?);
            all.push(self.row(Name::GruHiddenBias(layer))?);
        }
        Some(all)
    }

    /// D P of the coefficients: the base's coefficients as scaled coefficients on the bases of `frame`.
    fn projection(&self, frame: &Frame) -> Option<DMatrix<f64>> {
        // The pattern of the heat has one column that no coefficient of the trunk goes with.
        let rank = |group: u8| {
            let columns = self.part(Name::GroupBasis(group)).map_or(0, |part| part.columns);
            if group == HEAT { columns.saturating_sub(1) } else { columns }
        };
        let ranks: Vec<usize> = (0..=BLOB_GROUP[TRUNK.len() - 1]).map(rank).collect();
        let before = |group: u8| ranks[..usize::from(group)].iter().sum::<usize>();
        let scale = frame.coefficient_scale();
        let mut projection = DMatrix::zeros(frame.width(), ranks.iter().sum());
        for ((basis, range), group) in frame.bases.iter().zip(frame.ranges()).zip(BLOB_GROUP) {
            let base = self.part(Name::GroupBasis(group)).filter(|part| part.rows == basis.modes.nrows())?;
            let base = DMatrix::from_row_slice(base.rows, base.columns, &base.values);
            let inner = basis.modes.tr_mul(&base);
            for (row, at) in range.enumerate() {
                for column in 0..inner.ncols() {
                    let value = f64::from(inner[(row, column)]) / f64::from(scale[at]);
                    projection[(at, before(group) + column)] = value;
                }
            }
        }
        Some(projection)
    }

    /// Both halves of the autoencoder on the bases of `frame`, as `Autoencoder` orders them; `hidden` is the width of its layers.
    pub(crate) fn autoencoder(
        &self,
        frame: &Frame,
        hidden: usize,
        rng: &mut ChaCha8Rng,
    ) -> Option<Vec<Matrix>> {
        let projection = self.projection(frame)?;
        let onto =
            |matrix: &Matrix| (matrix.rows == projection.ncols()).then(|| &projection * matrix.to_f64());
        let skip = onto(&self.matrix(Name::TrunkLinear)?)?;
        let last = onto(&self.matrix(Name::TrunkWeight(2))?)?;
        let [first, second] = [0, 1].map(|layer| self.matrix(Name::TrunkWeight(layer)));
        let [first_bias, second_bias] = [0, 1].map(|layer| self.row(Name::TrunkBias(layer)));
        let decoder = vec![
            Matrix::from_f64(&skip),
            first?,
            first_bias?,
            second?,
            second_bias?,
            Matrix::from_f64(&last),
        ];
        if decoder[1].rows != hidden || decoder[3].rows != hidden {
            return None;
        }
        let normal_matrix = skip.tr_mul(&skip);
        let ridge = RIDGE * normal_matrix.trace();
        let inverse = (normal_matrix + DMatrix::identity(LATENTS, LATENTS) * ridge).try_inverse()?;
        let back = inverse * skip.transpose();
        let mut fresh = |rows: usize, columns: usize, deviation: f64| {
            Matrix::new(
                rows,
                columns,
                (0..rows * columns).map(|_| (deviation * normal(rng)) as f32).collect(),
            )
        };
        let root = |inputs: usize| 1.0 / (inputs as f64).sqrt();
        let width = frame.width();
        let mut weights = vec![
            Matrix::from_f64(&back),
            fresh(hidden, width, root(width)),
            Matrix::zeros(1, hidden),
            fresh(hidden, hidden, root(hidden)),
            Matrix::zeros(1, hidden),
            fresh(LATENTS, hidden, FRESH * root(hidden)),
        ];
        weights.extend(decoder);
        Some(weights)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::pod::Basis;
    use meniscus::blob::Model;
    use meniscus::latent::decoder::Coefficients;
    use rand::SeedableRng;

    /// On the bases of the base itself the decoder is that of the base, through the camera side's own decoder.
    #[test]
    fn on_its_own_bases_the_decoder_is_the_base_s() {
        let bytes = AlignedBytes::copy(meniscus_shipped::MODEL);
        let base =
            BaseWeights::new(&Base::Blob(Arc::from(&bytes[..]))).expect("a good blob").expect("a base");
        let bases: Vec<Basis> = BLOB_GROUP
            .iter()
            .map(|&group| {
                let part = base.part(Name::GroupBasis(group)).expect("a basis");
                Basis { modes: DMatrix::from_row_slice(part.rows, part.columns, &part.values), left_out: 0.0 }
            })
            .collect();
        let width = bases.iter().map(Basis::rank).sum();
        let frame = Frame {
            bases,
            rest_state: Vec::new(),
            rest_profile: Vec::new(),
            feed: vec![0.0; width],
            group_scale: [2.0; 5],
            height_scale_m: 1.0,
            acceleration_scale: 1.0,
            energy_scale_j: 1.0,
            fill_m: 0.07,
        };
        let weights =
            base.autoencoder(&frame, 64, &mut ChaCha8Rng::seed_from_u64(1)).expect("the shapes fit");
        let model = Model::load(&bytes).expect("a good blob");
        let x = [0.3_f32, -0.2, 0.1, 0.4, -0.1, 0.2, 0.05, -0.3, 0.1, 0.0, 0.2, -0.05, 0.1];
        let due: Coefficients = model.decoder.coefficients(&x, 0.0);
        // z = T x + W3 relu(W2 relu(W1 x + b1) + b2), less its value at rest, which b3 of the blob is.
        let column = |v: &[f32]| nalgebra::DVector::from_iterator(v.len(), v.iter().map(|&v| f64::from(v)));
        let matrix = |k: usize| weights[6 + k].to_f64();
        let bent = |v: nalgebra::DVector<f64>| v.map(|v| v.max(0.0));
        let net = |x: &nalgebra::DVector<f64>| {
            let first = bent(matrix(1) * x + matrix(2).transpose());
            matrix(5) * bent(matrix(3) * first + matrix(4).transpose())
        };
        let x = column(&x);
        let said = matrix(0) * &x + net(&x) - net(&nalgebra::DVector::zeros(LATENTS));
        let heat = base.part(Name::GroupBasis(HEAT)).expect("a pattern").columns - 1;
        let before: usize = frame.ranges()[1].end;
        for (k, said) in said.iter().enumerate() {
            let due = f64::from(due[if k < before { k } else { k + heat }]) / 2.0;
            assert!((said - due).abs() < 1e-3 * (1e-3 + due.abs()), "{k}: {said} for {due}");
        }
    }
}
