//! Where a search goes next: whether its best fit stays, and the size that is simulated otherwise.

use super::best::{STABLE, STABLE_STEPS};
use super::emulator::Fit;
use super::forward::Point;
use super::interval::Linearised;
use super::search::{Failure, SizeSearch};
use super::tried::{MappedEmulator, Tried};

/// Change of a parameter that is not simulated again, in standard deviations of it.
const STABLE_DEVIATIONS: f64 = 0.25;

/// Farthest that a second size may lie from the best one, relative to the effect: a derivative from farther away is that of
/// another size.
const LOCAL: f64 = 0.3;

/// Distance of the second size from the best one, relative to the effect.
const BESIDE: f64 = 0.12;

/// Least effect for which a second size is simulated, relative to the largest that was tried.
const PRESENT: f64 = 0.1;

impl SizeSearch<'_> {
    /// Returns whether the best fit is as good as the simulated point `here`.
    pub(super) fn is_close(&self, mapped: &MappedEmulator, best: &Fit, here: &Point) -> bool {
        let slopes = mapped.emulator.slopes.len();
        let variance = Linearised::of(&mapped.emulator, best)
            .map(|linear| linear.curvature(&mapped.emulator.recordings, &mapped.channels()));
        // A change within the noise is not worth a simulation either.
        let within_noise = |which: usize| {
            variance.as_ref().map_or(0.0, |parts| STABLE_DEVIATIONS * parts[which].variance.sqrt())
        };
        let stays =
            |which: usize, moved: f64, resolved: f64| moved.abs() <= resolved.max(within_noise(which));
        let excess = (best.size - self.range.neutral).abs();
        let others = best.others.iter().zip(&here.parameters[1..]).zip(self.others).take(slopes);
        stays(0, best.size - here.parameters[0], STABLE * excess)
            && others
                .enumerate()
                .all(|(j, ((new, old), of))| stays(1 + j, new - old, STABLE_STEPS * of.step.abs()))
    }

    /// Returns a size beside the best one that its derivative needs; none where one was simulated.
    pub(super) fn beside(&self, best: &Fit, tried: &[Tried]) -> Option<f64> {
        let sizes = || tried.iter().map(|tried| tried.point.parameters[0]);
        let excess = best.size - self.range.neutral;
        let largest = sizes().map(|size| (size - self.range.neutral).abs()).fold(0.0, f64::max);
        let apart = |size: f64| (size - best.size).abs() / excess.abs();
        // Several points near the best one that differ in another parameter are one size.
        let is_local = sizes().any(|size| (0.5 * BESIDE..LOCAL).contains(&apart(size)));
        if is_local || excess.abs() < PRESENT * largest {
            return None;
        }
        let (low, high) = self.range.bounds;
        let outward = best.size + BESIDE * excess;
        Some(if (low..=high).contains(&outward) { outward } else { best.size - BESIDE * excess })
    }

    /// Returns `size`, or twice as far from the absent effect as any size that was tried where it lies well beyond them: an
    /// emulator is poor there.
    pub(super) fn beyond(&self, size: f64, tried: &[Tried]) -> f64 {
        let neutral = self.range.neutral;
        let sizes = tried.iter().map(|tried| tried.point.parameters[0]);
        let (least, largest) = sizes.fold((f64::MAX, f64::MIN), |(a, b), size| (a.min(size), b.max(size)));
        let (low, high) = self.range.bounds;
        let far = 0.25 * (largest - least);
        if size > largest + far && largest > neutral {
            return (neutral + 2.0 * (largest - neutral)).max(size).min(high);
        }
        if size < least - far && least < neutral {
            return (neutral + 2.0 * (least - neutral)).min(size).max(low);
        }
        size
    }

    /// Returns `size`, or halfway to `here` as often as it takes to stay on this side of every failure.
    pub(super) fn allowed(&self, size: f64, here: f64, failures: &[Failure]) -> f64 {
        let mut size = size;
        for failure in failures {
            let beyond = (failure.size - here) * (size - failure.size) >= 0.0;
            if beyond {
                size = 0.5 * (here + failure.size);
            }
        }
        size
    }

    /// Returns the end of the range at which `size` stands, as far as the search resolves it.
    pub(super) fn end(&self, size: f64) -> Option<f64> {
        let (low, high) = self.range.bounds;
        let resolved = (2.0 * STABLE * (size - self.range.neutral).abs()).max(1e-4 * (high - low).min(1e3));
        [low, high].into_iter().find(|end| end.is_finite() && (size - end).abs() <= resolved)
    }
}
