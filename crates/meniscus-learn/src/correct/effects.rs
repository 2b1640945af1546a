//! Effects that a model carries, in its correction: they stay as they are, and the weights learn what they leave.
//!
//! Effects of camera, fill and inclination are taken off the new profiles first ([`freed`]), and the model then runs without them.
//! Those of the liquid act in every step along a new recording:
//!
//! ```text
//! x_(n+1) = s(x_n) + [ f(x_n, z_n) - s(x_n) ]      f: the step of the run, with the memories z of the effects
//! ```
//! with the bracket held constant. The value is that of the run. The gradient is that of s, the step with the effects of
//! [`meniscus::latent::generic::Slots`] in its H and D, but with one phi, the mean along the recordings, and without memories: where phi
//! depends on the amplitude, and of memories, the gradient is an approximation. Candidates are judged by the run itself.
//!
//! The source liquid has none of the effects: along its recordings the weights act alone.

use super::Sightings;
use crate::operators::reference_step::{Dynamics, Square};
use crate::operators::unrolled::{Operators, RATE, factor_of};
use burn::tensor::{Device, Tensor, TensorData};
use meniscus::blob::{LoadError, Model};
use meniscus::latent::generic::{Generic, LATENTS, Latent, LatentState, MEMORIES, ModeMap};
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_optim::weights::{Matrix, numbers};
use nalgebra::DMatrix;

/// Memories of a row of a batch, m.
pub(super) type Held = [f64; MEMORIES];

/// Every so many states enter phi.
const STRIDE: usize = 7;

/// Returns the model of `blob` for profiles that [`freed`] has made.
///
/// # Errors
/// [`LoadError`], when the blob is refused.
pub(super) fn with_effects(blob: &[u8]) -> Result<Model<'_>, LoadError> {
    let mut model = Model::load(blob)?;
    model.observation_model = None;
    Ok(model)
}

/// Returns the model of `blob` for its source liquid.
///
/// # Errors
/// [`LoadError`], when the blob is refused.
pub(super) fn without_effects(blob: &[u8]) -> Result<Model<'_>, LoadError> {
    let mut model = with_effects(blob)?;
    model.generic.slots = None;
    model.generic.potential.bend = None;
    Ok(model)
}

/// Returns `recordings` as the glass and the camera that `blob` was trained on would show them.
///
/// # Errors
/// [`LoadError`], when the blob is refused.
pub(super) fn freed(blob: &[u8], recordings: &[Sightings]) -> Result<Vec<Sightings>, LoadError> {
    let model = Model::load(blob)?;
    let Some(observed) = &model.observation_model else { return Ok(recordings.to_vec()) };
    let free = |seen: &Sightings| -> Sightings {
        seen.iter().map(|profile| profile.as_ref().map(|profile| observed.to_model(profile))).collect()
    };
    Ok(recordings.iter().map(free).collect())
}

/// Returns the states `latents` of a run under the ports `u` with the memories that the effects of `generic` have along them.
pub(super) fn remembering(generic: &Generic<'_>, latents: &[Latent], u: &[f32]) -> Vec<LatentState> {
    let mut held = Held::default();
    let ports = u.iter().skip(1).copied().map(Some).chain(std::iter::repeat(None));
    let state = |(latent, next): (&Latent, Option<f32>)| {
        let now = LatentState { latent: *latent, heat: 0.0, held };
        if let (Some(u), true) = (next, generic.slots.is_some()) {
            let mut after = now;
            generic.step(&mut after, f64::from(u));
            held = after.held;
        }
        now
    };
    latents.iter().zip(ports).map(state).collect()
}

/// S and phi of the step that stands for the one with effects in the gradient.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct StandIn {
    /// S.
    bend: Square,
    /// phi, the mean weighted by what the weights alone dissipate.
    phi: f64,
    /// First mode in latent space, for the y of friction.
    map: ModeMap,
}

impl StandIn {
    /// Stand-in for the effects in `generic` along `states`; `None` without effects.
    pub(super) fn along<'a>(
        generic: &Generic<'_>,
        states: impl Iterator<Item = &'a LatentState>,
    ) -> Option<Self> {
        let slots = generic.slots.as_ref()?;
        let (mut sum, mut weight) = (0.0, 0.0);
        for state in states.step_by(STRIDE) {
            // What the weights alone dissipate.
            let gradient = generic.potential.gradient(&state.latent);
            let dissipated = gradient.dot(&(generic.operators.friction * gradient));
            sum += dissipated * slots.friction_factor(&state.latent);
            weight += dissipated;
        }
        let phi = if weight > 0.0 { sum / weight } else { 1.0 };
        Some(Self { bend: *slots.bend(), phi, map: *slots.map() })
    }

    /// D1 of the weights `tensors`, in units of [`RATE`], with the H'' of `dynamics`, the same weights.
    fn friction(&self, tensors: &[Tensor<2>], dynamics: &Dynamics, device: &Device) -> Tensor<2> {
        let c = factor_of(&tensors[1], device);
        let plain = c.clone().matmul(c.clone().transpose());
        if self.phi <= 1.0 {
            return plain * self.phi as f32;
        }
        let (hessian, half) = (dynamics.stiffness(), (0.5 * RATE * FRAME_INTERVAL_S) as f32);
        let column =
            |x: &Latent| Matrix::new(LATENTS, 1, x.iter().map(|&x| x as f32).collect()).tensor(device);
        let slowed = plain.matmul(column(&(hessian * self.map.along_rate)));
        let y = (column(&self.map.rate).transpose().matmul(slowed) * half).clamp_min(0.0);
        let shift = y.clone() * (half * (self.phi * self.phi - 1.0) as f32) / (y * self.phi as f32 + 1.0);
        let square = |m: &Square| Matrix::from_f64(&of_any_size(m)).tensor(device);
        let identity = square(&Square::identity());
        let sum = c.clone().transpose().matmul(square(&hessian)).matmul(c.clone()) * shift + identity.clone();
        // Y (2 - X Y) has the value of Y and the derivative of X^-1, with Y the inverse at the present weights.
        let present = Square::from_row_iterator(numbers(sum.clone().inner()).into_iter().map(f64::from));
        let inverse = square(&present.try_inverse().unwrap_or_else(Square::identity));
        let inverse = inverse.clone().matmul(identity * 2.0 - sum.matmul(inverse));
        c.clone().matmul(inverse).matmul(c.transpose()) * self.phi as f32
    }

    /// The operators of the weights `tensors` and `dynamics`, which are the same.
    fn operators(&self, tensors: &[Tensor<2>], dynamics: &Dynamics, device: &Device) -> Operators {
        let friction = self.friction(tensors, dynamics, device);
        let rubs = Square::from_row_iterator(numbers(friction.clone().inner()).into_iter().map(f64::from));
        // Any root of D1 will do.
        let eigen = rubs.symmetric_eigen();
        let root = eigen.eigenvectors
            * Square::from_diagonal(&eigen.eigenvalues.map(|l| (RATE * l.max(0.0)).sqrt()));
        let bend = of_any_size(&self.bend);
        let bent = Dynamics {
            friction: root,
            linear: dynamics.linear * self.bend,
            inner: &dynamics.inner * &bend,
            ..dynamics.clone()
        };
        let bend = Matrix::from_f64(&bend).tensor(device);
        let mut tensors = tensors.to_vec();
        // K and W, which stand before S x.
        for tensor in &mut tensors[2..4] {
            *tensor = tensor.clone().matmul(bend.clone());
        }
        Operators::with_friction(&tensors, friction, &bent.preconditioners(&bent.stiffness()), device)
    }
}

/// `m` with its size not in its type.
fn of_any_size(m: &Square) -> DMatrix<f64> {
    DMatrix::from_iterator(LATENTS, LATENTS, m.iter().copied())
}

/// Step with effects, many states at once.
pub(super) struct StepWithEffects<'a> {
    /// The step of the run, of the present weights.
    generic: &'a Generic<'a>,
    stand_in: Operators,
    frozen: Operators,
}

impl<'a> StepWithEffects<'a> {
    /// Of `tensors` (leaves) and `dynamics`, the same weights as in `generic`.
    pub(super) fn new(
        generic: &'a Generic<'a>,
        stand_in: &StandIn,
        tensors: &[Tensor<2>],
        dynamics: &Dynamics,
        device: &Device,
    ) -> Self {
        let stand_in = stand_in.operators(tensors, dynamics, device);
        Self { generic, frozen: stand_in.frozen(), stand_in }
    }

    /// One turn of every row under the ports `u` `[batch, 1]`, with its memories in `held`.
    pub(super) fn turn(&self, x: Tensor<2>, u: Tensor<2>, held: &mut [Held]) -> Tensor<2> {
        let device = x.device();
        let (said, _) = self.stand_in.turn(x.clone(), u.clone(), &self.frozen);
        let [x, u, stands] = [x, u, said.clone()].map(|tensor| numbers(tensor.inner()));
        let rows = x.chunks_exact(LATENTS).zip(stands.chunks_exact(LATENTS)).zip(&u).zip(held);
        let mut off = Vec::with_capacity(x.len());
        for (((x, stands), u), held) in rows {
            let latent = Latent::from_iterator(x.iter().map(|&x| f64::from(x)));
            let mut state = LatentState { latent, heat: 0.0, held: *held };
            self.generic.step(&mut state, f64::from(*u));
            *held = state.held;
            off.extend(
                state.latent.iter().zip(stands).map(|(exact, stands)| (exact - f64::from(*stands)) as f32),
            );
        }
        let rows = off.len() / LATENTS;
        said + Tensor::from_data(TensorData::new(off, [rows, LATENTS]), &device)
    }
}

#[cfg(test)]
mod tests;
