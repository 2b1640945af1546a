//! State and step of the filter: camera measurements correct what the GENERIC step predicted.
//!
//! ```text
//! y = (x, u, u', u'', W, X, Y, Y')     latents; input now and at the two instants before; travel in a turn and position of
//!                                      the glass; cross-axis slosh now and the instant before ([`crate::uncertainty::cross_axis`])
//!
//! x- = step(x, u)                      the exact step, its Jacobian about rest for the covariance
//! u- = 1.4 u - 0.1 u' - 0.45 u'' + e   <e^2> = PUSH^2: how hands and robots move a glass, and no more is supposed of them
//! W- = W + dt^2 g u,  X- = X + W-      g the model's scale of acceleration: X is the position, its second difference g u
//! Y- = k1 Y + k2 Y' + f                <f^2> = (ASIDE kick)^2 + LIVELY^2 (Y^2 + Y'^2): no sensor reports when a hand leaves its
//!                                      line, and one that has left it is assumed to do so again
//!
//! position of the glass   X     of this frame determines u of the one before, so it is processed before the step
//! 21 heights              decode_i(x, u) + Y_i + e_i,    <e_i^2> = the point's own variance + w d_i
//! encoder                 x and u of the window,   2 b w R and READ^2
//! ```
//! an extended Kalman filter (Jazwinski, Stochastic Processes and Filtering Theory, 1970) with an unknown input as part of
//! the state (Friedland, IEEE Trans. Automat. Control 14 (1969) 359); w, Q, R and d are those of
//! [`crate::uncertainty::error_model`]. It adapts to the liquid: the process noise Q counts a times, the encoder's R counts b
//! times, and in every turn both follow the mean normalised innovation squared s by a factor s^RATE (Mehra, IEEE Trans.
//! Automat. Control 17 (1972) 693, has why innovations determine the covariances). Where the motion of the glass is not
//! observed, its position is not used, and neither is the encoder, which was trained on windows that hold the motion.
//!
//! The weights of u-, and everything in capitals, are fields of the [`FilterConfig`] in the blob, where their units and
//! their derivation stand: PUSH `input_noise_std`, ASIDE `lateral_noise_std`, LIVELY `lateral_noise_share`, READ
//! `encoder_input_std`, RATE `adaptation_rate`; the 2 before R is `encoder_noise_factor`.

use super::covariance::ErrorCovariance;
use super::state::{STATES, StateIndex, StateMatrix, StateVector};
use crate::blob::{FilterConfig, Model};
use crate::latent::generic::{LATENTS, Latent};
use crate::real::{Real, narrow};
use crate::uncertainty::cross_axis::LateralState;
use crate::uncertainty::error_model::{Covariance, unknown};
use nalgebra::{Matrix2, SMatrix};

/// Largest glass acceleration that enters the port, as a multiple of the model's scale.
pub const PORT_LIMIT: f64 = 20.0;

/// Covariance of the latents and of the input.
pub(crate) type JointCovariance = SMatrix<f64, { LATENTS + 1 }, { LATENTS + 1 }>;

const _: () = assert!(StateIndex::Input.index() == LATENTS, "`JointCovariance` takes the input from there");

/// Memory of the filter; the latents themselves are the state of the step.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Filter {
    pub(super) covariance: ErrorCovariance,
    /// u, u', u''.
    pub(super) input: [f64; 3],
    /// W and X, mm.
    pub(super) glass_mm: [f64; 2],
    /// Y, Y', mm.
    pub(super) lateral_mm: [f64; 2],
    /// a.
    pub(super) process_noise_scale: f64,
    /// b.
    pub(super) measurement_noise_scale: f64,
    /// Whether the prior is that of the model in use.
    pub(super) primed: bool,
}

impl Default for Filter {
    /// Returns the reference prior; [`Self::prime`] replaces it by that of the model.
    fn default() -> Self {
        Self { primed: false, ..Self::new(&FilterConfig::REFERENCE) }
    }
}

impl Filter {
    /// Returns the prior: nothing is known of liquid, input and glass.
    pub(crate) fn new(config: &FilterConfig) -> Self {
        let latents = unknown();
        let prior = StateMatrix::from_fn(|i, j| latents.get((i, j)).copied().unwrap_or(0.0));
        let mut covariance = ErrorCovariance::new(prior);
        let (input, lateral) = (config.input_prior_std, config.lateral_prior_mm);
        for index in [StateIndex::Input, StateIndex::InputLag1, StateIndex::InputLag2] {
            covariance.set_variance(index, input * input);
        }
        for index in [StateIndex::Lateral, StateIndex::LateralLag] {
            covariance.set_variance(index, lateral * lateral);
        }
        let mut filter = Self {
            covariance,
            input: [0.0; 3],
            glass_mm: [0.0; 2],
            lateral_mm: [0.0; 2],
            process_noise_scale: 1.0,
            measurement_noise_scale: 1.0,
            primed: true,
        };
        filter.reset_position(config);
        filter
    }

    /// Replaces the reference prior by that of the model, once before the first turn: a memory is made without a model.
    pub(crate) fn prime(&mut self, config: &FilterConfig) {
        if !self.primed {
            *self = Self::new(config);
        }
    }

    /// u: the input of this instant, or of the step to come.
    pub(crate) fn input(&self) -> f64 {
        let [now, ..] = self.input;
        now
    }

    /// Y, m.
    pub(crate) fn lateral_m(&self) -> f64 {
        let [now, _] = self.lateral_mm;
        1e-3 * now
    }

    /// Cross-axis slosh with its error, SI units.
    pub(crate) fn lateral(&self, model: &Model<'_>) -> LateralState {
        use StateIndex::{Lateral, LateralLag};
        let [yy, yz, zz] = [(Lateral, Lateral), (Lateral, LateralLag), (LateralLag, LateralLag)]
            .map(|(i, j)| 1e-6 * self.covariance.between(i, j));
        LateralState {
            amplitude_m: self.lateral_mm.map(|mm| 1e-3 * mm),
            covariance: Matrix2::new(yy, yz, yz, zz),
            latent_covariance: Latent::from_fn(|i, _| 1e-3 * self.covariance.at(i, Lateral.index())),
            noise: 1e-6 * self.lateral_noise_mm2(model),
        }
    }

    /// <f^2>, mm2.
    fn lateral_noise_mm2(&self, model: &Model<'_>) -> f64 {
        let FilterConfig { lateral_noise_std, lateral_noise_share: share, .. } = model.header.filter;
        let (least, [now, before]) = (lateral_noise_std * 1e3 * model.cross_axis.kick_m, self.lateral_mm);
        least * least + share * share * (now * now + before * before)
    }

    /// Error covariance as the intervals need it.
    pub(crate) fn covariance(&self) -> Covariance {
        Covariance {
            latents: SMatrix::from_fn(|i, j| self.covariance.at(i, j)),
            input: self.covariance.between(StateIndex::Input, StateIndex::Input),
            process_noise_scale: self.process_noise_scale,
        }
    }

    /// Joint error covariance of the latents and of the input of this instant.
    pub(crate) fn latents_and_input(&self) -> JointCovariance {
        // The input stands right behind the latents.
        JointCovariance::from_fn(|i, j| self.covariance.at(i, j))
    }

    /// Forgets the position and the travel of the glass.
    pub(crate) fn reset_position(&mut self, config: &FilterConfig) {
        self.glass_mm = [0.0; 2];
        let (travel, position) = (config.travel_prior_mm, config.position_prior_mm);
        self.covariance.set_variance(StateIndex::GlassTravel, travel * travel);
        self.covariance.set_variance(StateIndex::GlassPosition, position * position);
    }

    /// Sets the input `u` of this instant to what an IMU or a robot states, before or behind the step.
    pub(crate) fn set_known_input(&mut self, config: &FilterConfig, u: f64) {
        let [now, ..] = &mut self.input;
        *now = u;
        self.covariance
            .set_variance(StateIndex::Input, config.measured_input_std * config.measured_input_std);
    }

    /// Predicts everything but the latents, from a slosh of energy `latent_energy` in units of H.
    pub(crate) fn predict<R: Real>(&mut self, model: &Model<'_>, latent_energy: f64) {
        let config = &model.header.filter;
        let gain = travel_gain_mm(model);
        let transposed = narrow::<R, _, _>(&transposed_transition(model, gain));
        let process = self.process_noise_scale * model.error_model.weight(latent_energy);
        let lateral = self.lateral_noise_mm2(model);
        let (input_index, lateral_index) = (StateIndex::Input.index(), StateIndex::Lateral.index());
        let noise = |i: usize, j: usize| match model.error_model.process.get((i, j)) {
            Some(q) => process * q,
            _ if i == input_index && j == input_index => config.input_noise_std * config.input_noise_std,
            _ if i == lateral_index && j == lateral_index => lateral,
            _ => 0.0,
        };
        self.covariance.lend::<R, _>(|mut p| p.step(&transposed, noise));
        let [travel, position] = self.glass_mm;
        let travel = travel + gain * self.input();
        self.glass_mm = [travel, position + travel];
        let [now, before, _] = self.input;
        let next = config.input_recursion.iter().zip(self.input).map(|(c, u)| c * u).sum();
        self.input = [next, now, before];
        self.lateral_mm = model.cross_axis.next(self.lateral_mm);
    }

    /// Adds a correction to the estimate; inputs stay within [`PORT_LIMIT`].
    pub(super) fn shift(&mut self, latent: &mut Latent, moved: &StateVector) {
        let mut moved = moved.iter();
        let state =
            latent.iter_mut().chain(&mut self.input).chain(&mut self.glass_mm).chain(&mut self.lateral_mm);
        state.zip(&mut moved).for_each(|(y, step)| *y += step);
        for u in &mut self.input {
            *u = u.clamp(-PORT_LIMIT, PORT_LIMIT);
        }
    }
}

/// dt^2 g, mm: what a unit of the input adds to the travel W.
pub(super) fn travel_gain_mm(model: &Model<'_>) -> f64 {
    1e3 * model.generic.dt_s * model.generic.dt_s * f64::from(model.header.acceleration_scale)
}

/// G^T: an entry for each number behind the step (column) and before it (row).
fn transposed_transition(model: &Model<'_>, travel_gain: f64) -> StateMatrix {
    use StateIndex::{GlassPosition, GlassTravel, Input, InputLag1, InputLag2, Lateral, LateralLag};
    let port = model.generic.port * model.generic.dt_s;
    let [u0, u1, u2] = model.header.filter.input_recursion;
    let [k1, k2] = model.cross_axis.recursion;
    StateMatrix::from_fn(|before, behind| match (StateIndex::at(behind), StateIndex::at(before)) {
        (None, None) => model.error_model.transition.get((behind, before)).copied().unwrap_or(0.0),
        (None, Some(Input)) => port.get(behind).copied().unwrap_or(0.0),
        (Some(Input), Some(Input)) => u0,
        (Some(Input), Some(InputLag1)) => u1,
        (Some(Input), Some(InputLag2)) => u2,
        (Some(GlassTravel | GlassPosition), Some(Input)) => travel_gain,
        (Some(Lateral), Some(Lateral)) => k1,
        (Some(Lateral), Some(LateralLag)) => k2,
        (Some(InputLag1), Some(Input)) | (Some(InputLag2), Some(InputLag1)) => 1.0,
        (Some(GlassTravel | GlassPosition), Some(GlassTravel)) => 1.0,
        (Some(GlassPosition), Some(GlassPosition)) => 1.0,
        (Some(LateralLag), Some(Lateral)) => 1.0,
        _ => 0.0,
    })
}

const _: () = assert!(STATES == LATENTS + 3 + 2 + 2, "`Filter::shift` chains all numbers of the state");
