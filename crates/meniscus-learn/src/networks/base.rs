//! Weights of a base model as the start of a training on another liquid.
//!
//! The GRU layers of the encoder are taken as they are: their inputs are in units of the slosh. The head is fitted to the latents of the
//! new liquid by least squares. Bases, autoencoder and operators start anew, from the recordings of that liquid. On six recordings
//! of water and the short schedule this start lowered the error of v from 12.5 to 12.2 % and of sigma from 15.1 to 14.1 %
//! (docs/learning.md).

use crate::TrainError;
use meniscus::blob::Tensor as Name;
use meniscus::latent::encoder::GRU_LAYERS;
use meniscus_data::blob_file::read;
use meniscus_data::blob_file::write::Part;
use meniscus_optim::weights::Matrix;
use meniscus_platform::files::AlignedBytes;
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
}
