//! Parts of a model from the tensors of its blob: encoder, step, error model, decoder.

use super::effect_embedding::embed;
use super::shapes::SURFACE_GROUP;
use super::store::Store;
use super::{EmbeddedEffects, LoadError, ObservationModel, Tensor};
use crate::latent::decoder::{Decoder, ENERGY_GROUP, Group};
use crate::latent::encoder::Encoder;
use crate::latent::generic::{
    FrictionLaw, Generic, LATENTS, LAW_NUMBERS, Latent, ModeMap, Operators, Potential,
};
use crate::latent::linalg::{square_below, square_of};
use crate::latent::nn::{Dense, Gru};
use crate::uncertainty::error_factors::ErrorFactors;
use crate::uncertainty::error_model::{ErrorModel, SPREAD_OF};
use nalgebra::SMatrix;

impl<'b> Store<'b, '_> {
    fn gru(&self, layer: u8) -> Result<Gru<'b>, LoadError> {
        Ok(Gru {
            input: self.weights(Tensor::GruInput(layer))?,
            hidden: self.weights(Tensor::GruHidden(layer))?,
            input_bias: self.vector(Tensor::GruInputBias(layer))?,
            hidden_bias: self.vector(Tensor::GruHiddenBias(layer))?,
        })
    }

    pub(super) fn encoder(&self) -> Result<Encoder<'b>, LoadError> {
        Ok(Encoder {
            layers: [self.gru(0)?, self.gru(1)?, self.gru(2)?],
            head: self.matrix(Tensor::HeadWeight)?,
            bias: self.vector(Tensor::HeadBias)?,
        })
    }

    /// The step, with the embedded effects in it and what they do to profiles.
    pub(super) fn generic(&self) -> Result<(Generic<'b>, Option<ObservationModel>), LoadError> {
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
            law: self.friction_law()?,
        };
        let observation_model = match &self.header.embedded {
            Some(embedded) => Some(self.add_effects(&mut generic, embedded)?),
            None => None,
        };
        Ok((generic, observation_model))
    }

    /// The friction law, where the blob lists one.
    fn friction_law(&self) -> Result<Option<FrictionLaw>, LoadError> {
        let tensor = Tensor::FrictionLaw;
        if self.header.sections.iter().all(|section| section.tensor != tensor) {
            return Ok(None);
        }
        let mut numbers = [0.0; LAW_NUMBERS];
        for (out, &number) in numbers.iter_mut().zip(self.vector(tensor)?) {
            *out = f64::from(number);
        }
        FrictionLaw::new(numbers).map(Some).ok_or(LoadError::FrictionLaw)
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

    pub(super) fn error_model(&self, decoder: &Decoder<'_>) -> Result<ErrorModel<'b>, LoadError> {
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

    pub(super) fn decoder(&self) -> Result<Decoder<'b>, LoadError> {
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
