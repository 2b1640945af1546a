//! Scripted waves: sweeps, jolts and random motions, sampled finely and joined by a spline.

use super::{Piece, REACH_M, REST_S, STRONGEST_M_S2, spline};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

/// Spacing of the samples, s: a tenth of the shortest ramp and less.
const STEP_S: f64 = 0.005;

/// The spline through `shape(t)` for `t` from 0 to `duration_s`, started at `start_s`, scaled to the
/// peak acceleration `strength`, or less to keep the reach. `shape` must start and end at rest.
fn sampled(start_s: f64, duration_s: f64, strength: f64, shape: impl Fn(f64) -> f64) -> Vec<Piece> {
    let steps = (duration_s / STEP_S).ceil().max(2.0) as usize;
    let h = duration_s / steps as f64;
    let x: Vec<f64> = (0..=steps).map(|i| shape(i as f64 * h)).collect();
    let farthest = x.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let strongest = x.windows(3).fold(0.0_f64, |m, w| m.max((w[0] - 2.0 * w[1] + w[2]).abs() / (h * h)));
    let scale = (strength / strongest.max(1e-9)).min(REACH_M / farthest.max(1e-9));
    let samples: Vec<_> = x.iter().enumerate().map(|(i, x)| (start_s + i as f64 * h, scale * x)).collect();
    spline::through(&samples)
}

/// A window that rises from 0 to 1 and falls back within `ramp` at both ends, three times
/// differentiable: `s^4 (35 - 84 s + 70 s^2 - 20 s^3)`.
fn window(t: f64, duration: f64, ramp: f64) -> f64 {
    let s = (t.min(duration - t) / ramp).clamp(0.0, 1.0);
    s.powi(4) * (35.0 + s * (-84.0 + s * (70.0 - 20.0 * s)))
}

/// A sine of rising frequency (about 1 to 5 Hz) and about constant acceleration.
pub(super) fn sweep(seed: u64, end_s: f64) -> Vec<Piece> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let low: f64 = rng.random_range(0.8..1.6);
    let high: f64 = rng.random_range(3.6..5.2);
    let strength = rng.random_range(0.4..0.75) * STRONGEST_M_S2;
    let phase: f64 = rng.random_range(0.0..TAU);
    let duration = end_s - REST_S;
    sampled(REST_S, duration, strength, |t| {
        let frequency = low + (high - low) * t / duration;
        let angle = phase + TAU * (low * t + 0.5 * (high - low) * t * t / duration);
        window(t, duration, 0.4) * angle.sin() / (frequency * frequency)
    })
}

/// A sum of twelve sines between 0.5 and 4.5 Hz with random phases.
pub(super) fn random(seed: u64, end_s: f64) -> Vec<Piece> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let tones: [(f64, f64, f64); 12] = std::array::from_fn(|k| {
        let frequency = 0.5 + (k as f64 + rng.random_range(0.0..1.0)) / 3.0;
        (frequency, rng.random_range(0.3..1.0), rng.random_range(0.0..TAU))
    });
    let strength = rng.random_range(0.7..1.0) * STRONGEST_M_S2;
    let duration = end_s - REST_S;
    sampled(REST_S, duration, strength, |t| {
        let sum: f64 = tones.iter().map(|(f, a, phase)| a * (TAU * f * t + phase).sin() / f.powf(1.5)).sum();
        window(t, duration, 0.4) * sum
    })
}

/// Half-sine pushes, each caught at once by an equal one the other way:
/// `x'' = A sin(2 pi t/T)`, so `x = A T/(2 pi) t - A (T/(2 pi))^2 sin(2 pi t/T)`.
pub(super) fn jolts(seed: u64, end_s: f64) -> Vec<Piece> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let (mut pushes, mut time, mut at) = (Vec::new(), 0.0, 0.0_f64);
    loop {
        let length: f64 = rng.random_range(0.24..0.40);
        let strength = rng.random_range(0.4..1.0) * STRONGEST_M_S2;
        let forward: bool = rng.random_bool(0.5);
        let pause: f64 = rng.random_range(0.2..0.7);
        if REST_S + time + length > end_s {
            break;
        }
        let reached = strength * length * length / TAU;
        let step = if forward { reached } else { -reached };
        let step = if (at + step).abs() <= REACH_M { step } else { -step };
        pushes.push((time, length, at, step));
        (time, at) = (time + length + pause, at + step);
    }
    let position = |t: f64| {
        let after = pushes.partition_point(|(start, ..)| *start <= t);
        after.checked_sub(1).map_or(0.0, |i| {
            let (start, length, from, step) = pushes[i];
            let s = ((t - start) / length).min(1.0);
            from + step * (s - (TAU * s).sin() / TAU)
        })
    };
    let strength = rng.random_range(0.5..1.0) * STRONGEST_M_S2;
    sampled(REST_S, end_s - REST_S, strength, position)
}
