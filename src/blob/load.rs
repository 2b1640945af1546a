//! From bytes to a checked [`Model`]: the only constructor.

use super::effect_embedding::embed;
use super::read_header::read_header;
use super::shapes::{SURFACE_GROUP, shape};
use super::{EmbeddedEffects, Header, LoadError, ObservationModel, Section, Tensor};
use crate::latent::decoder::{Decoder, ENERGY_GROUP, Group};
use crate::latent::encoder::Encoder;
use crate::latent::generic::{Generic, LATENTS, Latent, ModeMap, Operators, Potential};
use crate::latent::linalg::{square_below, square_of, whitener};
use crate::latent::nn::{Dense, Element, Gru, Matrix, Vector, Weights, section_len};
use crate::latent::window::Scale;
use crate::uncertainty::cross_axis::CrossAxisMode;
use crate::uncertainty::error_factors::ErrorFactors;
use crate::uncertainty::error_model::{ErrorModel, SPREAD_OF};
use nalgebra::SMatrix;

/// Every tensor starts on such a boundary, counted from the start of the blob.
pub const ALIGNMENT: usize = 64;

/// Largest relative asymmetry of a covariance.
const ROUNDING: f64 = 1e-3;

/// A matrix on latent space.
type Square = SMatrix<f64, LATENTS, LATENTS>;

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

/// Access to the tensors by name, with every check on the way.
struct Store<'b, 'h> {
    blob: &'b [u8],
    header: &'h Header,
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
    fn weights(&self, tensor: Tensor) -> Result<Weights<'b>, LoadError> {
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
    fn matrix(&self, tensor: Tensor) -> Result<Matrix<'b>, LoadError> {
        let (section, numbers) = self.numbers(tensor)?;
        Matrix::new(numbers, section.rows as usize, section.columns as usize)
            .ok_or(LoadError::Section { tensor })
    }

    /// A tensor of one column, without its padding.
    fn vector(&self, tensor: Tensor) -> Result<Vector<'b>, LoadError> {
        let (section, numbers) = self.numbers(tensor)?;
        numbers.get(..section.rows as usize).ok_or(LoadError::Section { tensor })
    }

    /// Refuses a vector unless it has `rows` numbers.
    fn bias(&self, tensor: Tensor, rows: usize) -> Result<Vector<'b>, LoadError> {
        let bias = self.vector(tensor)?;
        if bias.len() == rows {
            return Ok(bias);
        }
        Err(LoadError::Shape { tensor, found: (bias.len() as u32, 1) })
    }

    fn gru(&self, layer: u8) -> Result<Gru<'b>, LoadError> {
        Ok(Gru {
            input: self.weights(Tensor::GruInput(layer))?,
            hidden: self.weights(Tensor::GruHidden(layer))?,
            input_bias: self.vector(Tensor::GruInputBias(layer))?,
            hidden_bias: self.vector(Tensor::GruHiddenBias(layer))?,
        })
    }

    fn encoder(&self) -> Result<Encoder<'b>, LoadError> {
        Ok(Encoder {
            layers: [self.gru(0)?, self.gru(1)?, self.gru(2)?],
            head: self.matrix(Tensor::HeadWeight)?,
            bias: self.vector(Tensor::HeadBias)?,
        })
    }

    /// The step, with the embedded effects in it and what they do to profiles.
    fn generic(&self) -> Result<(Generic<'b>, Option<ObservationModel>), LoadError> {
        let inward = self.matrix(Tensor::EnergyIn)?;
        let potential = Potential {
            linear: self.matrix(Tensor::EnergyLinear)?,
            inward,
            bias: self.bias(Tensor::EnergyBias, inward.rows())?,
            weight: self.bias(Tensor::EnergyWeight, inward.rows())?,
            bend: None,
        };
        let (skew, factor) = (self.vector(Tensor::SkewLower)?, self.vector(Tensor::FrictionFactor)?);
        let mut port = Latent::zeros();
        for (out, &b) in port.iter_mut().zip(self.vector(Tensor::Port)?) {
            *out = f64::from(b);
        }
        let mut generic = Generic {
            potential,
            operators: Operators::from_triangles(skew, factor),
            port,
            preconditioner: self.matrix(Tensor::Preconditioner)?,
            dt_s: self.header.dt_s,
            slots: None,
        };
        let observation_model = match &self.header.embedded {
            Some(embedded) => Some(self.add_effects(&mut generic, embedded)?),
            None => None,
        };
        Ok((generic, observation_model))
    }

    /// Puts the `embedded` effects into `generic`, and returns their observation model.
    fn add_effects(
        &self,
        generic: &mut Generic<'b>,
        embedded: &EmbeddedEffects,
    ) -> Result<ObservationModel, LoadError> {
        let rows = self.matrix(Tensor::ModeMap)?;
        let row = |index: usize| Latent::from_fn(|latent, _| f64::from(rows.at(index, latent)));
        let map = ModeMap::new([row(0), row(1), row(2), row(3)]).ok_or(LoadError::ModeMap)?;
        let (slots, observation_model) = embed(self.header, embedded, map, &generic.potential.hessian())?;
        generic.potential.bend = Some(*slots.bend());
        generic.slots = Some(slots);
        Ok(observation_model)
    }

    fn error_model(&self, decoder: &Decoder<'_>) -> Result<ErrorModel<'b>, LoadError> {
        let (surface, groups) = (self.matrix(Tensor::SurfaceSlope)?, self.matrix(Tensor::GroupSlope)?);
        Ok(ErrorModel {
            transition: square_of(&self.matrix(Tensor::Transition)?),
            process: self.covariance(Tensor::ProcessSpread)?.0,
            reading: self.covariance(Tensor::ReadingSpread)?.1,
            surface: SMatrix::from_fn(|latent, point| f64::from(surface.at(point, latent))),
            groups: core::array::from_fn(|group| square_below(&groups, group.saturating_mul(LATENTS))),
            pushed: SPREAD_OF.map(|group| decoder.pushed_square(group)),
            surface_misfit: self.variances(Tensor::SurfaceMisfit)?,
            group_misfit: self.variances(Tensor::GroupMisfit)?,
            factors: self.factors()?,
        })
    }

    /// The factors of the intervals, of which none is below zero.
    fn factors(&self) -> Result<ErrorFactors, LoadError> {
        let tensor = Tensor::Reach;
        let numbers = self.vector(tensor)?;
        let found = (numbers.len() as u32, 1);
        let factors = ErrorFactors::from_tensor(numbers).ok_or(LoadError::Shape { tensor, found })?;
        if factors.none_negative() { Ok(factors) } else { Err(LoadError::NotACovariance { tensor }) }
    }

    /// A matrix that is symmetric and has no negative direction, but for rounding, and its whitener.
    fn covariance(&self, tensor: Tensor) -> Result<(Square, Square), LoadError> {
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
    fn variances(&self, tensor: Tensor) -> Result<Vector<'b>, LoadError> {
        let numbers = self.vector(tensor)?;
        if numbers.iter().any(|number| *number < 0.0) {
            Err(LoadError::NotACovariance { tensor })
        } else {
            Ok(numbers)
        }
    }

    fn decoder(&self) -> Result<Decoder<'b>, LoadError> {
        let linear = self.matrix(Tensor::TrunkLinear)?;
        let one = self.dense(0, LATENTS)?;
        let two = self.dense(1, one.weights.rows())?;
        let three = self.dense(2, two.weights.rows())?;
        let mut first = 0;
        let groups = [self.group(0, &mut first)?, self.group(1, &mut first)?, self.group(2, &mut first)?];
        let [q, v, e] = groups;
        let (sigma, tau) = (self.group(3, &mut first)?, self.group(4, &mut first)?);
        let surface = self.group(SURFACE_GROUP, &mut first)?;
        for (tensor, rows) in
            [(Tensor::TrunkLinear, linear.rows()), (Tensor::TrunkWeight(2), three.weights.rows())]
        {
            if rows != first {
                return Err(LoadError::Shape { tensor, found: (rows as u32, linear.columns() as u32) });
            }
        }
        Ok(Decoder {
            linear,
            port: self.bias(Tensor::TrunkPort, first)?,
            trunk: [one, two, three],
            groups: [q, v, e, sigma, tau],
            surface,
        })
    }

    /// Layer `index` of the trunk, with `inputs` columns.
    fn dense(&self, index: u8, inputs: usize) -> Result<Dense<'b>, LoadError> {
        let tensor = Tensor::TrunkWeight(index);
        let weights = self.weights(tensor)?;
        if weights.columns() != inputs {
            let found = (weights.rows() as u32, weights.columns() as u32);
            return Err(LoadError::Shape { tensor, found });
        }
        Ok(Dense { weights, bias: self.bias(Tensor::TrunkBias(index), weights.rows())? })
    }

    /// Group `index`, whose coefficients begin at `first`; moves `first` behind them. The first column of the internal
    /// energy belongs to the heat itself and has none.
    fn group(&self, index: usize, first: &mut usize) -> Result<Group<'b>, LoadError> {
        let tag = index as u8;
        let basis = self.weights(Tensor::GroupBasis(tag))?;
        let rest = self.vector(Tensor::GroupRest(tag))?;
        let group = Group { rest, basis, first: *first };
        let own = basis.columns().saturating_sub(usize::from(index == ENERGY_GROUP));
        *first = first.saturating_add(own);
        Ok(group)
    }
}
