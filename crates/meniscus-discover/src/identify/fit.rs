//! The six numbers of a liquid from its profiles, by least squares over whole recordings.
//!
//! ```text
//! sum over recordings of |s - f(p)|^2 / |s|^2  ->  least,     p within bounds
//! ```
//! solved by [`meniscus_numerics::least_squares`]. f is the oscillator as it runs beside a camera, its weak pull towards s
//! included; J by differences. Three starts, a low-viscosity liquid, a high-viscosity one and one that creeps, and the
//! best of the three.

use meniscus::identify::{Calibration, KnownLiquid, Recogniser, Tone, Trail, slope};
use meniscus::surface::SurfaceProfile;
use meniscus::units::GRAVITY_M_S2;
use meniscus_numerics::least_squares::{Damping, Model, Settings, Stop, forward_differences, minimise};
use nalgebra::{DMatrix, DVector};

/// Decays that the search begins at, 1/s.
const STARTS: [f64; 3] = [0.5, 8.0, 80.0];

/// One search; `floor` is for a number that does nothing at its present value.
const SEARCH: Settings = Settings {
    iterations: 14,
    stop: Stop::GainShare(1e-4),
    damping: Damping {
        first: 1e-2,
        shrink: 3.0,
        grow: 4.0,
        least: 0.0,
        most: f64::INFINITY,
        scaled_floor: 0.0,
        floor: 1e-12,
        trials: 8,
    },
};

/// The first zero of J_1'.
const XI: f64 = 1.841_183_781_340_659;

/// The six numbers of a tone, in the order of [`tone`].
type Six = DVector<f64>;

/// Profiles of a recording, frame by frame.
pub(super) type Profiles = [Option<SurfaceProfile>];

/// Returns the tone whose numbers are `p`.
fn tone(p: &Six) -> Tone {
    Tone { frequency: p[0], decay: p[1], yielding: p[2], breaking: p[3], softening: p[4], lever: p[5] }
}

/// Returns w of a liquid without friction: `w^2 = g k tanh kh`, `k = xi/R` (Lamb 1932, article 257).
fn inviscid(radius_m: f64, fill_m: f64) -> f64 {
    let k = XI / radius_m;
    (GRAVITY_M_S2 * k * (k * fill_m).tanh()).sqrt()
}

/// Returns s - f of every frame with a profile, under `tone`, m.
fn misses(tone: Tone, profiles: &Profiles, fill_m: f64) -> Vec<f64> {
    // The sums are not used, so that the calibration does not matter.
    let known = [KnownLiquid { tone, calibration: Calibration { scale: 1.0, scatter: 1.0, numbers: 1.0 } }];
    let recogniser = Recogniser::new(&known, fill_m);
    let mut trail = Trail::<1>::default();
    let turn = |profile: &Option<SurfaceProfile>| {
        recogniser.turn(&mut trail, profile.as_ref());
        trail.residual(0).map_or(0.0, |residual| residual.residual_m)
    };
    profiles.iter().map(turn).collect()
}

/// Weight of a recording: one over the root of its sum of s^2.
fn weight(profiles: &Profiles, fill_m: f64) -> f64 {
    let slopes = profiles.iter().flatten().filter_map(|profile| slope(profile, fill_m));
    let square: f64 = slopes.map(|s| s.height_m * s.height_m).sum();
    1.0 / square.sqrt().max(1e-6)
}

/// Recordings as a function of the six numbers.
struct Recordings<'a> {
    profiles: &'a [&'a Profiles],
    weights: Vec<f64>,
    fill_m: f64,
    low: Six,
    high: Six,
}

impl Model for Recordings<'_> {
    fn residual(&self, p: &Six) -> DVector<f64> {
        let weighted = self.profiles.iter().zip(&self.weights);
        let all = weighted
            .flat_map(|(profiles, w)| misses(tone(p), profiles, self.fill_m).into_iter().map(move |r| w * r));
        DVector::from_iterator(self.profiles.iter().map(|profiles| profiles.len()).sum(), all)
    }

    fn jacobian(&self, p: &Six, residual: &DVector<f64>) -> DMatrix<f64> {
        // A share of what a number is where it spans decades, else of what a tone usually has.
        let widths =
            DVector::from_column_slice(&[0.01 * p[0], 0.03 * p[1].max(0.3), 0.05, 0.05, 0.003, 0.02]);
        forward_differences(p, residual, &widths, |p| self.residual(p))
    }

    fn within_bounds(&self, p: Six) -> Six {
        p.zip_map(&self.low, f64::max).zip_map(&self.high, f64::min)
    }
}

/// Fits the tone that predicts `recordings` best, of a liquid in a glass of this radius and fill, m.
#[must_use]
pub fn fit(recordings: &[&Profiles], glass: (f64, f64)) -> Tone {
    let (radius_m, fill_m) = glass;
    let plain = inviscid(radius_m, fill_m);
    let model = Recordings {
        profiles: recordings,
        weights: recordings.iter().map(|profiles| weight(profiles, fill_m)).collect(),
        fill_m,
        low: DVector::from_column_slice(&[0.4 * plain, 0.01, 0.0, 0.0, -0.1, 0.1]),
        high: DVector::from_column_slice(&[4.0 * plain, 300.0, 100.0, 20.0, 0.2, 5.0]),
    };
    let search = |decay: f64| {
        minimise(&model, DVector::from_column_slice(&[plain, decay, 0.1, 0.05, 0.02, 1.4]), &SEARCH)
    };
    let found = STARTS.map(search);
    let best = found.iter().min_by(|a, b| a.cost.total_cmp(&b.cost));
    best.map_or(tone(&model.low), |best| tone(&best.parameters))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use meniscus::identify::{Change, Swing};
    use meniscus::surface::{POINTS, profile_abscissa};
    use meniscus::units::Micros;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// Returns the profiles of a liquid with this tone in a glass that goes to and fro, with `noise_m` on every height and
    /// its frequency `off` by that share.
    pub(crate) fn played(of: Tone, noise_m: f64, off: f64, seed: u64) -> Vec<Option<SurfaceProfile>> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut noise = || {
            let sum: f64 = (0..12).map(|_| rng.random::<f64>()).sum();
            noise_m * (sum - 6.0)
        };
        let (turn, phase) = (noise() / noise_m.max(1e-9), noise() / noise_m.max(1e-9));
        let place = |n: usize| {
            let t = n as f64 / 60.0;
            let rising = ((t - 0.3) / 0.5).clamp(0.0, 1.0) * ((3.0 - t) / 0.5).clamp(0.0, 1.0);
            0.012 * rising * ((11.0 + turn) * t + phase).sin()
        };
        let bent = Tone { frequency: of.frequency * (1.0 + off), ..of };
        let mut swing = Swing::default();
        let mut frame = |n: usize| {
            if n > 0 {
                bent.advance(&mut swing, Change { from_m: place(n - 1), to_m: place(n) }, 1);
            }
            let height = |i: usize| (0.07 + swing.height_m * profile_abscissa(i) + noise()) as f32;
            Some(SurfaceProfile {
                height_m: std::array::from_fn(height),
                variance_m2: [(noise_m * noise_m) as f32; POINTS],
                valid: [true; POINTS],
                glass_x_m: Some(place(n) as f32),
                sequence: n as u32,
                captured: Micros(16_667 * n as u64),
            })
        };
        (0..240).map(&mut frame).collect()
    }

    pub(crate) const LOW_VISCOSITY: Tone =
        Tone { frequency: 22.4, decay: 0.8, yielding: 0.0, breaking: 0.1, softening: 0.02, lever: 1.5 };

    #[test]
    fn the_numbers_of_a_tone_come_back() {
        let truth = Tone { frequency: 21.5, decay: 2.2, lever: 1.42, ..LOW_VISCOSITY };
        let profiles: Vec<_> = (0..3).map(|k| played(truth, 2e-4, 0.0, k)).collect();
        let all: Vec<&Profiles> = profiles.iter().map(|profiles| &profiles[..]).collect();
        let found = fit(&all, (0.035, 0.07));
        assert!((found.frequency / truth.frequency - 1.0).abs() < 0.01, "{found:?}");
        assert!((found.lever / truth.lever - 1.0).abs() < 0.03, "{found:?}");
        // The three parts of the decay can stand in for one another; what is due at 5 mm is their sum there.
        let at = |t: &Tone| t.decay + t.yielding / 6.0 + 0.25 * t.breaking;
        assert!((at(&found) / at(&truth) - 1.0).abs() < 0.1, "{found:?}");
    }
}
