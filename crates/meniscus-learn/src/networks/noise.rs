//! Camera noise on a perfect profile: height noise, lost points, a jittering glass edge.
//!
//! A network trained on perfect profiles goes from 8 to 48 % error at 2 mm of noise; trained with
//! noise and the glass acceleration it stays at 12 %. So every window of training is a noisy one.

use crate::data::dataset::{Frame, Sequence, known_acceleration};
pub(crate) use meniscus::latent::window::{FEATURES, WINDOW};
use meniscus::surface::{POINTS, profile_abscissa};
pub(crate) use meniscus_numerics::random::normal;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Frames over which one draw of noise levels holds.
const BLOCK: usize = 40;

/// Levels of noise, SI units and chances per frame or point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Noise {
    /// Standard deviation of each point's height, m.
    pub(crate) white_m: f64,
    /// Standard deviation of each term of the smooth bias (level, tilt, bow), m.
    pub(crate) bias_m: f64,
    /// Standard deviation of the tracked position of the glass, m.
    pub(crate) glass_m: f64,
    /// Chance that a point is lost.
    pub(crate) drop: f64,
    /// Chance that a frame has a contiguous run of lost points.
    pub(crate) run: f64,
    /// Chance that one to three frames are lost from here on.
    pub(crate) gap: f64,
    /// Chance that the acceleration of a frame is unknown.
    pub(crate) unknown: f64,
}

impl Noise {
    /// The rendered D435 at 0.4 m as measured on recordings (0.09 to 0.13 mm a point, 0.007 to 0.011 mm
    /// of glass position): what reports and the filter's gain are measured with.
    pub(crate) const CAMERA: Self =
        Self { white_m: 1.2e-4, bias_m: 1e-4, glass_m: 1e-5, drop: 0.01, run: 0.02, gap: 0.0, unknown: 0.0 };

    /// Levels for training, spread around the camera's; one block in fifteen is a bad one.
    #[must_use]
    pub(crate) fn draw(rng: &mut ChaCha8Rng) -> Self {
        let bad = rng.random_bool(0.07);
        let mut between = |least: f64, most: f64| least * (most / least).powf(rng.random::<f64>());
        let (white_m, bias_m, glass_m) = (between(5e-5, 4e-4), between(5e-5, 2e-4), between(5e-6, 3e-5));
        let drop = if rng.random_bool(0.2) { 0.15 } else { 0.01 };
        Self {
            white_m: if bad { 2e-3 * rng.random::<f64>() } else { white_m },
            bias_m,
            glass_m,
            drop,
            run: if rng.random_bool(0.2) { 0.5 } else { 0.02 },
            gap: if rng.random_bool(0.1) { 0.1 } else { 0.003 },
            unknown: if bad { 0.3 } else { 0.002 },
        }
    }
}

/// Bias that is smooth over the profile and in time: level, tilt and bow, each a first-order
/// autoregressive process.
#[derive(Default)]
struct Bias([f64; 3]);

impl Bias {
    /// The bias of the next frame at abscissa `s` in [-1, 1] for a standard deviation of one a term.
    fn advance(&mut self, rng: &mut ChaCha8Rng) -> impl Fn(f64) -> f64 + use<> {
        const MEMORY: f64 = 0.95;
        for term in &mut self.0 {
            *term = MEMORY * *term + (1.0 - MEMORY * MEMORY).sqrt() * normal(rng);
        }
        let [level, tilt, bow] = self.0;
        move |s| level + tilt * s + bow * (s * s - 1.0 / 3.0)
    }
}

/// A sequence as the camera sees it.
#[derive(Clone, Debug)]
pub(crate) struct Seen {
    /// Frames x [`FEATURES`].
    pub(crate) features: Vec<f32>,
}

impl Seen {
    /// One pass of the camera over `sequence`; `fixed` or, without it, levels drawn anew every
    /// [`BLOCK`] frames.
    #[must_use]
    pub(crate) fn new(
        sequence: &Sequence,
        frame: &Frame,
        fixed: Option<Noise>,
        rng: &mut ChaCha8Rng,
    ) -> Self {
        let frames = sequence.frames();
        let mut levels = Vec::with_capacity(frames);
        for n in 0..frames {
            let held = if n % BLOCK == 0 { None } else { levels.last().copied() };
            levels.push(fixed.or(held).unwrap_or_else(|| Noise::draw(rng)));
        }
        let glass: Vec<f64> =
            sequence.glass_x_m.iter().zip(&levels).map(|(x, l)| x + l.glass_m * normal(rng)).collect();
        let mut acceleration = known_acceleration(&glass);
        let (mut bias, mut missing) = (Bias::default(), 0_u32);
        let mut features = Vec::with_capacity(frames * FEATURES);
        for (n, (profile, level)) in sequence.profile_m.chunks_exact(POINTS).zip(&levels).enumerate() {
            let bias = bias.advance(rng);
            let (from, length) = (rng.random_range(0..POINTS), rng.random_range(2..12));
            let run = if rng.random_bool(level.run) { from..from + length } else { 0..0 };
            if missing == 0 && rng.random_bool(level.gap) {
                missing = rng.random_range(1..=3);
            }
            for (i, &height) in profile.iter().enumerate() {
                let lost = missing > 0 || run.contains(&i) || rng.random_bool(level.drop);
                let smooth = level.bias_m * bias(profile_abscissa(i));
                let noisy = f64::from(height) - frame.fill_m + smooth + level.white_m * normal(rng);
                let feature = noisy as f32 / frame.height_scale_m;
                features.extend(if lost { [0.0, 0.0] } else { [feature, 1.0] });
            }
            if missing > 0 && n > 0 {
                // The run time carries the last acceleration over a gap.
                acceleration[n] = acceleration[n - 1];
            }
            missing = missing.saturating_sub(1);
            let known = !rng.random_bool(level.unknown);
            features.push(if known { acceleration[n] as f32 / frame.acceleration_scale } else { 0.0 });
        }
        Self { features }
    }

    /// Features of the window that ends at `end`, oldest first; the frames before the first are the
    /// first again, at rest.
    pub(crate) fn window(&self, end: usize) -> impl Iterator<Item = &[f32]> {
        (0..WINDOW).map(move |k| {
            let n = (end + k + 1).saturating_sub(WINDOW);
            &self.features[n * FEATURES..(n + 1) * FEATURES]
        })
    }

    /// The port u = a / scale at frame `n`.
    #[must_use]
    pub(crate) fn port(&self, n: usize) -> f64 {
        f64::from(self.features[(n + 1) * FEATURES - 1])
    }
}
