//! The first mode in latent space: height a = A x and rate v = B x, by least squares over decoded roll-outs.
//!
//! ```text
//! a    slope of the decoded surface along the wall, m: every mode (1,n) has that shape there
//! v    (a after a short closed step - a before it) / its length
//! E    C T^T (T C T^T)^-1,    T = (A, B),  C = <x x^T>,  E = (e_a, e_v)
//! ```
//! E holds the directions in which the states spread as a and v grow (Haufe et al., NeuroImage 87 (2014) 96): the layers
//! that go with the wave go with it. The shortest directions with T E = 1 would leave them behind, and the mode would
//! have 0.4 of its mass along them instead of 1.1.
//!
//! The roll-outs are those of the model itself under random jolts as strong as it was trained on, so no recording is
//! needed. The latents are many and the mode is two numbers: a ridge of a millionth of their mean square keeps the map
//! from using directions that hardly move.

use crate::recordings::record::parts;
use meniscus::blob::Model;
use meniscus::latent::generic::{LATENTS, Latent, LatentState, ModeMap};
use nalgebra::{SMatrix, SVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

/// Roll-outs and frames of each.
const ROLL_OUTS: usize = 12;
const FRAMES: usize = 240;

/// Jolts of a roll-out, their strength in units of the model's acceleration, their period, s.
const JOLTS: usize = 4;
const STRENGTH: f64 = 2.0;
const PERIOD_S: std::ops::Range<f64> = 0.15..0.6;

/// Length of the closed step that gives the rate, s.
const SHORT_S: f64 = 1e-3;

/// Ridge, as a share of the mean square of a latent.
const RIDGE: f64 = 1e-6;

/// Share of a and v that the map has to explain.
const LEAST: f64 = 0.9;

/// Map of the first mode with the share that it explains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mapped {
    /// A, B and their directions.
    pub map: ModeMap,
    /// Share of the mean square of a and of v that A x and B x explain.
    pub explained: [f64; 2],
}

/// Reason for which there is no map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MapError {
    /// The latents do not follow height or rate: shares explained.
    Poor([f64; 2]),
    /// The latents hardly move, or height and rate are one direction.
    Degenerate,
}

impl std::fmt::Display for MapError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Poor([a, v]) => write!(
                f,
                "a linear map of the model's latents explains {:.0} % of the first mode's height and {:.0} % of its rate, \
                 and {:.0} % are needed to insert an effect: train the model longer",
                100.0 * a,
                100.0 * v,
                100.0 * LEAST
            ),
            Self::Degenerate => {
                write!(f, "the model's latents do not distinguish the first mode's height from its rate")
            }
        }
    }
}

impl std::error::Error for MapError {}

/// Fits the map of the first mode in the latents of `model`.
///
/// # Errors
/// [`MapError`].
pub fn map(model: &Model<'_>) -> Result<Mapped, MapError> {
    let mut short = model.generic.clone();
    short.dt_s = SHORT_S;
    let slope = |x: &Latent| {
        let latent: [f64; LATENTS] = (*x).into();
        let surface = model.decoder.surface(&model.decoder.coefficients(&latent.map(|x| x as f32), 0.0));
        parts(surface.iter().map(|z| f64::from(*z)).enumerate()).map_or(0.0, |[_, slope, ..]| slope)
    };
    let mut square = SMatrix::<f64, LATENTS, LATENTS>::zeros();
    let mut right = SMatrix::<f64, LATENTS, 2>::zeros();
    let mut pairs = Vec::with_capacity(ROLL_OUTS * FRAMES);
    for seed in 0..ROLL_OUTS as u64 {
        let input = jolts(seed, model.generic.dt_s);
        let mut state = LatentState::default();
        for n in 0..FRAMES {
            model.generic.step(&mut state, input(n));
            let x = state.latent;
            let mut after = state;
            short.step(&mut after, 0.0);
            let numbers = SVector::<f64, 2>::new(slope(&x), (slope(&after.latent) - slope(&x)) / SHORT_S);
            square += x * x.transpose();
            right += x * numbers.transpose();
            pairs.push((x, numbers));
        }
    }
    let ridge = RIDGE * square.trace() / LATENTS as f64;
    let factor = (square + SMatrix::identity() * ridge).cholesky().ok_or(MapError::Degenerate)?;
    let rows = factor.solve(&right);
    let mut left = [0.0; 2];
    let mut all = [0.0; 2];
    for (x, numbers) in &pairs {
        let error = numbers - rows.transpose() * x;
        for k in 0..2 {
            left[k] += error[k] * error[k];
            all[k] += numbers[k] * numbers[k];
        }
    }
    let explained = [0, 1].map(|k| 1.0 - left[k] / all[k].max(f64::MIN_POSITIVE));
    if explained.iter().any(|share| share.is_nan() || *share < LEAST) {
        return Err(MapError::Poor(explained));
    }
    let spread = square * rows;
    let along = (rows.transpose() * spread).try_inverse().map(|inverse| spread * inverse);
    let along = along.ok_or(MapError::Degenerate)?;
    let columns = [rows.column(0), rows.column(1), along.column(0), along.column(1)];
    let map = ModeMap::new(columns.map(|column| column.into_owned())).ok_or(MapError::Degenerate)?;
    Ok(Mapped { map, explained })
}

/// Port values of roll-out `seed` by frame: single periods of a sine.
fn jolts(seed: u64, dt_s: f64) -> impl Fn(usize) -> f64 {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let last = FRAMES as f64 * dt_s * 0.6;
    let one = |_| {
        let (start, period) = (rng.random_range(0.0..last), rng.random_range(PERIOD_S));
        (start, period, rng.random_range(-STRENGTH..STRENGTH))
    };
    let jolts: Vec<(f64, f64, f64)> = (0..JOLTS).map(one).collect();
    move |n| {
        let at = |(start, period, strength): &(f64, f64, f64)| {
            let s = (n as f64 * dt_s - start) / period;
            if (0.0..1.0).contains(&s) { strength * (TAU * s).sin() } else { 0.0 }
        };
        jolts.iter().map(at).sum()
    }
}
