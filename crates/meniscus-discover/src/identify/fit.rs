//! The six numbers of a liquid from what a camera saw of it, by least squares over whole recordings.
//!
//! ```text
//! sum over recordings of |s - f(p)|^2 / |s|^2  ->  least,     p within bounds
//! (J^T J + lambda diag J^T J) d = -J^T r                        (Levenberg 1944, Marquardt 1963)
//! ```
//! f is the oscillator as it runs beside a camera, its weak pull towards s included; J by differences. Three starts, a
//! thin liquid, a thick one and one that creeps, and the best of the three.

use meniscus::identify::{Calibration, Change, Known, Recogniser, Tone, Trail, slope};
use meniscus::surface::SurfaceProfile;
use meniscus::units::GRAVITY_M_S2;
use nalgebra::{DVector, SMatrix, SVector};

/// Numbers of a tone.
const SIX: usize = 6;

/// Decays that the search begins at, 1/s.
const STARTS: [f64; 3] = [0.5, 8.0, 80.0];

/// Rounds of one search.
const ROUNDS: usize = 14;

/// A round that gains less than this share ends the search.
const GAIN: f64 = 1e-4;

/// The first zero of J_1'.
const XI: f64 = 1.841_183_781_340_659;

type Six = SVector<f64, SIX>;

/// What a camera saw, frame by frame.
pub(super) type Seen = [Option<SurfaceProfile>];

/// The tone whose numbers are `p`.
fn tone(p: &Six) -> Tone {
    Tone { frequency: p[0], decay: p[1], yielding: p[2], breaking: p[3], softening: p[4], lever: p[5] }
}

/// w of a liquid without friction: `w^2 = g k tanh kh`, `k = xi/R` (Lamb 1932, article 257).
fn inviscid(radius_m: f64, fill_m: f64) -> f64 {
    let k = XI / radius_m;
    (GRAVITY_M_S2 * k * (k * fill_m).tanh()).sqrt()
}

/// s - f of every frame that was seen, under `tone`, m.
fn misses(tone: Tone, seen: &Seen, fill_m: f64) -> Vec<f64> {
    // The sums are not used, so that the calibration does not matter.
    let known = [Known { tone, calibration: Calibration { scale: 1.0, scatter: 1.0, numbers: 1.0 } }];
    let recogniser = Recogniser::new(&known, fill_m);
    let mut trail = Trail::<1>::default();
    let turn = |profile: &Option<SurfaceProfile>| {
        recogniser.turn(&mut trail, profile.as_ref());
        trail.missed(0).map_or(0.0, |miss| miss.miss_m)
    };
    seen.iter().map(turn).collect()
}

/// Weight of a recording: one over the root of its sum of s^2.
fn weight(seen: &Seen, fill_m: f64) -> f64 {
    let slopes = seen.iter().flatten().filter_map(|profile| slope(profile, fill_m));
    let square: f64 = slopes.map(|s| s.height_m * s.height_m).sum();
    1.0 / square.sqrt().max(1e-6)
}

/// The tone that foretells `recordings` best, of a liquid in a glass of this radius and fill (m).
#[must_use]
pub fn fit(recordings: &[&Seen], (radius_m, fill_m): (f64, f64)) -> Tone {
    let weights: Vec<f64> = recordings.iter().map(|seen| weight(seen, fill_m)).collect();
    let residual = |p: &Six| -> DVector<f64> {
        let weighted = recordings.iter().zip(&weights);
        let all =
            weighted.flat_map(|(seen, w)| misses(tone(p), seen, fill_m).into_iter().map(move |r| w * r));
        DVector::from_iterator(recordings.iter().map(|seen| seen.len()).sum(), all)
    };
    let plain = inviscid(radius_m, fill_m);
    let low = Six::from([0.4 * plain, 0.01, 0.0, 0.0, -0.1, 0.1]);
    let high = Six::from([4.0 * plain, 300.0, 100.0, 20.0, 0.2, 5.0]);
    let search = |decay: f64| {
        let start = Six::from([plain, decay, 0.1, 0.05, 0.02, 1.4]);
        descend(start, &residual, |p| p.zip_map(&low, f64::max).zip_map(&high, f64::min))
    };
    let found = STARTS.map(search);
    let best = found.iter().min_by(|a, b| a.1.total_cmp(&b.1));
    best.map_or(tone(&low), |(p, _)| tone(p))
}

/// Marquardt's search from `p`; where it ended, and the sum of squares there.
fn descend(p: Six, residual: &impl Fn(&Six) -> DVector<f64>, within: impl Fn(Six) -> Six) -> (Six, f64) {
    let (mut p, mut r) = (p, residual(&p));
    let mut lambda = 1e-2;
    for _ in 0..ROUNDS {
        let widths = Six::from([0.01 * p[0], 0.03 * p[1].max(0.3), 0.05, 0.05, 0.003, 0.02]);
        let column = |k: usize| {
            let mut aside = p;
            aside[k] += widths[k];
            (residual(&aside) - &r) / widths[k]
        };
        let columns: Vec<DVector<f64>> = (0..SIX).map(column).collect();
        let normal = SMatrix::<f64, SIX, SIX>::from_fn(|i, j| columns[i].dot(&columns[j]));
        let slope = Six::from_fn(|i, _| columns[i].dot(&r));
        let square = r.norm_squared();
        let mut better = None;
        for _ in 0..8 {
            let mut damped = normal;
            (0..SIX).for_each(|i| damped[(i, i)] += lambda * normal[(i, i)] + 1e-12);
            let next = damped.cholesky().map(|factor| within(p - factor.solve(&slope)));
            let tried = next.map(|next| (next, residual(&next)));
            better = tried.filter(|(_, tried)| tried.norm_squared() < square);
            if better.is_some() {
                lambda /= 3.0;
                break;
            }
            lambda *= 4.0;
        }
        let Some((next, tried)) = better else { break };
        (p, r) = (next, tried);
        if r.norm_squared() > (1.0 - GAIN) * square {
            break;
        }
    }
    let square = r.norm_squared();
    (p, square)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use meniscus::identify::Swing;
    use meniscus::surface::{POINTS, profile_abscissa};
    use meniscus::units::Micros;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// What a perfect camera would see of a liquid with this tone in a glass that goes to and fro, with `noise_m` on
    /// every height and its frequency `off` by that share.
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

    pub(crate) const THIN: Tone =
        Tone { frequency: 22.4, decay: 0.8, yielding: 0.0, breaking: 0.1, softening: 0.02, lever: 1.5 };

    #[test]
    fn the_numbers_of_a_tone_come_back() {
        let truth = Tone { frequency: 21.5, decay: 2.2, lever: 1.42, ..THIN };
        let seen: Vec<_> = (0..3).map(|k| played(truth, 2e-4, 0.0, k)).collect();
        let all: Vec<&Seen> = seen.iter().map(|seen| &seen[..]).collect();
        let found = fit(&all, (0.035, 0.07));
        assert!((found.frequency / truth.frequency - 1.0).abs() < 0.01, "{found:?}");
        assert!((found.lever / truth.lever - 1.0).abs() < 0.03, "{found:?}");
        // The three parts of the decay can stand in for one another; what is due at 5 mm is their sum there.
        let at = |t: &Tone| t.decay + t.yielding / 6.0 + 0.25 * t.breaking;
        assert!((at(&found) / at(&truth) - 1.0).abs() < 0.1, "{found:?}");
    }
}
