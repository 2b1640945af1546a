//! From bytes to a checked [`Model`]: the only constructor.

use super::read_header::read_header;
use super::store::Store;
use super::{Header, LoadError, ObservationModel, Tensor};
use crate::latent::decoder::Decoder;
use crate::latent::encoder::Encoder;
use crate::latent::generic::Generic;
use crate::latent::window::Scale;
use crate::uncertainty::cross_axis::CrossAxisMode;
use crate::uncertainty::error_model::ErrorModel;

/// A blob that has passed every check; its weights are read in place.
///
/// ```
/// # #[repr(align(64))]
/// # struct Aligned<T: ?Sized>(T);
/// # static BLOB: &Aligned<[u8]> =
/// #     &Aligned(*include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/models/glycerine.blob")));
/// use meniscus::blob::{LoadError, Model};
///
/// let model = Model::load(&BLOB.0)?;
/// // Thirteen numbers a tracer: position, velocity, internal energy, normal and shear stresses.
/// assert_eq!(model.field_len(), 13 * model.header.particles as usize);
/// assert!(model.header.fill_m < model.header.rim_m);
/// // A blob that was cut short is refused.
/// let refused = Model::load(&BLOB.0[..1000]).err();
/// assert_eq!(refused, Some(LoadError::Truncated { have: 1000, need: BLOB.0.len() }));
/// # Ok::<(), LoadError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Model<'b> {
    /// Header of the blob.
    pub header: Header,
    /// Window to latent.
    pub encoder: Encoder<'b>,
    /// The time step.
    pub generic: Generic<'b>,
    /// Latent and heat to field.
    pub decoder: Decoder<'b>,
    /// Errors of the model.
    pub error_model: ErrorModel<'b>,
    /// Slosh across the line along which the glass is moved.
    pub cross_axis: CrossAxisMode,
    /// Effects of camera, fill and inclination on a profile; `None` without embedded effects.
    pub observation_model: Option<ObservationModel>,
}

impl<'b> Model<'b> {
    /// Checks `blob` and builds the model on it.
    ///
    /// # Errors
    /// The first thing that is wrong with the blob, as [`LoadError`].
    // What is made on the way takes twice the stack of the result; a caller that inlined it would keep that for good.
    #[inline(never)]
    pub fn load(blob: &'b [u8]) -> Result<Self, LoadError> {
        let header = read_header(blob)?;
        let store = Store { blob, header: &header };
        let encoder = store.encoder()?;
        let (generic, observation_model) = store.generic()?;
        let decoder = store.decoder()?;
        // Only corrections use it, but what cannot be corrected is no whole blob.
        store.matrix(Tensor::Gain)?;
        let error_model = store.error_model(&decoder)?;
        let kick = generic.port * generic.dt_s;
        let cross_axis = CrossAxisMode::of(kick, &error_model.transition, &error_model.surface);
        Ok(Self { encoder, generic, decoder, error_model, cross_axis, observation_model, header })
    }

    /// Numbers in the full field: 13 a tracer.
    #[must_use]
    pub fn field_len(&self) -> usize {
        self.decoder.groups.iter().map(|group| group.rest.len()).sum()
    }

    /// Scales of the encoder's features.
    #[must_use]
    pub fn scale(&self) -> Scale {
        Scale {
            fill_m: self.header.fill_m as f32,
            height_m: self.header.height_scale_m,
            acceleration_m_s2: self.header.acceleration_scale,
        }
    }
}
