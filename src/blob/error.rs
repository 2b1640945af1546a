//! Why a blob is refused, one sentence a cause.

use super::{OLDEST_VERSION, Tensor, VERSION};
use crate::latent::nn::Element;
use core::fmt;

/// A blob that is not loaded. Whatever model ran before keeps running.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LoadError {
    /// The blob ends before its stated length.
    Truncated {
        /// Bytes there are.
        have: usize,
        /// Bytes there should be.
        need: usize,
    },
    /// The first eight bytes are not those of a blob.
    NotABlob,
    /// The format version is none that this build reads.
    Version {
        /// Version in the blob.
        found: u32,
    },
    /// There are bytes behind the stated end.
    Trailing {
        /// Bytes behind the end.
        extra: usize,
    },
    /// The checksum does not match: the blob was damaged on its way.
    Checksum {
        /// CRC-32 in the blob.
        stated: u32,
        /// CRC-32 of what is there.
        computed: u32,
    },
    /// The header cannot be read.
    Header,
    /// A number of the header is not finite or not positive.
    HeaderValue {
        /// Field name.
        field: &'static str,
        /// Its value.
        value: f64,
    },
    /// A text of the header holds control characters, which a terminal would carry out.
    HeaderText {
        /// Field name.
        field: &'static str,
    },
    /// The buffer does not start on a 64-byte boundary, so tensors cannot be read in place.
    Misaligned,
    /// A tensor lies outside the blob or off its 64-byte boundary.
    Section {
        /// Which tensor.
        tensor: Tensor,
    },
    /// A tensor that the model needs is not there.
    Missing {
        /// Which tensor.
        tensor: Tensor,
    },
    /// A tensor has another shape than the model needs.
    Shape {
        /// Which tensor.
        tensor: Tensor,
        /// Its rows and columns.
        found: (u32, u32),
    },
    /// A tensor that the laws or the filter stand on is stored coarser than f32.
    TooCoarse {
        /// Which tensor.
        tensor: Tensor,
        /// In what it is stored.
        element: Element,
    },
    /// The blob names an effect that the library has not.
    UnknownEffect {
        /// Place in its list.
        index: usize,
    },
    /// A value of an embedded effect lies outside of its range.
    EffectValue {
        /// The effect.
        effect: &'static str,
        /// Its parameter.
        parameter: &'static str,
        /// Its value.
        value: f64,
    },
    /// An effect of the list cannot be embedded in a model.
    EffectNotEmbeddable {
        /// The effect.
        effect: &'static str,
        /// Why.
        why: &'static str,
    },
    /// The directions of the map of the first mode are not those of its rows.
    ModeMap,
    /// A number of the friction law is out of its range.
    FrictionLaw,
    /// The blob's error model is invalid: a matrix that is no covariance, a variance or a factor below zero.
    NotACovariance {
        /// Which tensor.
        tensor: Tensor,
    },
    /// A weight is NaN or infinite.
    NotFinite {
        /// Which tensor.
        tensor: Tensor,
        /// Position in the tensor as it lies in the blob.
        index: usize,
    },
}

impl fmt::Display for LoadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Truncated { have, need } => {
                write!(f, "the blob is cut short: {have} bytes of {need}; copy it again")
            }
            Self::NotABlob => {
                write!(f, "this is not a weight blob (it does not begin with MENISCUS)")
            }
            Self::Version { found } => write!(
                f,
                "the blob has format version {found}, this program reads versions {OLDEST_VERSION} to {VERSION}; \
                 train the model again with `meniscus train` of this program, or update the program"
            ),
            Self::Trailing { extra } => write!(f, "{extra} bytes follow the end of the blob"),
            Self::Checksum { stated, computed } => write!(
                f,
                "the blob is damaged: its CRC-32 should be {stated:08x} and is {computed:08x}; copy it again"
            ),
            Self::Header => write!(f, "the header of the blob cannot be read"),
            Self::HeaderValue { field, value } => {
                write!(f, "the header's {field} is {value}, which no glass, filter or model can have")
            }
            Self::HeaderText { field } => {
                write!(
                    f,
                    "the header's {field} holds control characters; take the blob from a source that you trust"
                )
            }
            Self::Misaligned => write!(f, "the blob must lie on a 64-byte boundary in memory"),
            Self::Section { tensor } => write!(f, "tensor {tensor:?} lies outside the blob"),
            Self::Missing { tensor } => write!(f, "tensor {tensor:?} is missing"),
            Self::Shape { tensor, found: (rows, columns) } => {
                write!(f, "tensor {tensor:?} is {rows} x {columns}, which does not fit the model")
            }
            Self::TooCoarse { tensor, element } => {
                write!(
                    f,
                    "tensor {tensor:?} is stored as {element}, and only GRU, trunk and bases may be coarser than f32"
                )
            }
            Self::UnknownEffect { index } => write!(
                f,
                "effect number {index} of the blob is in no library of this program: a newer one made it; update, or \
                 take the model without effects"
            ),
            Self::EffectValue { effect, parameter, value } => {
                write!(
                    f,
                    "the blob says {parameter} = {value} of the effect {effect}, which lies out of its range"
                )
            }
            Self::EffectNotEmbeddable { effect, why } => {
                write!(f, "the effect {effect} has no place in a flashed model: {why}")
            }
            Self::ModeMap => write!(
                f,
                "the blob's map of the first mode contradicts itself; put the effects in again with `meniscus insert`"
            ),
            Self::FrictionLaw => write!(
                f,
                "the blob's friction law has a number out of its range; learn the model again with `meniscus learn`"
            ),
            Self::NotACovariance { tensor } => write!(
                f,
                "tensor {tensor:?}, which says how far the model may be off, is no covariance or has numbers below zero; \
                 measure it again with `meniscus train --intervals-of`"
            ),
            Self::NotFinite { tensor, index } => {
                write!(f, "number {index} of tensor {tensor:?} is NaN or infinite")
            }
        }
    }
}

impl core::error::Error for LoadError {}
