//! Alignment of a recording with a motion whose clock is another one.
//!
//! The glass rests before and after its motion, so a later motion has the same answer later: the model's answer is
//! computed once and slid along the recording. A wave of period T fits nearly as well one T earlier or later, and a coarse
//! search takes whichever lies nearer to its grid; so every minimum is refined, and the best is compared with the others
//! over the whole recording. Where another fits almost as well the alignment is ambiguous, which is the caller's to report.

use super::predict::predict;
use crate::recordings::record::{Channel, Drive, Quantity, Record};
use crate::recordings::stated::Known;
use meniscus_numerics::statistics::rms;

/// Grid of the search, s: a tenth of the period of the fastest slosh that a camera of 60 Hz follows.
const GRID_S: f64 = 0.02;

/// Steps of the refinement, s.
const FINE_S: f64 = 0.002;

/// Samples of the answer in a frame.
const SAMPLES: usize = 2;

/// Error of a rival over that of the best below which they are not distinguished.
const AMBIGUOUS: f64 = 1.1;

/// Least time between two alignments that are rivals, s.
const APART_S: f64 = 0.1;

/// Longest time after the end of the motion in which the answer is computed, s.
const DECAY_S: f64 = 20.0;

/// One alignment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Alignment {
    /// Time by which the motion has to be moved later, s.
    pub late_s: f64,
    /// Root mean square of what the model leaves of the recording, m.
    pub error_m: f64,
}

/// Best alignment of a recording, and the best one elsewhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    /// Best alignment.
    pub best: Alignment,
    /// Best of the minima elsewhere.
    pub rival: Option<Alignment>,
}

impl Clock {
    /// Returns whether the recording does not distinguish the best alignment from its rival.
    #[must_use]
    pub fn is_ambiguous(&self) -> bool {
        self.rival.is_some_and(|rival| rival.error_m < AMBIGUOUS * self.best.error_m)
    }
}

/// Returns the alignment of `record` by the model with the numbers `theta`, within `range_s`, under whichever of `liquids`
/// fits best: liquids that differ in what they are given of the recorded motion.
#[must_use]
pub fn clock(record: &Record, liquids: &[Known], theta: &[f64], range_s: (f64, f64)) -> Option<Clock> {
    let answers: Vec<Vec<Vec<f64>>> = liquids.iter().map(|known| answer(record, known, theta)).collect();
    let error = |late_s: f64| {
        let one = |answer: &Vec<Vec<f64>>| left_m(record, answer, late_s);
        answers.iter().map(one).fold(f64::INFINITY, f64::min)
    };
    let steps = ((range_s.1 - range_s.0) / GRID_S).ceil().max(2.0) as usize;
    let grid: Vec<Alignment> = (0..=steps)
        .map(|i| range_s.0 + GRID_S * i as f64)
        .map(|late_s| Alignment { late_s, error_m: error(late_s) })
        .collect();
    let fine = (GRID_S / FINE_S).round() as i32;
    let refined = |at: &Alignment| {
        let tried = (-fine..=fine).map(|n| at.late_s + FINE_S * f64::from(n));
        let tried = tried.map(|late_s| Alignment { late_s, error_m: error(late_s) });
        tried.min_by(|a, b| a.error_m.total_cmp(&b.error_m)).unwrap_or(*at)
    };
    let inner = grid.windows(3).filter(|w| w[1].error_m <= w[0].error_m && w[1].error_m <= w[2].error_m);
    let minima = inner.map(|w| w[1]).chain(grid.first().copied()).chain(grid.last().copied());
    let mut minima: Vec<Alignment> = minima.map(|at| refined(&at)).collect();
    minima.sort_by(|a, b| a.error_m.total_cmp(&b.error_m));
    let best = *minima.first()?;
    let rival = minima.into_iter().find(|other| (other.late_s - best.late_s).abs() > APART_S);
    Some(Clock { best, rival })
}

/// Returns what the model expects in each channel from the start of the motion on, m, [`SAMPLES`] a frame.
fn answer(record: &Record, known: &Known, theta: &[f64]) -> Vec<Vec<f64>> {
    let drive = &record.drive;
    let interval_s = record.interval_s / SAMPLES as f64;
    let seconds = drive.along_m_s2.len() as f64 / drive.rate_hz + DECAY_S;
    let frames = (seconds / interval_s) as usize;
    let channels = record.channels.iter();
    let longer = Record {
        name: record.name.clone(),
        interval_s,
        channels: channels.map(|c| Channel { quantity: c.quantity, value: vec![None; frames] }).collect(),
        drive: resting_after(drive, seconds),
        rest_frames: 0,
    };
    predict(&longer, known, theta, 0.0, &[])
}

/// Returns `drive` with rest after its end, `seconds` long.
fn resting_after(drive: &Drive, seconds: f64) -> Drive {
    let samples = (seconds * drive.rate_hz) as usize + 2;
    let mut out = drive.clone();
    out.along_m_s2.resize(samples, [0.0; 2]);
    out.tilted_m_s2.resize(samples, [0.0; 2]);
    out.lift_m_s2.resize(samples, 0.0);
    out.place_m.resize(samples, drive.place_m.last().copied().unwrap_or(0.0));
    out
}

/// Returns what `answer` leaves of the whole of `record` where the motion begins at `late_s`, m; before that it rests.
fn left_m(record: &Record, answer: &[Vec<f64>], late_s: f64) -> f64 {
    let of_channel = |(channel, series): (&Channel, &Vec<f64>)| {
        let expected = |frame: usize| {
            let place = (frame as f64 - late_s / record.interval_s) * SAMPLES as f64;
            let (low, part) = (place.max(0.0) as usize, place.max(0.0).fract());
            let at = |n: usize| series.get(n).or(series.last()).copied().unwrap_or(0.0);
            at(low) + part * (at(low + 1) - at(low))
        };
        let seen = channel.value.iter().enumerate();
        rms(seen.filter_map(|(frame, z)| z.map(|z| z - expected(frame))))
    };
    let waves = record.channels.iter().zip(answer).filter(|(c, _)| c.quantity != Quantity::Place);
    rms(waves.map(of_channel))
}

/// Returns `record` with its motion moved later by `late_s`; the glass rests where the motion holds no sample.
#[must_use]
pub fn moved(record: &Record, late_s: f64) -> Record {
    let mut out = record.clone();
    let source = &record.drive;
    let shift = (late_s * source.rate_hz).round() as isize;
    let samples = (record.frames() as f64 * record.interval_s * source.rate_hz) as isize + 2;
    let n = source.along_m_s2.len() as isize;
    let from = |i: isize| usize::try_from(i - shift).ok().filter(|j| (*j as isize) < n);
    let pairs = |v: &[[f64; 2]]| (0..samples).map(|i| from(i).map_or([0.0; 2], |j| v[j])).collect();
    let numbers = |v: &[f64]| (0..samples).map(|i| from(i).map_or(0.0, |j| v[j])).collect();
    out.drive.along_m_s2 = pairs(&source.along_m_s2);
    out.drive.tilted_m_s2 = pairs(&source.tilted_m_s2);
    out.drive.lift_m_s2 = numbers(&source.lift_m_s2);
    let ends = |i: isize| if i < shift { source.place_m.first() } else { source.place_m.last() };
    let place = |i: isize| from(i).map(|j| &source.place_m[j]).or(ends(i)).copied().unwrap_or(0.0);
    out.drive.place_m = (0..samples).map(place).collect();
    let moves = |n: usize| out.drive.at(n as f64 * out.interval_s).0.iter().any(|a| a.abs() > 0.05);
    out.rest_frames = (0..out.frames()).take_while(|n| !moves(*n)).count().max(4);
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::baseline::calibrate::Calibration;
    use crate::recordings::motion_plan::MotionPlan;
    use crate::recordings::stated::CALLIPERS_M;
    use crate::study::synthetic::synthetic_record;

    const WATER: Known = Known {
        radius_m: 0.049,
        radius_error_m: CALLIPERS_M,
        fill_m: 0.078,
        density_kg_m3: 998.0,
        viscosity_pa_s: 1.0e-3,
        motion_share: [1.0; 2],
    };

    /// A recording of 6 s whose motion file is on a clock `late_s` off.
    fn record(late_s: f64, noise_m: f64) -> Record {
        let theta = Calibration::blind(&[], 0.0).mean;
        let plan = MotionPlan::jolt(0.4, 1.2, 6.0);
        let made = synthetic_record("made up", &WATER, &plan, &theta, &[], noise_m, 5).expect("a motion");
        moved(&made, -late_s)
    }

    #[test]
    fn the_clock_of_a_motion_is_found_between_the_points_of_any_grid() {
        let theta = Calibration::blind(&[], 0.0).mean;
        for late_s in [0.0, 0.131, 0.275, -0.118] {
            let found = clock(&record(late_s, 3e-4), &[WATER], &theta, (-1.0, 1.5)).expect("a minimum");
            assert!((found.best.late_s - late_s).abs() < 6e-3, "{found:?} for {late_s}");
            assert!(!found.is_ambiguous(), "{found:?}");
            // A grid of 0.05 s, as it was, with a period of 0.33 s: the rival is one period away.
            let rival = found.rival.expect("a period away");
            assert!((rival.late_s - late_s).abs() > 0.25, "{found:?}");
        }
    }

    #[test]
    fn a_noisy_decay_without_its_beginning_is_ambiguous() {
        let theta = Calibration::blind(&[], 0.0).mean;
        let mut late = record(0.2, 5e-3);
        // What is left is a slow decay in much noise, which a period later is nearly the same.
        let begun = (2.5 / late.interval_s) as usize;
        late.channels.iter_mut().for_each(|c| c.value[..begun].iter_mut().for_each(|z| *z = None));
        let found = clock(&late, &[WATER], &theta, (-1.0, 1.5)).expect("a minimum");
        assert!(found.is_ambiguous(), "{found:?}");
    }
}
