//! Random sequences of smooth strokes.

use super::{Piece, REACH_M, REST_S, STRONGEST_M_S2};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Peak acceleration of a minimum-jerk stroke in units of distance / duration^2: `10 / sqrt 3`.
const PEAK: f64 = 5.773_502_691_896_258;

/// A minimum-jerk stroke from `from` to `to` (Flash and Hogan 1985):
/// `x = from + (to - from)(10 s^3 - 15 s^4 + 6 s^5)`, `s = t/T`.
fn stroke(start_s: f64, duration_s: f64, from: f64, to: f64) -> Piece {
    let (d, t) = (to - from, duration_s);
    let coefficient = [from, 0.0, 0.0, 10.0 * d / t.powi(3), -15.0 * d / t.powi(4), 6.0 * d / t.powi(5)];
    Piece { start_s, coefficient }
}

/// The glass at rest at `at`.
fn rest(start_s: f64, at: f64) -> Piece {
    Piece { start_s, coefficient: [at, 0.0, 0.0, 0.0, 0.0, 0.0] }
}

/// Strokes of 20 to 60 mm in 0.25 to 0.6 s, about every second one followed by a rest, until `end_s`.
pub(super) fn strokes(seed: u64, end_s: f64) -> Vec<Piece> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut pieces = Vec::new();
    let (mut time, mut at) = (REST_S, 0.0_f64);
    loop {
        let length: f64 = rng.random_range(0.020..0.060);
        let strength = rng.random_range(0.3..1.0) * STRONGEST_M_S2;
        let forward: bool = rng.random_bool(0.5);
        // The duration that gives the drawn strength, within 0.25 to 0.6 s and the acceleration limit.
        let shortest = (PEAK * length / STRONGEST_M_S2).sqrt().max(0.25);
        let duration = (PEAK * length / strength).sqrt().clamp(shortest, 0.6);
        let pause = if rng.random_bool(0.5) { rng.random_range(0.05..0.5) } else { 0.0 };
        if time + duration > end_s {
            return pieces;
        }
        let step = if forward { length } else { -length };
        let to = if (at + step).abs() <= REACH_M { at + step } else { at - step };
        pieces.push(stroke(time, duration, at, to));
        pieces.push(rest(time + duration, to));
        (time, at) = (time + duration + pause, to);
    }
}
