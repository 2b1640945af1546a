//! Errors as this project reports them: relative L2 over points and time, against the fluctuation.
//!
//! slosh-rel = |z - zhat| / |z - z_rest|. The error relative to the height flatters: a flat surface
//! already scores 2 %.

use crate::data::dataset::{Frame, Sequence};
use crate::data::groups::{SURFACE, TRUNK};
use meniscus::surface::POINTS;
use meniscus_report::checks::Check;

/// A figure in per cent, held against `target` where there is one.
#[must_use]
pub(crate) fn percent(name: String, fraction: f64, target: Option<f64>) -> Check {
    match target {
        Some(limit) => Check::at_most(name, 100.0 * fraction, "%", limit),
        None => Check::informational(name, 100.0 * fraction, "%"),
    }
}

/// Sums of squares of errors and of fluctuations, by trunk group.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct GroupErrors {
    miss: [f64; 5],
    size: [f64; 5],
}

impl GroupErrors {
    /// Adds the frames from `from` on: one row of `coefficients` a frame, without the feed-through, and
    /// the port value that goes with it.
    pub(crate) fn add(
        &mut self,
        frame: &Frame,
        sequence: &Sequence,
        from: usize,
        coefficients: &[f32],
        ports: &[f64],
    ) {
        let width = frame.width();
        let ranges = frame.ranges();
        let fed = |row: &[f32], u: f64| {
            row.iter().zip(&frame.feed).map(|(c, f)| c + f * u as f32).collect::<Vec<f32>>()
        };
        for (k, (said, &u)) in coefficients.chunks_exact(width).zip(ports).enumerate() {
            let n = from + k;
            let said = fed(said, u);
            let truth = fed(&sequence.coefficients[n * width..(n + 1) * width], sequence.port[n]);
            for (group, range) in ranges.iter().enumerate().take(SURFACE) {
                // The basis is orthonormal: |f - S c|^2 = |c_f - c|^2 + |f|^2 - |c_f|^2.
                let pairs = truth[range.clone()].iter().zip(&said[range.clone()]);
                let inside: f64 = pairs.map(|(t, s)| f64::from(t - s).powi(2)).sum();
                let kept: f64 = truth[range.clone()].iter().map(|t| f64::from(*t).powi(2)).sum();
                let norm2 = f64::from(sequence.norm2[n][group]);
                self.miss[group] += inside + (norm2 - kept).max(0.0);
                self.size[group] += norm2;
            }
            let height = surface(frame, &said[ranges[SURFACE].clone()]);
            let profile = |n: usize| &sequence.profile_m[n * POINTS..(n + 1) * POINTS];
            for ((z, said), rest) in profile(n).iter().zip(height).zip(profile(0)) {
                self.miss[SURFACE] += f64::from(z - said).powi(2);
                self.size[SURFACE] += f64::from(z - rest).powi(2);
            }
        }
    }

    /// Relative error of a trunk group.
    #[must_use]
    pub(crate) fn relative(&self, group: usize) -> f64 {
        (self.miss[group] / self.size[group].max(f64::MIN_POSITIVE)).sqrt()
    }

    /// One check a group against `targets` in per cent, named `stage group`.
    #[must_use]
    pub(crate) fn checks(&self, stage: &str, targets: [Option<f64>; 5]) -> Vec<Check> {
        let check = |(group, target)| {
            let name = if group == SURFACE { "surface slosh-rel" } else { TRUNK[group] };
            percent(format!("{stage}: {name}"), self.relative(group), target)
        };
        targets.into_iter().enumerate().map(check).collect()
    }
}

/// Heights of the profile from its coefficients, as the run time decodes them, metres.
fn surface(frame: &Frame, coefficients: &[f32]) -> Vec<f32> {
    let mut heights = frame.rest_profile.clone();
    for (mode, c) in frame.bases[SURFACE].modes.column_iter().zip(coefficients) {
        heights.iter_mut().zip(mode.iter()).for_each(|(h, m)| *h += c * m);
    }
    heights
}

/// Slosh-rel of saying that the next frame looks like this one.
#[must_use]
pub(crate) fn persistence(sequences: &[Sequence]) -> f64 {
    let (mut miss, mut size) = (0.0, 0.0);
    for sequence in sequences {
        let rest = &sequence.profile_m[..POINTS];
        let frames = sequence.profile_m.chunks_exact(POINTS);
        for (before, now) in frames.clone().zip(frames.skip(1)) {
            for ((b, z), r) in before.iter().zip(now).zip(rest) {
                miss += f64::from(z - b).powi(2);
                size += f64::from(z - r).powi(2);
            }
        }
    }
    (miss / size.max(f64::MIN_POSITIVE)).sqrt()
}
