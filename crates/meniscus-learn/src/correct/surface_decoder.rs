//! Surface of the decoder, which a correction does not change.

use burn::tensor::{Device, Tensor, TensorData};
use meniscus::blob::Tensor as Name;
use meniscus::latent::decoder::MAX_TRUNK;
use meniscus::latent::generic::{LATENTS, LatentState};
use meniscus_data::blob_file::write::Part;
use meniscus_optim::nets::perceptron;
use meniscus_optim::weights::{Matrix, numbers};

/// The surface of the decoder: `rest + B (T x + n(x))`.
#[derive(Clone, Debug)]
pub(super) struct SurfaceDecoder {
    linear: Matrix,
    trunk: Vec<Matrix>,
    basis: Matrix,
    /// Heights at rest, m.
    pub(super) rest: Vec<f32>,
}

impl SurfaceDecoder {
    /// From the tensors of a blob; `None` where one is missing.
    pub(super) fn new(parts: &[Part]) -> Option<Self> {
        let part = |name: Name| parts.iter().find(|part| part.tensor == name);
        let matrix = |part: &Part| Matrix::new(part.rows, part.columns, part.values.clone());
        let row = |part: &Part| Matrix::new(1, part.rows, part.values.clone());
        // The surface is the last group of the trunk.
        let basis = part(Name::GroupBasis(5))?;
        let last = |m: Matrix| {
            let from = (m.rows - basis.columns) * m.columns;
            Matrix::new(basis.columns, m.columns, m.values[from..].to_vec())
        };
        let bias = row(part(Name::TrunkBias(2))?);
        let bias = bias.values[bias.columns - basis.columns..].to_vec();
        let trunk = vec![
            matrix(part(Name::TrunkWeight(0))?),
            row(part(Name::TrunkBias(0))?),
            matrix(part(Name::TrunkWeight(1))?),
            row(part(Name::TrunkBias(1))?),
            last(matrix(part(Name::TrunkWeight(2))?)),
            Matrix::new(1, bias.len(), bias),
        ];
        debug_assert!(trunk[0].rows <= MAX_TRUNK);
        let rest = part(Name::GroupRest(5))?.values.clone();
        Some(Self { linear: last(matrix(part(Name::TrunkLinear)?)), trunk, basis: matrix(basis), rest })
    }

    /// Heights over rest of every one of `states`, row-major, m.
    pub(super) fn heights(&self, states: &[LatentState]) -> Vec<f32> {
        let device = Device::flex();
        let rows: Vec<f32> = states.iter().flat_map(|s| s.latent.iter().map(|&v| v as f32)).collect();
        let x = Tensor::from_data(TensorData::new(rows, [states.len(), LATENTS]), &device);
        numbers(SurfaceTensors::new(self, &device).heights(x))
    }
}

/// The decoder's surface as tensors.
pub(super) struct SurfaceTensors {
    linear_t: Tensor<2>,
    trunk: Vec<Tensor<2>>,
    basis_t: Tensor<2>,
}

impl SurfaceTensors {
    pub(super) fn new(surface: &SurfaceDecoder, device: &Device) -> Self {
        Self {
            linear_t: surface.linear.tensor(device).transpose(),
            trunk: surface.trunk.iter().map(|m| m.tensor(device)).collect(),
            basis_t: surface.basis.tensor(device).transpose(),
        }
    }

    /// Heights over rest of every row of `x`, m.
    pub(super) fn heights(&self, x: Tensor<2>) -> Tensor<2> {
        let bent = perceptron(x.clone(), &self.trunk, |layer| layer < 2);
        (x.matmul(self.linear_t.clone()) + bent).matmul(self.basis_t.clone())
    }
}
