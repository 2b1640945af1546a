//! Value of knowing the motion of the glass, by its source.
//!
//! The same recording, seen by the same camera, is estimated four times: with the motion off the edges of the
//! glass, from an IMU, from the robot's command, and without any; and a fifth time as an oracle knows it that is a
//! frame late.

use crate::correct::Sightings;
use crate::networks::noise::normal;
use meniscus::blob::Model;
use meniscus::runtime::InputSource;
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_data::motion::{Motion, MotionError};
use meniscus_data::recording::Recording;
use meniscus_score::baseline::linear_with_motion;
use meniscus_score::score::{Score, score};
use meniscus_virtual::camera::START;
use meniscus_virtual::observe_recording::turns_with;
use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Noise of the IMU, m/s2 rms at 60 Hz: 0.03 m/s2 is 120 ug/sqrt(Hz) over 60 Hz, a common MEMS part on a hand
/// that trembles. The offset turns into a steady slope.
const IMU_NOISE_RMS: f64 = 0.03;

/// Offset of the IMU, m/s2.
const IMU_OFFSET: f64 = 0.02;

/// Where the motion comes from, and what the estimate is then worth.
#[derive(Clone, Debug)]
pub struct MotionSource {
    /// `tracked`, `imu`, `command`, `none`, or `oracle`.
    pub name: &'static str,
    /// Errors of surface and field.
    pub score: Score,
}

/// The four sources on one recording.
#[must_use]
pub fn sources(model: &Model<'_>, recording: &Recording, seen: &Sightings, seed: u64) -> Vec<MotionSource> {
    let (before, now) = (recording.delayed_acceleration_m_s2(), &recording.acceleration_m_s2);
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut noisy = |of: &[f64]| -> Vec<f64> {
        of.iter().map(|a| a + IMU_OFFSET + IMU_NOISE_RMS * normal(&mut rng)).collect()
    };
    let imu = (noisy(&before), noisy(now));
    let linear = linear_with_motion(recording);
    let one = |name, drive: &dyn Fn(usize) -> InputSource| {
        let turns = turns_with(model, seen, drive, |_, _, _| {});
        MotionSource { name, score: score(model, recording, &linear, &turns, START) }
    };
    vec![
        one("tracked", &|_| InputSource::Tracked),
        one("imu", &|n| InputSource::Measured { before: imu.0[n], now: imu.1[n] }),
        one("command", &|n| InputSource::Measured { before: before[n], now: now[n] }),
        one("none", &|_| InputSource::Unobserved),
    ]
}

/// The same for an oracle that is a frame late, and what it misses of the acceleration, relative: it knows every part of
/// the motion (a stroke, a rest) whole and exactly, its strength and its end too, from the first frame interval after
/// it began, and takes the glass for unpushed in the one that it begins in.
///
/// ```text
/// a~_n = a_n where the part of the motion that holds at t_n began at t_(n-1) or before, 0 elsewhere
/// ```
/// Whoever forecasts from the places up to the frame before, by whatever rule, knows less. The place at the frame
/// itself shows a stroke that has just begun by 0.1 mm at most, which grows with the cube of its age.
///
/// # Errors
/// When the motion of the recording is not one that the program draws.
pub(super) fn oracle(
    model: &Model<'_>,
    recording: &Recording,
    seen: &Sightings,
) -> Result<(MotionSource, f64), MotionError> {
    let spelling = &recording.provenance.motion;
    let motion = Motion::parse(spelling, recording.frames() as f64 * FRAME_INTERVAL_S)?;
    let truth = &recording.acceleration_m_s2;
    let known = known_since(&motion, truth);
    let missed = truth.iter().zip(&known).map(|(a, known)| (a - known) * (a - known)).sum::<f64>();
    let missed = (missed / truth.iter().map(|a| a * a).sum::<f64>()).sqrt();
    let before = recording.delayed_acceleration_m_s2();
    let linear = linear_with_motion(recording);
    let turns =
        turns_with(model, seen, |n| InputSource::Measured { before: before[n], now: known[n] }, |_, _, _| {});
    let score = score(model, recording, &linear, &turns, START);
    Ok((MotionSource { name: "oracle", score }, missed))
}

/// The accelerations of parts of the motion that began a frame before or earlier, 0 of others.
fn known_since(motion: &Motion, truth: &[f64]) -> Vec<f64> {
    let frames = truth.iter().enumerate();
    let known = |(n, a): (usize, &f64)| {
        let now = n as f64 * FRAME_INTERVAL_S;
        // A part that begins with a frame is known from the next one on, whatever rounding says.
        if motion.began_s(now) <= now - FRAME_INTERVAL_S + 1e-9 { *a } else { 0.0 }
    };
    frames.map(known).collect()
}

/// Accelerations before this one that a linear forecast may use: the filter's own model of the input uses three.
const PAST: usize = 5;

/// Relative errors of the best linear forecast of the acceleration from the [`PAST`] values before it: by the true
/// position of the glass, and by the tracked one.
///
/// ```text
/// min over c of |a_n - sum_k c_k a~_(n-k)| / |a_n|,    k = 1..PAST
/// ```
/// The c are fitted on the same recording, so that no linear rule of as many values does better on it. The position of
/// the glass up to a frame determines its acceleration up to the frame before, and the inertial part of sigma follows that
/// of the frame.
pub(super) fn forecast_errors(recording: &Recording, seen: &Sightings) -> [f64; 2] {
    let tracked: Vec<Option<f64>> =
        seen.iter().map(|profile| profile.and_then(|p| p.glass_x_m).map(f64::from)).collect();
    let whole: Vec<Option<f64>> = recording.glass_x_m.iter().copied().map(Some).collect();
    [whole, tracked].map(|place| missed(&place, &recording.acceleration_m_s2))
}

/// The error of one of them; NaN where fewer frames than coefficients have a past.
fn missed(place: &[Option<f64>], acceleration: &[f64]) -> f64 {
    let tracked = |n: usize| {
        let [before, at, after] = [n.checked_sub(1)?, n, n + 1].map(|n| place.get(n).copied().flatten());
        Some((after? - 2.0 * at? + before?) / (FRAME_INTERVAL_S * FRAME_INTERVAL_S))
    };
    let past = |n: usize| -> Option<Vec<f64>> { (1..=PAST).map(|k| tracked(n.checked_sub(k)?)).collect() };
    let rows: Vec<(Vec<f64>, f64)> =
        acceleration.iter().enumerate().filter_map(|(n, a)| Some((past(n)?, *a))).collect();
    if rows.len() <= PAST {
        return f64::NAN;
    }
    let known = DMatrix::from_fn(rows.len(), PAST, |i, k| rows[i].0[k]);
    let truth = DVector::from_fn(rows.len(), |i, _| rows[i].1);
    let fitted = known.clone().svd(true, true).solve(&truth, 1e-12).map(|c| &known * c);
    fitted.map_or(f64::NAN, |said| (said - &truth).norm() / truth.norm())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every stroke of a motion whose first one begins with frame 18 is unknown in one frame, and in no other.
    #[test]
    fn an_oracle_is_a_frame_late() {
        let motion = Motion::parse("strokes:1301", 4.0).expect("a known kind");
        let known = known_since(&motion, &[1.0; 240]);
        assert_eq!((known[17], known[18], known[19]), (1.0, 0.0, 1.0));
        let begun: Vec<f64> = (0..240).map(|n| motion.began_s(n as f64 * FRAME_INTERVAL_S)).collect();
        let parts = begun.array_windows::<2>().filter(|[before, now]| before != now).count();
        // Before the first stroke the glass has rested for ever, but for frame 0.
        let unknown = known.iter().skip(1).filter(|a| **a == 0.0).count();
        assert!(parts > 3 && unknown == parts, "{unknown} of {parts}");
    }

    /// A sine is forecast from two values; an impulse out of rest from none.
    #[test]
    fn what_a_track_can_tell_is_scored() {
        let place: Vec<Option<f64>> = (0..200).map(|n| Some(0.01 * (0.2 * f64::from(n)).sin())).collect();
        let at = |n: usize| place[n].unwrap_or_default();
        let second =
            |n: usize| if n == 0 || n > 198 { 0.0 } else { (at(n + 1) - 2.0 * at(n) + at(n - 1)) * 3600.0 };
        let acceleration: Vec<f64> = (0..199).map(second).collect();
        assert!(missed(&place, &acceleration) < 1e-6);
        let mut pushed = vec![0.0; 199];
        pushed[100] = 1.0;
        let mut at_rest = vec![Some(0.0); 200];
        at_rest[101..].fill(Some(1.0 / 3600.0));
        assert!(missed(&at_rest, &pushed) > 0.99);
        assert!(missed(&place[..5], &acceleration[..5]).is_nan());
    }
}
