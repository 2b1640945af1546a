//! Jacobian of the time step at any state.
//!
//! ```text
//! x^ = x~ + dt F dH(x~, x^)     F = L - D,   x~ = x + dt/2 B u,   x1 = x^ + dt/2 B u
//! (1 - dt F S^) dx^ = (1 + dt F S~) dx~      S^ and S~: how dH changes with its second and its first end
//! dx1/dx = dx^/dx~                           dx1/du = dt/2 (dx^/dx~ + 1) B
//! ```
//! by the implicit function theorem. Under a [`super::FrictionLaw`] F is the slope of (L - phi D) dH in dH. dH is symmetric in its ends, so that S~ is S^ with the ends exchanged. Of a model
//! with named effects F is taken as it stands at the state: the change of its friction and of its memories is left out.

use super::Latent;
use super::flow::Flow;
use super::newton::{self, Square};
use super::step::{Generic, LatentState};

/// Jacobian of [`Generic::step`].
///
/// ```
/// # #[repr(align(64))]
/// # struct Aligned<T: ?Sized>(T);
/// # static BLOB: &Aligned<[u8]> =
/// #     &Aligned(*include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/models/glycerine.blob")));
/// let model = meniscus::blob::Model::load(&BLOB.0)?;
/// use meniscus::latent::generic::{Latent, LatentState};
///
/// let state = LatentState { latent: Latent::repeat(0.2), ..LatentState::default() };
/// let jacobian = model.generic.jacobian(&state, 0.0);
/// // A small change of the state is carried to the end of the step.
/// let mut moved = LatentState { latent: state.latent + Latent::repeat(1e-6), ..state };
/// let mut plain = state;
/// model.generic.step(&mut moved, 0.0);
/// model.generic.step(&mut plain, 0.0);
/// let difference = (moved.latent - plain.latent) - jacobian.latent * Latent::repeat(1e-6);
/// assert!(difference.norm() < 1e-10);
/// # Ok::<(), meniscus::blob::LoadError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepJacobian {
    /// dx1/dx.
    pub latent: Square,
    /// dx1/du.
    pub input: Latent,
}

impl Generic<'_> {
    /// Returns the Jacobian of a step from `state` under the port value `u`.
    #[must_use]
    pub fn jacobian(&self, state: &LatentState, u: f64) -> StepJacobian {
        let half_kick = self.port * (0.5 * self.dt_s);
        let start = state.latent + half_kick * u;
        // By the step itself: its parts stay its own.
        let mut next = *state;
        self.step(&mut next, u);
        let end = next.latent - half_kick * u;
        let (from, to) = (self.potential.ridges(&start), self.potential.ridges(&end));
        let (behind, before) = (self.potential.stiffness(&from, &to), self.potential.stiffness(&to, &from));
        let gradient = self.potential.discrete_gradient(&start, &from, &end, &to);
        let (_, flow) = self.flow_at(&start, &state.held, &gradient);
        let right = Square::identity() + flow * before * self.dt_s;
        let mut latent = Square::zeros();
        for (column, known) in latent.data.0.iter_mut().zip(right.data.0) {
            *column = newton::correction(&behind, &flow, self.dt_s, &Latent::from(known)).into();
        }
        StepJacobian { latent, input: latent * half_kick + half_kick }
    }

    /// Returns the rate F grad H(x) + B u of the latents, 1/s, and its slope F H''(x) in them.
    #[must_use]
    pub fn rate(&self, state: &LatentState, u: f64) -> (Latent, Square) {
        let gradient = self.potential.gradient(&state.latent);
        let (flow, slope) = self.flow_at(&state.latent, &state.held, &gradient);
        let ridges = self.potential.ridges(&state.latent);
        // The discrete gradient moves half as much with one of its ends.
        (flow * gradient + self.port * u, slope * self.potential.stiffness(&ridges, &ridges) * 2.0)
    }

    /// F at `x` under the gradient of H, and the slope of F times the gradient in the gradient.
    fn flow_at(&self, x: &Latent, held: &[f64; super::MEMORIES], gradient: &Latent) -> (Square, Square) {
        let flow = match &self.slots {
            Some(slots) => slots.flow(&self.operators, x, held, slots.rate(x).abs(), self.dt_s),
            None => Flow::plain(&self.operators),
        };
        let Some(law) = &self.law else { return (flow.matrix, flow.matrix) };
        (flow.under(law, &self.operators, gradient), flow.slope_under(law, &self.operators, gradient))
    }
}
