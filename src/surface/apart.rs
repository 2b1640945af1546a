//! Points that lie apart from every surface that sloshes: a finger before the glass, the edge of something else.
//!
//! Around the glass a contact line follows a first mode to 1.1 mm ([`super::first_mode`]). What covers it does not: below a
//! finger a dark liquid seems to end at the finger's lower side. The depth image tells most of these points, but not at
//! the borders, where its windows hold both.
//!
//! * Points farther than [`APART_M`] from the mode that most points agree with are dropped. The mode is fitted with each
//!   part of the line left out in turn, because what covers the line bends a fit of all.
//! * A few points between gaps ([`LEAST_RUN`]) have no part in it: a mode would bend to them.
//! * Where fewer than [`LEAST_AGREED`] agree nothing is known, and none is left.
//!
//! [`Tally::apart`](super::Tally) counts them.

use super::config::{Config, MAX_COLUMNS};
use super::edge_points::{Sample, Samples};
use super::first_mode::FirstMode;
use super::outcome::Tally;
use heapless::Vec;

/// Points farther from the mode are of something else, metres and pixels, the larger: twice what a wave departs from it.
const APART_M: f32 = 0.0022;
const APART_PX: f32 = 3.0;
/// Fewest points in a run, and the gap that ends one, pixels.
const LEAST_RUN: usize = 6;
const GAP_PX: f32 = 5.0;
/// Least share of the points that agree with one mode.
const LEAST_AGREED: f32 = 0.6;
/// Parts of the line that are left out in turn, in twelfths of it: where each begins, and its length.
const PARTS: [usize; 7] = [0, 1, 2, 3, 4, 5, 6];
const PART: usize = 6;
/// Times that the mode is fitted anew to the points that agree.
const ROUNDS: usize = 2;

/// Drops the points of something else than the contact line.
pub(super) fn drop_apart(config: &Config, samples: &mut Samples, tally: &mut Tally) {
    let limit_m = APART_M.max(APART_PX * config.camera.pitch_m());
    let lengths = run_lengths(config, samples);
    let in_run = |index: usize| lengths.get(index).is_some_and(|length| *length >= LEAST_RUN);
    let agreed = |mode: FirstMode| {
        let points = samples.iter().enumerate();
        points.filter(|(index, sample)| in_run(*index) && off_m(mode, sample) <= limit_m).count()
    };
    let Some(mut mode) = fit(config, samples, |index, _| in_run(index)) else { return };
    if samples.iter().all(|sample| off_m(mode, sample) <= limit_m) {
        return;
    }
    let count = samples.len();
    for part in PARTS {
        let (first, last) = (count * part / 12, count * (part + PART) / 12);
        let outside = |index: usize| in_run(index) && (index < first || index >= last);
        let Some(other) = fit(config, samples, |index, _| outside(index)) else { continue };
        if agreed(other) > agreed(mode) {
            mode = other;
        }
    }
    for _ in 0..ROUNDS {
        let near = |index: usize, sample: &Sample| in_run(index) && off_m(mode, sample) <= limit_m;
        let Some(again) = fit(config, samples, near) else { break };
        mode = again;
    }
    let of_runs = (0..count).filter(|index| in_run(*index)).count();
    if (agreed(mode) as f32) < LEAST_AGREED * of_runs as f32 {
        samples.clear();
    } else {
        samples.retain(|sample| off_m(mode, sample) <= limit_m);
    }
    tally.apart = tally.apart.saturating_add((count - samples.len()) as u32);
}

/// Number of points in the run of each point.
fn run_lengths(config: &Config, samples: &Samples) -> Vec<usize, MAX_COLUMNS> {
    let gap_m = GAP_PX * config.camera.pitch_m();
    let mut runs: Vec<usize, MAX_COLUMNS> = Vec::new();
    let mut last_m = None;
    for sample in samples {
        let goes_on = last_m.is_some_and(|last_m| sample.x_m - last_m <= gap_m);
        last_m = Some(sample.x_m);
        match runs.last_mut() {
            Some(length) if goes_on => *length += 1,
            _ => {
                let _ = runs.push(1);
            }
        }
    }
    runs.iter().flat_map(|&length| core::iter::repeat_n(length, length)).take(MAX_COLUMNS).collect()
}

/// The mode nearest to the points for which `kept` holds, of place in the list and point.
fn fit(config: &Config, samples: &Samples, kept: impl Fn(usize, &Sample) -> bool) -> Option<FirstMode> {
    let points = samples.iter().enumerate().filter(|(index, sample)| kept(*index, sample));
    FirstMode::fit_arc(config, points.map(|(_, sample)| (sample.x_m, sample.z_m)))
}

/// Distance of a point from `mode`, metres.
fn off_m(mode: FirstMode, sample: &Sample) -> f32 {
    (sample.z_m - mode.contact_m(sample.x_m)).abs()
}

#[cfg(test)]
#[allow(clippy::disallowed_methods, reason = "a test may take the platform's functions")]
mod tests {
    extern crate std;

    use super::*;
    use crate::surface::Settings;

    /// Points of a contact line, one a column, at the heights `z_m` of places in radii.
    fn line(config: &Config, z_m: impl Fn(f32) -> f32) -> Samples {
        let count = (2.0 * config.settings.radius_m / config.camera.pitch_m()) as usize;
        let at = |index: usize| 2.0 * (index as f32 + 0.5) / count as f32 - 1.0;
        (0..count)
            .map(|index| Sample {
                x_m: at(index) * config.settings.radius_m,
                z_m: z_m(at(index)),
                rise: 0.0,
                own_m2: 0.0,
                lowered_m: 0.0,
                faint_m: 0.0,
                faint_m2: 0.0,
            })
            .collect()
    }

    /// Places, in radii, that are left of the line with the heights `z_m`, and the number of those that are not.
    fn left(z_m: impl Fn(f32) -> f32) -> (std::vec::Vec<f32>, u32) {
        let config = Config::new(Settings::default()).unwrap();
        let (mut samples, mut tally) = (line(&config, z_m), Tally::default());
        samples.retain(|sample| sample.z_m > 0.0);
        drop_apart(&config, &mut samples, &mut tally);
        (samples.iter().map(|sample| sample.x_m / config.settings.radius_m).collect(), tally.apart)
    }

    /// A first mode of 14 mm with a second one of 1 mm on it.
    fn wave(s: f32) -> f32 {
        0.070 + 0.012 * s - 0.007 * (1.0 - s * s).sqrt() + 0.001 * (2.0 * s * s - 1.0)
    }

    #[test]
    fn a_high_wave_keeps_all_points() {
        let (all, lost) = left(wave);
        assert!(all.len() > 60 && lost == 0, "{} points, {lost} lost", all.len());
    }

    #[test]
    fn the_lower_side_of_a_finger_is_no_contact_line() {
        for tip in [-0.6, -0.3, 0.1] {
            let (kept, lost) = left(|s| if s < tip { 0.035 } else { wave(s) });
            // Where it covers more than two fifths nothing is known.
            let covered = 0.5 * (1.0 + tip);
            assert!(kept.iter().all(|s| *s >= tip), "{tip}: {kept:?}");
            assert_eq!(kept.is_empty(), covered > 1.0 - LEAST_AGREED, "{tip}");
            assert!(lost > 0);
        }
    }

    #[test]
    fn a_few_points_behind_a_gap_bend_no_mode() {
        // The line is seen in the right half, and something lower at the left limb.
        let (kept, lost) = left(|s| {
            if s < -0.94 {
                0.028
            } else if s < 0.1 {
                0.0
            } else {
                wave(s)
            }
        });
        assert!(kept.len() > 25 && kept.iter().all(|s| *s >= 0.1), "{kept:?}");
        assert!((1..6).contains(&lost), "{lost}");
        // A few points of the line itself stay.
        let (kept, lost) = left(|s| if s < 0.1 && s > -0.94 { 0.0 } else { wave(s) });
        assert!(kept.iter().any(|s| *s < -0.94) && lost == 0, "{kept:?}");
    }

    #[test]
    fn points_that_agree_on_nothing_are_all_dropped() {
        let (kept, lost) = left(|s| 0.05 + 0.02 * (40.0 * s).sin());
        assert!(kept.is_empty() && lost > 60, "{kept:?}");
    }
}
