//! The running estimate: what the camera saw corrects what the GENERIC step foretold.
//!
//! ```text
//! y = (x, u, u', u'', W, X, Y, Y')     latents; port value now and the two instants before; speed and place of the glass;
//!                                      slosh across its line now and the instant before ([`crate::uncertainty::cross_axis`])
//!
//! x- = step(x, u)                      the exact step, its Jacobian about rest for the covariance
//! u- = 1.4 u - 0.1 u' - 0.45 u'' + e   <e^2> = PUSH^2: how hands and robots move a glass, and no more is supposed of them
//! W- = W + dt^2 g u,  X- = X + W-      g the model's scale of acceleration: X is the place, its second difference g u
//! Y- = k1 Y + k2 Y' + f                <f^2> = (ASIDE kick)^2 + LIVELY^2 (Y^2 + Y'^2): nobody tells when a hand leaves its
//!                                      line, and one that has left it is believed to do so again
//!
//! place of the glass   X     of this frame tells u of the one before, so it is taken before the step
//! 21 heights           decode_i(x, u) + Y_i + e_i,    <e_i^2> = what the profile says of the point + w d_i
//! encoder              x and u of the window,   2 b w R and READ^2
//! ```
//! an extended Kalman filter (Jazwinski, Stochastic Processes and Filtering Theory, 1970) with an unknown input as part of
//! the state (Friedland, IEEE Trans. Automat. Control 14 (1969) 359); w, Q, R and d are those of [`crate::uncertainty::error_model`]. It
//! learns how well the model suits the liquid: what the step misses counts a times, what the encoder misses b times, and
//! both follow the surprise s, the mean of (z - c.y)^2 over its expectation, in every turn by a factor s^RATE (Mehra, IEEE
//! Trans. Automat. Control 17 (1972) 693, has why innovations tell the covariances). Where nobody knows how the glass
//! moves, its place is not taken, and the encoder, which was trained on windows that hold the motion, is not asked.
//!
//! The weights of u-, and everything that stands in capitals, are fields of the [`FilterConfig`] in the blob, where their
//! units and their derivation stand: PUSH `input_noise_std`, ASIDE `lateral_noise_std`, LIVELY `lateral_noise_share`, READ
//! `encoder_input_std`, RATE `adaptation_rate`; the 2 before R is `encoder_noise_factor`.

use crate::blob::{FilterConfig, Model, ScaleBounds};
use crate::filter::covariance::{ALL, Belief, Column, Measured, Wide};
use crate::latent::generic::{LATENTS, Latent};
use crate::math::pow;
use crate::surface::SurfaceProfile;
use crate::uncertainty::cross_axis::Aside;
use crate::uncertainty::discrepancy::LEAST_M2;
use crate::uncertainty::error_model::{Covariance, unknown};
use nalgebra::{Matrix2, SMatrix};

/// Largest glass acceleration that enters the port, as a multiple of the model's scale.
pub const PORT_LIMIT: f64 = 20.0;
/// Least variance of what the encoder reads, in its own deviations: of a blob that claims to know.
const LEAST_READ: f64 = 1e-6;

/// Where u, W, X, Y and Y' stand behind the latents.
const U: usize = LATENTS;
const W: usize = LATENTS + 3;
const X: usize = LATENTS + 4;
const Y: usize = LATENTS + 5;
const Z: usize = LATENTS + 6;

/// The filter's memory; the latents themselves are the state of the step.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Filter {
    belief: Belief,
    /// u, u', u''.
    push: [f64; 3],
    /// W and X, mm.
    glass: [f64; 2],
    /// Y, Y', mm.
    aside: [f64; 2],
    /// a.
    stray: f64,
    /// b.
    doubt: f64,
    /// Whether the prior is that of the model in use.
    primed: bool,
}

impl Default for Filter {
    /// Returns the reference prior; [`Self::prime`] puts that of the model in its place.
    fn default() -> Self {
        Self { primed: false, ..Self::new(&FilterConfig::REFERENCE) }
    }
}

impl Filter {
    /// Returns the prior: nothing is known of liquid, input and glass.
    pub(crate) fn new(config: &FilterConfig) -> Self {
        let still = unknown();
        let mut belief = Belief::new(Wide::from_fn(|i, j| still.get((i, j)).copied().unwrap_or(0.0)));
        for index in U..W {
            belief.set(index, config.input_prior_std * config.input_prior_std);
        }
        for index in Y..ALL {
            belief.set(index, config.lateral_prior_mm * config.lateral_prior_mm);
        }
        let mut filter = Self {
            belief,
            push: [0.0; 3],
            glass: [0.0; 2],
            aside: [0.0; 2],
            stray: 1.0,
            doubt: 1.0,
            primed: true,
        };
        filter.misplace(config);
        filter
    }

    /// Takes the prior of the model in use, once before the first turn: a memory is made without a model.
    pub(crate) fn prime(&mut self, config: &FilterConfig) {
        if !self.primed {
            *self = Self::new(config);
        }
    }

    /// u, the port value of this instant, or of the step to come.
    pub(crate) fn push(&self) -> f64 {
        let [now, ..] = self.push;
        now
    }

    /// Y, and what is known of it.
    pub(crate) fn aside(&self, model: &Model<'_>) -> Aside {
        let [yy, yz, zz] = [(Y, Y), (Y, Z), (Z, Z)].map(|(i, j)| 1e-6 * self.belief.at(i, j));
        Aside {
            stands_m: self.aside.map(|mm| 1e-3 * mm),
            p: Matrix2::new(yy, yz, yz, zz),
            shared: Latent::from_fn(|i, _| 1e-3 * self.belief.at(i, Y)),
            pushed: 1e-6 * self.pushed_aside(model),
        }
    }

    /// <f^2>, mm2.
    fn pushed_aside(&self, model: &Model<'_>) -> f64 {
        let FilterConfig { lateral_noise_std, lateral_noise_share: share, .. } = model.header.filter;
        let (least, [now, before]) = (lateral_noise_std * 1e3 * model.transverse.kick_m, self.aside);
        least * least + share * share * (now * now + before * before)
    }

    /// Y, m.
    pub(crate) fn aside_m(&self) -> f64 {
        let [now, _] = self.aside;
        1e-3 * now
    }

    /// What the intervals are made of.
    pub(crate) fn covariance(&self) -> Covariance {
        Covariance {
            latents: SMatrix::from_fn(|i, j| self.belief.at(i, j)),
            push: self.belief.at(U, U),
            stray: self.stray,
        }
    }

    /// Forgets where the glass is.
    pub(crate) fn misplace(&mut self, config: &FilterConfig) {
        self.glass = [0.0; 2];
        let (travel, position) = (config.travel_prior_mm, config.position_prior_mm);
        self.belief.set(W, travel * travel);
        self.belief.set(X, position * position);
    }

    /// Before the step: the place `x_m` of the glass in the frame behind it.
    pub(crate) fn place(&mut self, model: &Model<'_>, latent: &mut Latent, x_m: f64) {
        let (kick, [speed, place]) = (self.kick_mm(model), self.glass);
        let mut c = Column::zeros();
        for (index, value) in [(U, kick), (W, 1.0), (X, 1.0)] {
            if let Some(slot) = c.get_mut(index) {
                *slot = value;
            }
        }
        let miss = 1e3 * x_m - (place + speed + kick * self.push());
        let FilterConfig { position_noise_mm: noise, position_gate: bound, .. } = model.header.filter;
        let (moved, _) = self.belief.take(&c, Measured { miss, noise: noise * noise, bound });
        self.shift(latent, &moved);
    }

    /// Before or behind the step: the push `u` of this instant as an IMU or the robot tells it.
    pub(crate) fn told(&mut self, config: &FilterConfig, u: f64) {
        let [now, ..] = &mut self.push;
        *now = u;
        self.belief.set(U, config.measured_input_std * config.measured_input_std);
    }

    /// The step from a slosh of energy `slosh`, but for the latents themselves.
    pub(crate) fn predict(&mut self, model: &Model<'_>, slosh: f64) {
        let kick = self.kick_mm(model);
        let transposed = self.transposed(model, kick);
        let missed = self.stray * model.spread.weight(slosh);
        let aside = self.pushed_aside(model);
        let config = &model.header.filter;
        let noise = |i: usize, j: usize| match model.spread.process.get((i, j)) {
            Some(q) if i < LATENTS => missed * q,
            _ if i == U && j == U => config.input_noise_std * config.input_noise_std,
            _ if i == Y && j == Y => aside,
            _ => 0.0,
        };
        self.belief.step(&transposed, noise);
        let [speed, place] = self.glass;
        let speed = speed + kick * self.push();
        self.glass = [speed, place + speed];
        let [now, before, _] = self.push;
        let next = config.input_recursion.iter().zip(self.push).map(|(c, u)| c * u).sum();
        self.push = [next, now, before];
        self.aside = model.transverse.next(self.aside);
    }

    /// G^T: an entry for each number behind the step (column) and before it (row).
    fn transposed(&self, model: &Model<'_>, kick: f64) -> Wide {
        let port = model.generic.port * model.generic.dt_s;
        let weights = &model.header.filter.input_recursion;
        Wide::from_fn(|before, behind| match (behind, before) {
            _ if behind < LATENTS && before < LATENTS => {
                model.spread.transition.get((behind, before)).copied().unwrap_or(0.0)
            }
            (_, U) if behind < LATENTS => port.get(behind).copied().unwrap_or(0.0),
            (U, _) => before.checked_sub(U).and_then(|k| weights.get(k)).copied().unwrap_or(0.0),
            (W | X, U) => kick,
            (W, W) | (X, W | X) => 1.0,
            (Y, Y..) => {
                before.checked_sub(Y).and_then(|k| model.transverse.keeps.get(k)).copied().unwrap_or(0.0)
            }
            (Z, Y) => 1.0,
            _ if behind > U && behind < W && before + 1 == behind => 1.0,
            _ => 0.0,
        })
    }

    /// dt^2 g, mm: what a unit of the port adds to W.
    fn kick_mm(&self, model: &Model<'_>) -> f64 {
        1e3 * model.generic.dt_s * model.generic.dt_s * f64::from(model.header.acceleration_scale)
    }

    /// Takes the seen heights of `profile`, the surface of a slosh of energy `slosh`; `settled` says whether a and b
    /// may follow. Whether it came to something finite: if not, all is forgotten.
    pub(crate) fn heights(
        &mut self,
        model: &Model<'_>,
        latent: &mut Latent,
        profile: &SurfaceProfile,
        (slosh, settled): (f64, bool),
    ) -> bool {
        let (spread, decoder, config) = (&model.spread, &model.decoder, &model.header.filter);
        let x: [f64; LATENTS] = (*latent).into();
        let x = x.map(|x| x as f32);
        let said = decoder.surface(&decoder.coefficients(&x, self.push() as f32));
        let (slopes, pushed) = (decoder.surface_slope(&x), decoder.pushed());
        let w = spread.weight(slosh);
        let (mut moved, mut surprise, mut seen) = (Column::zeros(), 0.0, 0.0);
        let points = profile.height_m.iter().zip(&profile.variance_m2).zip(&profile.valid);
        let aside = model.transverse.shape.map(|shape| 1e-3 * shape);
        let [y, _] = self.aside;
        let known = said.iter().zip(&pushed).zip(spread.surface_misfit).zip(&aside);
        for (point, (((z, variance), valid), (((said, f), d), across))) in points.zip(known).enumerate() {
            if !valid {
                continue;
            }
            let slope = |i: usize| slopes.get(i).and_then(|s| s.get(point));
            let c = Column::from_fn(|i, _| match slope(i) {
                Some(slope) => f64::from(*slope),
                None if i == U => f64::from(*f),
                None if i == Y => *across,
                None => 0.0,
            });
            let miss = f64::from(*z) - f64::from(*said) - across * y - c.dot(&moved);
            let noise = f64::from(*variance).max(LEAST_M2) + (w * f64::from(*d)).max(0.0);
            let bound = config.innovation_gate;
            let (step, of_one) = self.belief.take(&c, Measured { miss, noise, bound });
            moved += step;
            surprise += of_one;
            seen += 1.0;
        }
        if settled && seen > 0.0 {
            self.stray = follow(self.stray, surprise / seen, config, config.process_noise_scale);
        }
        self.accept(config, latent, &moved)
    }

    /// Takes what the encoder read, behind the heights; else as [`Self::heights`].
    pub(crate) fn reading(
        &mut self,
        model: &Model<'_>,
        latent: &mut Latent,
        (read, port): (&Latent, f64),
        (slosh, settled): (f64, bool),
    ) -> bool {
        let (whiten, config) = (&model.spread.reading, &model.header.filter);
        let noise = (config.encoder_noise_factor * self.doubt * model.spread.weight(slosh)).max(LEAST_READ);
        let innovation = whiten * (read - *latent);
        let (mut moved, mut surprise) = (Column::zeros(), 0.0);
        let bound = config.innovation_gate;
        for (row, miss) in whiten.row_iter().zip(innovation.iter()) {
            let c = Column::from_fn(|i, _| row.get(i).copied().unwrap_or(0.0));
            let (step, of_one) = self.belief.take(&c, Measured { miss: miss - c.dot(&moved), noise, bound });
            moved += step;
            surprise += of_one;
        }
        let c = Column::from_fn(|i, _| f64::from(u8::from(i == U)));
        let miss = port - self.push() - c.dot(&moved);
        moved += self
            .belief
            .take(&c, Measured { miss, noise: config.encoder_input_std * config.encoder_input_std, bound })
            .0;
        if settled {
            let of_one = surprise / LATENTS as f64;
            self.doubt = follow(self.doubt, of_one, config, config.measurement_noise_scale);
        }
        self.accept(config, latent, &moved)
    }

    /// Moves the estimate, unless that is no number: then all is forgotten.
    fn accept(&mut self, config: &FilterConfig, latent: &mut Latent, moved: &Column) -> bool {
        let finite = moved.iter().all(|v| v.is_finite()) && self.belief.is_finite();
        if finite {
            self.shift(latent, moved);
        } else {
            // A hostile blob, or a height that is no number.
            *self = Self::new(config);
        }
        finite
    }

    fn shift(&mut self, latent: &mut Latent, moved: &Column) {
        let mut moved = moved.iter();
        let here = latent.iter_mut().chain(&mut self.push).chain(&mut self.glass).chain(&mut self.aside);
        here.zip(&mut moved).for_each(|(y, step)| *y += step);
        for u in &mut self.push {
            *u = u.clamp(-PORT_LIMIT, PORT_LIMIT);
        }
    }
}

/// `factor` moved by `surprise`, one where the covariances are right, within its bounds.
fn follow(factor: f64, surprise: f64, config: &FilterConfig, bounds: ScaleBounds) -> f64 {
    let moved = factor * pow(surprise.max(f64::MIN_POSITIVE), config.adaptation_rate);
    moved.max(bounds.min).min(bounds.max)
}

const _: () = assert!(Z + 1 == ALL);
