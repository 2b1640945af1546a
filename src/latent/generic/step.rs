//! The time step: half a kick by the port, one closed step with the discrete gradient, half a kick.
//!
//! ```text
//! x~ = x  + dt/2 B u
//! x^ = x~ + dt (L - D) dH(x~, x^)                                   s1 = s + H(x~) - H(x^)
//! x1 = x^ + dt/2 B u                 work = [H(x~) - H(x)] + [H(x1) - H(x^)]
//! ```
//! with the discrete gradient dH, the mean of grad H between its ends: dH . (b - a) = H(b) - H(a), so that a solved
//! closed step has H(x^) - H(x~) = -dt dH^T D dH <= 0: heat is never negative. The splitting (Strang 1968) keeps the
//! port's work out of that inequality.
//!
//! There is exactly one solution, for all weights: the derivative of dH(a, b) by b is S = int s grad^2 H ds >= 0, as H
//! is convex, and (L - D) S has no eigenvalue with a positive real part, so that 1 - dt (L - D) S is regular
//! everywhere; and as the ridges of H have bounded slopes, b - dt (L - D) dH(a, b) grows with b (Hadamard's theorem).
//!
//! Under a [`FrictionLaw`] D is phi D, with phi at dH. The force phi D dH is the slope of a convex potential, so that (L - phi D) dH
//! falls with dH as (L - D) dH does, and there is one solution as before. Newton's corrections take phi as it stands: with the slope of phi
//! they may circle about a yield stress, without it each leaves a part of the last that is below one.
//!
//! A solved step of a model with next to no friction can end a rounding error above H(x~); it is nudged down along
//! grad H by that little. A hostile blob may overflow or leave Newton's iteration circling: then the result is
//! shortened towards x~, where the inequality holds trivially, and the audit says so.

use super::flow::Flow;
use super::newton::SquareOf;
use super::slots::{MEMORIES, Slots};
use super::{Audit, FrictionLaw, Latent, LatentOf, Operators, Potential, RidgeState, StepOutcome, newton};
use crate::latent::nn::Matrix;
use crate::real::{Real, narrow, widen};
use nalgebra::SMatrix;

/// Iterations with the constant preconditioner, a tenth of the work of Newton's.
const CHEAP_ITERATIONS: u32 = 12;

/// Iterations after which the implicit equation is left as it is.
const MAX_ITERATIONS: u32 = 32;

/// Halvings of a step that would raise the energy, before it is dropped.
const MAX_HALVINGS: u32 = 40;

/// Nudges before a step is shortened after all.
const MAX_NUDGES: u32 = 4;

/// A trained GENERIC model.
///
/// ```
/// # #[repr(align(64))]
/// # struct Aligned<T: ?Sized>(T);
/// # static BLOB: &Aligned<[u8]> =
/// #     &Aligned(*include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/models/glycerine.blob")));
/// let model = meniscus::blob::Model::load(&BLOB.0)?;
/// use meniscus::latent::generic::{Latent, LatentState};
///
/// let mut state = LatentState { latent: Latent::repeat(0.3), ..LatentState::default() };
/// let before = model.generic.energy(&state);
/// // A glass that stands still does no work: the energy stays, and what motion loses becomes heat.
/// let audit = model.generic.step(&mut state, 0.0);
/// assert!(audit.heat >= 0.0);
/// assert!((model.generic.energy(&state) - before).abs() < 1e-9 * before);
/// # Ok::<(), meniscus::blob::LoadError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Generic<'m> {
    /// H.
    pub potential: Potential<'m>,
    /// L and D.
    pub operators: Operators,
    /// B, `[LATENTS, 1]`.
    pub port: Latent,
    /// Approximate inverse of the Jacobian of the implicit equation; wrong values cost iterations.
    pub preconditioner: Matrix<'m>,
    /// dt in seconds.
    pub dt_s: f64,
    /// Named effects; none where the step is as it was trained.
    pub slots: Option<Slots>,
    /// Dependence of friction on the rate of shear; none where it does not depend on it.
    pub law: Option<FrictionLaw>,
}

/// The memory of the model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LatentState {
    /// x.
    pub latent: Latent,
    /// s, in units of H.
    pub heat: f64,
    /// Memory variables of the embedded effects, m.
    pub held: [f64; MEMORIES],
}

impl Default for LatentState {
    /// Rest.
    fn default() -> Self {
        Self { latent: SMatrix::zeros(), heat: 0.0, held: [0.0; MEMORIES] }
    }
}

impl Generic<'_> {
    /// H(x) + s, with what memories hold.
    #[must_use]
    pub fn energy(&self, state: &LatentState) -> f64 {
        self.potential.value(&state.latent) + state.heat + self.stored(&state.held)
    }

    /// Energy of the memories, in units of H.
    fn stored(&self, held: &[f64; MEMORIES]) -> f64 {
        self.slots.as_ref().map_or(0.0, |slots| slots.stored(held))
    }

    /// Advances `state` by one time step under the port value `u`.
    pub fn step(&self, state: &mut LatentState, u: f64) -> Audit {
        self.step_in::<f64>(state, u)
    }

    /// [`Self::step`] in the precision `R`. The books are those of the energies as that precision has them.
    pub fn step_in<R: Real>(&self, state: &mut LatentState, u: f64) -> Audit {
        let half_kick = narrow::<R, _, _>(&(self.port * (0.5 * self.dt_s * u)));
        let x = narrow::<R, _, _>(&state.latent);
        let before = self.potential.value(&x).wide();
        let kicked = x + half_kick;
        let closed = self.relaxed(&kicked, &state.held);
        let x1 = closed.end + half_kick;
        let after = self.potential.value(&x1).wide();
        let x1 = widen(&x1);
        let (held, kept) = (closed.held, self.stored(&closed.held) - self.stored(&state.held));
        let heat = closed.energy_start - closed.energy_end - kept;
        let work = (closed.energy_start - before) + (after - closed.energy_end);
        let next = LatentState { latent: x1, heat: state.heat + heat, held };
        let numbers = x1.iter().chain(&held);
        let finite = numbers.copied().all(f64::is_finite) && next.heat.is_finite() && work.is_finite();
        if !finite {
            return Audit { iterations: closed.iterations, outcome: StepOutcome::Held, ..Audit::default() };
        }
        let energy_residual = ((after + next.heat) - (before + state.heat) + kept) - work;
        *state = next;
        Audit { work, heat, energy_residual, iterations: closed.iterations, outcome: closed.outcome }
    }

    /// Returns the step without the port from `a`, with the forces of the effects there. Where a branch relaxes by its path
    /// length, r belongs to the speed in the middle of the step, which a step with r at its start predicts.
    fn relaxed<R: Real>(&self, a: &LatentOf<R>, held: &[f64; MEMORIES]) -> Closed<R> {
        let Some(slots) = &self.slots else {
            return self.closed_step(a, held, &Flow::plain(&self.operators), 0.0);
        };
        let dt = self.dt_s;
        let start = widen(a);
        let mut speed = slots.rate(&start).abs();
        if slots.slides() {
            let flow = slots.flow(&self.operators, &start, held, speed, dt);
            let trial = self.closed_step(a, held, &flow, speed);
            speed = 0.5 * (speed + slots.rate(&widen(&trial.end)).abs());
        }
        self.closed_step(a, held, &slots.flow(&self.operators, &start, held, speed, dt), speed)
    }

    /// The closed step under `flow`: from `a` to an end whose energy, memories included, is not above that of `a`.
    fn closed_step<R: Real>(
        &self,
        a: &LatentOf<R>,
        held: &[f64; MEMORIES],
        flow: &Flow,
        speed: f64,
    ) -> Closed<R> {
        let (mut matrix, pull) = (narrow::<R, _, _>(&flow.matrix), narrow::<R, _, _>(&flow.pull));
        let energy_start = self.potential.value(a).wide();
        let scale = a.dot(a);
        let from = self.potential.ridges(a);
        let (mut b, mut to) = (*a, from);
        let mut outcome = StepOutcome::Unconverged;
        let mut iterations = 0;
        let mut gradient = LatentOf::zeros();
        while iterations < MAX_ITERATIONS {
            iterations += 1;
            gradient = self.potential.discrete_gradient(a, &from, &b, &to);
            if let Some(law) = &self.law {
                matrix = narrow(&flow.under(law, &self.operators, &widen(&gradient)));
            }
            let residual = b - a - (matrix * gradient - pull) * R::of(self.dt_s);
            if residual.dot(&residual) <= R::of(R::SOLVED) * scale {
                outcome = StepOutcome::Solved;
                break;
            }
            b -= self.correction(&residual, iterations, &matrix, &from, &to);
            to = self.potential.ridges(&b);
        }
        let remembered =
            self.slots.as_ref().map(|slots| slots.remember(held, &widen(&gradient), speed, self.dt_s));
        let (after, heat) = remembered.unwrap_or((*held, 0.0));
        let most = energy_start + self.stored(held) - self.stored(&after) - heat;
        let energy_b = self.potential.value(&b).wide();
        match self.nudge(b, energy_b, most) {
            Some((end, energy_end)) => {
                Closed { end, held: after, energy_start, energy_end, iterations, outcome }
            }
            None => self.backtrack(a, held, b, energy_start, iterations),
        }
    }

    /// Returns the correction of the `turn`-th iteration for `residual`: by the constant matrix while there is hope in
    /// it, then Newton's.
    fn correction<R: Real>(
        &self,
        residual: &LatentOf<R>,
        turn: u32,
        flow: &SquareOf<R>,
        from: &RidgeState<R>,
        to: &RidgeState<R>,
    ) -> LatentOf<R> {
        if turn > CHEAP_ITERATIONS || self.slots.is_some() || self.law.is_some() {
            let stiffness = self.potential.stiffness(from, to);
            return newton::correction(&stiffness, flow, self.dt_s, residual);
        }
        let mut correction = LatentOf::zeros();
        self.preconditioner.accumulate_exact(residual.as_slice(), correction.as_mut_slice());
        correction
    }

    /// Moves `b` down along grad H until its energy is not above `most`; `None` if it is too far above.
    fn nudge<R: Real>(&self, mut b: LatentOf<R>, mut energy: f64, most: f64) -> Option<(LatentOf<R>, f64)> {
        let mut reach = 2.0;
        for _ in 0..=MAX_NUDGES {
            if energy <= most {
                return Some((b, energy));
            }
            let rise = energy - most;
            let gradient = self.potential.gradient(&b);
            let square = gradient.dot(&gradient).wide();
            let small = rise <= R::NUDGE * most.abs() && square > f64::MIN_POSITIVE;
            if !small {
                return None;
            }
            // To first order this lands as far below as `b` was above; where that is less than the
            // spacing of the numbers around `b` nothing moves, so each nudge reaches farther.
            b -= gradient * R::of(reach * rise / square);
            reach *= 8.0;
            energy = self.potential.value(&b).wide();
        }
        None
    }

    /// Halves the step towards `a` until the energy does not rise; a step that is not finite is dropped.
    /// Memories stay as they were.
    fn backtrack<R: Real>(
        &self,
        a: &LatentOf<R>,
        held: &[f64; MEMORIES],
        end: LatentOf<R>,
        energy_start: f64,
        iterations: u32,
    ) -> Closed<R> {
        let (mut delta, outcome) = (end - a, StepOutcome::Backtracked);
        for _ in 0..MAX_HALVINGS {
            delta *= R::from(0.5);
            let end = a + delta;
            let energy_end = self.potential.value(&end).wide();
            if energy_end <= energy_start {
                return Closed { end, held: *held, energy_start, energy_end, iterations, outcome };
            }
        }
        Closed { end: *a, held: *held, energy_start, energy_end: energy_start, iterations, outcome }
    }
}

/// Result of the closed step.
struct Closed<R> {
    end: LatentOf<R>,
    held: [f64; MEMORIES],
    energy_start: f64,
    energy_end: f64,
    iterations: u32,
    outcome: StepOutcome,
}

#[cfg(test)]
mod tests;
