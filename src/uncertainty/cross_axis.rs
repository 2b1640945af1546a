//! Cross-axis mode: slosh across the line along which the model was trained.
//!
//! A glass is round, so the liquid moves towards the camera and back as it moves along x: the first antisymmetric
//! mode, J1(1.84 r / R) times cosine or sine of the azimuth (Ibrahim, Liquid Sloshing Dynamics, 2005), rings alike in both.
//! On the wall that faces the camera, y = -R sqrt(1 - s^2), it stands as
//!
//! ```text
//! along x: z - h = A s        across it: z - h = Y sqrt(1 - s^2),     s = x / R
//! ```
//! A(n), the slope of the surface after one unit of the port, is read off the model's own linearised step, and the
//! numbers k1, k2 of Y(n+1) = k1 Y(n) + k2 Y(n-1) + f are those that predict it best.

use crate::latent::generic::{LATENTS, Latent, LatentOf};
use crate::math::sqrt;
use crate::real::{Real, narrow};
use crate::surface::{POINTS, SurfaceProfile, profile_abscissa};
use nalgebra::{Matrix2, SMatrix};

/// Turns after which the higher modes of a response have died out.
const SETTLED: usize = 8;

/// Turns behind them that are predicted: half a second, nearly two periods of the first mode of the trained glass (3.6 Hz).
const TURNS: usize = 30;

/// The first mode across the line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CrossAxisMode {
    /// sqrt(1 - s^2) at the profile's points.
    pub shape: [f64; POINTS],
    /// k1, k2.
    pub recursion: [f64; 2],
    /// Largest A after one unit of the port, m.
    pub kick_m: f64,
}

/// Cross-axis amplitude at an instant, with its error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LateralState {
    /// Y now and the turn before, m.
    pub(crate) amplitude_m: [f64; 2],
    /// Covariance of their errors, m2.
    pub(crate) covariance: Matrix2<f64>,
    /// Covariance of the error of Y with those of the latents, m.
    pub(crate) latent_covariance: Latent,
    /// <f^2>, m2.
    pub(crate) noise: f64,
}

impl CrossAxisMode {
    /// The mode of a model whose latents move by `kick` (`B dt`) under one unit of the port and by `transition` in a turn
    /// about rest, and whose surface moves with them by `surface`, m; one that forgets at once where no mode dies out.
    pub(crate) fn of(
        kick: Latent,
        transition: &SMatrix<f64, LATENTS, LATENTS>,
        surface: &SMatrix<f64, LATENTS, POINTS>,
    ) -> Self {
        let shape = core::array::from_fn(|i| {
            let s = profile_abscissa(i);
            sqrt((1.0 - s * s).max(0.0))
        });
        let (mut latent, mut before, mut now, mut kick_m) = (kick, 0.0, 0.0, 0.0_f64);
        // Least squares of A(n+1) on A(n), A(n-1): [p q; q r] (k1, k2) = (u, v).
        let (mut p, mut q, mut r, mut u, mut v) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for turn in 0..SETTLED + TURNS {
            let next = slope(surface, &latent);
            latent = transition * latent;
            kick_m = kick_m.max(next.abs());
            if turn >= SETTLED {
                p += now * now;
                q += now * before;
                r += before * before;
                u += next * now;
                v += next * before;
            }
            (before, now) = (now, next);
        }
        let determinant = p * r - q * q;
        let (k1, k2) = ((r * u - q * v) / determinant, (p * v - q * u) / determinant);
        // The conditions of Jury for a recursion of second order that dies out; false of what is no number.
        let dies_out = k2 > -1.0 && k1.abs() < 1.0 - k2 && kick_m.is_finite();
        let (recursion, kick_m) = if dies_out { ([k1, k2], kick_m) } else { ([0.0; 2], 0.0) };
        Self { shape, recursion, kick_m }
    }

    /// Adds a cross-axis slosh of amplitude `lateral_m` to a surface, m.
    pub fn add_to(&self, surface_m: &mut [f32; POINTS], lateral_m: f64) {
        surface_m.iter_mut().zip(self.shape).for_each(|(z, shape)| *z += (lateral_m * shape) as f32);
    }

    /// Returns `profile` without a cross-axis slosh of amplitude `lateral_m`, m.
    #[must_use]
    pub fn without(&self, profile: &SurfaceProfile, lateral_m: f64) -> SurfaceProfile {
        let mut out = *profile;
        self.add_to(&mut out.height_m, -lateral_m);
        out
    }

    /// Returns Y of the next turn and of this one, from `amplitudes` of this one and the one before.
    #[must_use]
    pub fn next(&self, amplitudes: [f64; 2]) -> [f64; 2] {
        let ([now, before], [k1, k2]) = (amplitudes, self.recursion);
        [k1 * now + k2 * before, now]
    }

    /// Moves `state` by a turn without a measurement; its error no longer goes with that of the latents.
    pub(crate) fn step(&self, state: &mut LateralState) {
        state.amplitude_m = self.next(state.amplitude_m);
        let [k1, k2] = self.recursion;
        let recursion = Matrix2::new(k1, k2, 1.0, 0.0);
        let noise = Matrix2::new(state.noise, 0.0, 0.0, 0.0);
        state.covariance = recursion * state.covariance * recursion.transpose() + noise;
        state.latent_covariance = Latent::zeros();
    }

    /// Returns the part of Y in the variance of the heights whose slopes along the latents are `surface`, m2.
    pub(crate) fn variance<R: Real>(
        &self,
        state: &LateralState,
        surface: &SMatrix<f64, LATENTS, POINTS>,
    ) -> [f64; POINTS] {
        let own = state.covariance.get((0, 0)).copied().unwrap_or(0.0);
        let mut out = [0.0; POINTS];
        let covariance = narrow::<R, _, _>(&state.latent_covariance);
        for ((out, shape), row) in out.iter_mut().zip(self.shape).zip(&surface.data.0) {
            let both = LatentOf::<R>::from(row.map(R::of)).dot(&covariance).wide();
            *out = shape * (shape * own + 2.0 * both);
        }
        out
    }
}

/// A of a small x: the part of its surface that is odd in s, by least squares, m.
fn slope(surface: &SMatrix<f64, LATENTS, POINTS>, latent: &Latent) -> f64 {
    let (mut along, mut square) = (0.0, 0.0);
    for (point, row) in surface.column_iter().enumerate() {
        let s = profile_abscissa(point);
        along += s * row.dot(latent);
        square += s * s;
    }
    along / square
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{exp, sincos};

    /// Two latents turn and decay as z = exp((-b + i w) n); the first is the slope.
    fn ringing(decay: f64, turn: f64) -> CrossAxisMode {
        let (sin, cos) = sincos(turn);
        let rho = exp(-decay);
        let transition = SMatrix::from_fn(|i, j| match (i, j) {
            (0, 0) | (1, 1) => rho * cos,
            (0, 1) => -rho * sin,
            (1, 0) => rho * sin,
            _ => 0.0,
        });
        let surface = SMatrix::from_fn(|i, point| if i == 0 { profile_abscissa(point) } else { 0.0 });
        let kick = Latent::from_fn(|i, _| if i == 1 { 1e-3 } else { 0.0 });
        CrossAxisMode::of(kick, &transition, &surface)
    }

    #[test]
    fn the_mode_across_rings_as_the_one_along() {
        let (decay, turn) = (0.08, 0.35);
        let mode = ringing(decay, turn);
        let [k1, k2] = mode.recursion;
        assert!((k1 - 2.0 * exp(-decay) * sincos(turn).1).abs() < 1e-9, "{k1}");
        assert!((k2 + exp(-2.0 * decay)).abs() < 1e-9, "{k2}");
        assert!(mode.kick_m > 0.5e-3 && mode.kick_m < 1e-3);
        assert_eq!(mode.shape[10], 1.0);
    }

    #[test]
    fn what_would_ring_ever_louder_or_not_at_all_is_forgotten() {
        assert_eq!(ringing(-0.01, 0.35).recursion, [0.0; 2]);
        let still = CrossAxisMode::of(Latent::zeros(), &SMatrix::identity(), &SMatrix::zeros());
        assert_eq!((still.recursion, still.kick_m), ([0.0; 2], 0.0));
    }

    /// An addition to a profile is taken off again, and a free slosh across dies out while its variance settles.
    #[test]
    fn it_is_taken_off_and_dies_out() {
        let mode = ringing(0.08, 0.35);
        let mut surface = [0.07; POINTS];
        mode.add_to(&mut surface, 2e-3);
        assert!((surface[10] - 0.072).abs() < 1e-6 && surface[0] < 0.0710);
        let mut aside = LateralState {
            amplitude_m: [2e-3; 2],
            covariance: Matrix2::zeros(),
            latent_covariance: Latent::zeros(),
            noise: 1e-10,
        };
        let mut last = 0.0;
        for _ in 0..200 {
            mode.step(&mut aside);
            let own = aside.covariance.m11;
            assert!(own >= last * (1.0 - 1e-9), "{own} after {last}");
            last = own;
        }
        assert!(aside.amplitude_m[0].abs() < 1e-6 && last < 1e-8, "{aside:?}");
    }

    #[repr(align(64))]
    struct Aligned<T: ?Sized>(T);

    static BLOB: &Aligned<[u8]> =
        &Aligned(*include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/models/glycerine.blob")));

    /// The largest slope of the surface behind one unit of the port, of the shipped model's own step: its port is used twice, by half,
    /// and its error model is linear, which is a fifth at most.
    #[test]
    fn the_kick_of_a_model_is_the_one_of_its_step() {
        use crate::blob::Model;
        use crate::latent::generic::LatentState;

        let model = Model::load(&BLOB.0).expect("the shipped model");
        let (mut state, mut largest) = (LatentState::default(), 0.0_f64);
        for turn in 0..SETTLED + TURNS {
            model.generic.step(&mut state, if turn == 0 { 1.0 } else { 0.0 });
            largest = largest.max(slope(&model.error_model.surface, &state.latent).abs());
        }
        let kick_m = model.cross_axis.kick_m;
        assert!((kick_m / largest - 1.0).abs() < 0.2, "{kick_m} for {largest}");
    }
}
