//! Where nobody knows how the glass moves: latents and push are found together, from the heights alone.
//!
//! ```text
//! x- = step(x, u)          u- = RHO u + w,  <w^2> = PUSH^2             u the port value, of which nothing else is known
//! z_i = decode_i(x, u) + e_i,    <e_i^2> = what the profile says of its point + w d_i of [`crate::interval`]
//! ```
//! is an extended Kalman filter over (x, u) (Jazwinski, Stochastic Processes and Filtering Theory, 1970; the unknown input as
//! a state: Friedland, IEEE Trans. Automat. Control 14 (1969) 359): the exact step predicts x, the Jacobian about rest
//! carries the covariance, and the heights are taken one by one,
//!
//! ```text
//! K = P c / (c.P c + r),     (x, u) += K (z_i - z_i-),     P -= K (P c)^T                  c = (J_i, F_i)
//! ```
//! The encoder is not asked: it was trained on windows that hold the motion. RHO and PUSH were chosen on the two
//! validation recordings of the shipped model, with 0.4 mm of noise on every height; twice or half of PUSH costs a
//! tenth of the error.

use crate::generic::{LATENTS, Latent, State};
use crate::interval::Covariance;
use crate::model::Model;
use crate::surface::SurfaceProfile;
use nalgebra::{SMatrix, SVector};

/// Latents and the push.
const ALL: usize = LATENTS + 1;

type Wide = SMatrix<f64, ALL, ALL>;
type Column = SVector<f64, ALL>;

/// What a push keeps of itself from turn to turn.
const RHO: f64 = 0.9;

/// Deviation of what comes new to it in a turn, in units of the port.
const PUSH: f64 = 0.2;

/// Least variance of a height, m2: that of 0.1 mm.
const LEAST_M2: f64 = 1e-8;

/// The filter's memory.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Blind {
    /// P over (x, u), once it has begun.
    covariance: Option<Wide>,
    /// u.
    push: f64,
}

impl Blind {
    /// u, the port value of the step to come.
    pub(super) fn push(&self) -> f64 {
        self.push
    }

    /// P- behind a step from a slosh of energy `slosh`; `before` is what was known of the latents.
    pub(super) fn predict(&mut self, model: &Model<'_>, before: &Covariance, slosh: f64) {
        let spread = &model.spread;
        let kick = model.generic.port * model.generic.dt_s;
        let still = PUSH * PUSH / (1.0 - RHO * RHO);
        let p = self.covariance.unwrap_or_else(|| joined(before.matrix(), still));
        let step = Wide::from_fn(|i, j| match (i < LATENTS, j < LATENTS) {
            (true, true) => spread.transition.get((i, j)).copied().unwrap_or(0.0),
            (true, false) => kick.get(i).copied().unwrap_or(0.0),
            (false, true) => 0.0,
            (false, false) => RHO,
        });
        let next =
            step * p * step.transpose() + joined(&(spread.process * spread.weight(slosh)), PUSH * PUSH);
        self.covariance = next.iter().all(|v| v.is_finite()).then_some(next);
        self.push *= RHO;
    }

    /// Takes the seen heights of `profile` into `state` and the push; gives the covariance of the latents behind it.
    pub(super) fn correct(
        &mut self,
        model: &Model<'_>,
        state: &mut State,
        profile: &SurfaceProfile,
        slosh: f64,
    ) -> Option<Covariance> {
        let mut p = self.covariance?;
        let (spread, decoder) = (&model.spread, &model.decoder);
        let latent: [f64; LATENTS] = state.latent.into();
        let said = decoder.surface(&decoder.coefficients(&latent.map(|x| x as f32), self.push as f32));
        let pushed = decoder.pushed();
        let w = spread.weight(slosh);
        let mut moved = Column::zeros();
        let points = profile.height_m.iter().zip(&profile.variance_m2).zip(&profile.valid);
        let known = said.iter().zip(&pushed).zip(spread.surface_misfit).zip(spread.surface.column_iter());
        for (((z, variance), valid), (((said, f), d), j)) in points.zip(known) {
            if !valid {
                continue;
            }
            let c = Column::from_fn(|i, _| j.get(i).copied().unwrap_or(f64::from(*f)));
            let pc = p * c;
            let noise = f64::from(*variance).max(LEAST_M2) + w * f64::from(*d);
            let gain = pc / (c.dot(&pc) + noise);
            let miss = f64::from(*z) - f64::from(*said) - c.dot(&moved);
            moved += gain * miss;
            p -= gain * pc.transpose();
        }
        let p = (p + p.transpose()) * 0.5;
        if !moved.iter().chain(p.iter()).all(|v| v.is_finite()) {
            // A hostile blob: what is not finite says as much as knowing nothing.
            *self = Self::default();
            return None;
        }
        self.covariance = Some(p);
        state.latent += Latent::from_fn(|i, _| moved.get(i).copied().unwrap_or(0.0));
        self.push += moved.get(LATENTS).copied().unwrap_or(0.0);
        let own = SMatrix::from_fn(|i, j| p.get((i, j)).copied().unwrap_or(0.0));
        Some(Covariance::new(own))
    }
}

/// A covariance of latents and push that know nothing of one another.
fn joined(latents: &SMatrix<f64, LATENTS, LATENTS>, push: f64) -> Wide {
    Wide::from_fn(|i, j| {
        let corner = if i == j { push } else { 0.0 };
        let inside = i < LATENTS && j < LATENTS;
        if inside { latents.get((i, j)).copied().unwrap_or(0.0) } else { corner }
    })
}
