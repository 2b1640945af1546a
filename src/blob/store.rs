//! Tensors of a blob by name, each with its checks: place, shape, element, finite numbers.

use super::shapes::shape;
use super::{Header, LoadError, Section, Tensor};
use crate::latent::generic::LATENTS;
use crate::latent::linalg::{square_of, whitener};
use crate::latent::nn::{Element, Matrix, Vector, Weights, section_len};
use nalgebra::SMatrix;

/// Every tensor starts on such a boundary, counted from the start of the blob.
pub const ALIGNMENT: usize = 64;

/// Largest relative asymmetry of a covariance.
const ROUNDING: f64 = 1e-3;

/// A matrix on latent space.
pub(super) type Square = SMatrix<f64, LATENTS, LATENTS>;

/// Access to the tensors by name, with every check on the way.
pub(super) struct Store<'b, 'h> {
    pub(super) blob: &'b [u8],
    pub(super) header: &'h Header,
}

impl<'b> Store<'b, '_> {
    /// The section of `tensor` and its bytes.
    fn find(&self, tensor: Tensor) -> Result<(&Section, &'b [u8]), LoadError> {
        let mut sections = self.header.sections.iter();
        let section = sections.find(|s| s.tensor == tensor).ok_or(LoadError::Missing { tensor })?;
        let found = (section.rows, section.columns);
        let (rows, columns) = (section.rows as usize, section.columns as usize);
        let fits = shape(tensor, self.header).is_some_and(|(r, c)| r.allows(rows) && c.allows(columns));
        if !fits {
            return Err(LoadError::Shape { tensor, found });
        }
        if section.element != Element::F32 && !tensor.may_be_coarse() {
            return Err(LoadError::TooCoarse { tensor, element: section.element });
        }
        let outside = LoadError::Section { tensor };
        let offset = section.offset as usize;
        let bytes = section_len(section.element, rows, columns).ok_or(outside)?;
        let end = offset.checked_add(bytes).ok_or(outside)?;
        if !offset.is_multiple_of(ALIGNMENT) {
            return Err(outside);
        }
        Ok((section, self.blob.get(offset..end).ok_or(outside)?))
    }

    /// A tensor whose weights may be stored coarser than f32.
    pub(super) fn weights(&self, tensor: Tensor) -> Result<Weights<'b>, LoadError> {
        let (section, bytes) = self.find(tensor)?;
        if bytes.as_ptr().align_offset(align_of::<f32>()) != 0 {
            return Err(LoadError::Misaligned);
        }
        let weights = Weights::new(section.element, bytes, section.rows as usize, section.columns as usize)
            .ok_or(LoadError::Section { tensor })?;
        match weights.not_finite() {
            Some(index) => Err(LoadError::NotFinite { tensor, index }),
            None => Ok(weights),
        }
    }

    /// The numbers of a tensor that is f32.
    fn numbers(&self, tensor: Tensor) -> Result<(&Section, &'b [f32]), LoadError> {
        let (section, raw) = self.find(tensor)?;
        let numbers = bytemuck::try_cast_slice::<u8, f32>(raw).map_err(|_| LoadError::Misaligned)?;
        match numbers.iter().position(|w| !w.is_finite()) {
            Some(index) => Err(LoadError::NotFinite { tensor, index }),
            None => Ok((section, numbers)),
        }
    }

    /// A tensor as a matrix of f32.
    pub(super) fn matrix(&self, tensor: Tensor) -> Result<Matrix<'b>, LoadError> {
        let (section, numbers) = self.numbers(tensor)?;
        Matrix::new(numbers, section.rows as usize, section.columns as usize)
            .ok_or(LoadError::Section { tensor })
    }

    /// A tensor of one column, without its padding.
    pub(super) fn vector(&self, tensor: Tensor) -> Result<Vector<'b>, LoadError> {
        let (section, numbers) = self.numbers(tensor)?;
        numbers.get(..section.rows as usize).ok_or(LoadError::Section { tensor })
    }

    /// Refuses a vector unless it has `rows` numbers.
    pub(super) fn bias(&self, tensor: Tensor, rows: usize) -> Result<Vector<'b>, LoadError> {
        let bias = self.vector(tensor)?;
        if bias.len() == rows {
            return Ok(bias);
        }
        Err(LoadError::Shape { tensor, found: (bias.len() as u32, 1) })
    }

    /// A matrix that is symmetric and has no negative direction, but for rounding, and its whitener.
    pub(super) fn covariance(&self, tensor: Tensor) -> Result<(Square, Square), LoadError> {
        let m = square_of(&self.matrix(tensor)?);
        let white = whitener(&m);
        let largest = |m: &Square| m.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        let size = largest(&m);
        let skew = largest(&(m - m.transpose())) > ROUNDING * size;
        // What has no size says nothing, and is believed.
        let negative = size > 0.0 && largest(&white) <= 0.0;
        if skew || negative { Err(LoadError::NotACovariance { tensor }) } else { Ok((m, white)) }
    }

    /// Numbers of which none is below zero.
    pub(super) fn variances(&self, tensor: Tensor) -> Result<Vector<'b>, LoadError> {
        let numbers = self.vector(tensor)?;
        if numbers.iter().any(|number| *number < 0.0) {
            Err(LoadError::NotACovariance { tensor })
        } else {
            Ok(numbers)
        }
    }
}
