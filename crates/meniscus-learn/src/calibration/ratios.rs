//! Errors over half-widths: how far the truth lies from an estimate, in units of what its interval says.

use crate::calibration::camera_views::CameraView;
use meniscus::blob::{LoadError, Model};
use meniscus::runtime::{Crest, Estimate, Forecast, InputSource, Memory, Mode};
use meniscus::uncertainty::error_factors::{ErrorFactors, LEADS};
use meniscus_data::recording::{GROUP_NAMES, Recording, STATE, group_range};
use meniscus_numerics::statistics;
use meniscus_platform::files::AlignedBytes;
use meniscus_score::crests;
use meniscus_score::score::field_of;
use meniscus_virtual::observe_recording::turns_with;

/// Share of the truth that an interval is to hold.
pub(crate) const HELD: f64 = 0.9;

/// Every how many frames the full field is looked at: it is 27742 numbers.
const FIELD_EVERY: usize = 3;

/// Errors over half-widths.
#[derive(Debug, Default)]
pub(crate) struct Ratios {
    /// Of the surface at each lead, the motion of the glass unknown.
    pub(crate) surface: [Vec<f32>; LEADS.len()],
    pub(crate) field: [Vec<f32>; GROUP_NAMES.len()],
    /// Of the surface at each lead but the present, the motion planned.
    pub(crate) planned: [Vec<f32>; LEADS.len() - 1],
    /// Of the height of the next crest, the motion planned.
    pub(crate) crest: Vec<f32>,
}

/// Adds |truth - said| / half, number by number; an interval of nothing counts as missed.
fn add(ratios: &mut Vec<f32>, truth: &[f32], said: &[f32], half: impl Iterator<Item = f32>) {
    let ratio = |((t, s), half): ((&f32, &f32), f32)| {
        if half > 0.0 { (t - s).abs() / half } else { f32::INFINITY }
    };
    ratios.extend(truth.iter().zip(said).zip(half).map(ratio));
}

/// The number that a share [`HELD`] of `ratios` does not exceed; one of none, or where it is not finite.
pub(crate) fn quantile(ratios: Vec<f32>) -> f32 {
    let k = statistics::quantile(ratios, HELD).filter(|k| k.is_finite());
    k.map_or(1.0, |k| k.max(f32::MIN_POSITIVE))
}

/// Share of `ratios` up to `k`, %.
pub(crate) fn share(ratios: &[f32], k: f32) -> f64 {
    100.0 * ratios.iter().filter(|&&r| r <= k).count() as f64 / ratios.len() as f64
}

/// Errors over half-widths of the turns of `blob` that tracked, by recording.
pub(crate) fn ratios_by_recording(blob: &[u8], views: &[CameraView<'_>]) -> Result<Vec<Ratios>, LoadError> {
    let blob = AlignedBytes::copy(blob);
    let model = Model::load(&blob)?;
    let mut all = Vec::new();
    for (recording, seen) in views {
        let (mut ratios, truth) = (Ratios::default(), Truth::of(recording));
        turns_with(
            &model,
            seen,
            |_| InputSource::Tracked,
            |frame, memory, estimate| {
                if estimate.mode == Mode::Tracking {
                    ratios.take(&model, &truth, frame, memory, estimate);
                }
            },
        );
        all.push(ratios);
    }
    Ok(all)
}

/// A recording, and what its forecasts are judged by.
struct Truth<'r> {
    recording: &'r Recording,
    /// Acceleration of the glass as the step of each frame takes it, m/s2.
    motion: Vec<f64>,
    /// Highest point of each frame's surface, m.
    highest_m: Vec<f32>,
}

impl<'r> Truth<'r> {
    fn of(recording: &'r Recording) -> Self {
        Self { recording, motion: recording.delayed_acceleration_m_s2(), highest_m: recording.highest_m() }
    }
}

impl Ratios {
    /// The numbers by interval, in the order of [`ErrorFactors::quantiles`].
    ///
    /// [`ErrorFactors::quantiles`]: meniscus::uncertainty::error_factors::ErrorFactors::quantiles
    pub(crate) fn by_interval(self) -> [Vec<f32>; ErrorFactors::QUANTILES] {
        let mut all: [Vec<f32>; ErrorFactors::QUANTILES] = Default::default();
        let own = self.surface.into_iter().chain(self.field).chain(self.planned).chain([self.crest]);
        all.iter_mut().zip(own).for_each(|(slot, ratios)| *slot = ratios);
        all
    }

    /// Adds the forecasts of `frame` with the motion planned.
    fn take_planned(&mut self, model: &Model<'_>, truth: &Truth<'_>, frame: usize, memory: &Memory) {
        let plan = truth.motion.get(frame + 1..).unwrap_or_default();
        for (&lead, ratios) in LEADS[1..].iter().zip(&mut self.planned) {
            if frame + lead < truth.recording.frames() {
                let said = Forecast::new(model, memory, lead, plan);
                let half = said.half_width_m.into_iter();
                add(ratios, truth.recording.profile(frame + lead), &said.surface_m, half);
            }
        }
        let fill_m = truth.recording.glass.fill_m;
        if frame.is_multiple_of(crests::EVERY)
            && let Some(n) = crests::next(&truth.highest_m, fill_m, frame)
            && let Some(said) = Crest::next(model, memory, crests::WITHIN, plan)
            && crests::counts(said.height_m, fill_m)
        {
            let came_m = truth.highest_m[n];
            add(&mut self.crest, &[came_m], &[said.height_m], [said.half_width_m].into_iter());
        }
    }

    fn take(
        &mut self,
        model: &Model<'_>,
        truth: &Truth<'_>,
        frame: usize,
        memory: &Memory,
        estimate: &Estimate,
    ) {
        let recording = truth.recording;
        self.take_planned(model, truth, frame, memory);
        for (&lead, ratios) in LEADS.iter().zip(&mut self.surface) {
            if frame + lead < recording.frames() {
                let said = Forecast::new(model, memory, lead, &[]);
                // The present surface knows the port, a forecast does not.
                let said_m = if lead == 0 { &estimate.surface_m } else { &said.surface_m };
                add(ratios, recording.profile(frame + lead), said_m, said.half_width_m.into_iter());
            }
        }
        if !frame.is_multiple_of(FIELD_EVERY) {
            return;
        }
        let (mut truth, mut said) = (vec![0.0; STATE], vec![0.0; STATE]);
        recording.state(frame, &mut truth);
        field_of(model, estimate, &mut said);
        for (group, ratios) in self.field.iter_mut().enumerate() {
            let range = group_range(group);
            let half = std::iter::repeat_n(estimate.interval.field[group], range.len());
            add(ratios, &truth[range.clone()], &said[range], half);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantile_holds_nine_of_ten() {
        let ratios: Vec<f32> = (1..=100).rev().map(|k| k as f32).collect();
        assert_eq!(quantile(ratios), 90.0);
        assert_eq!(quantile(vec![f32::INFINITY; 4]), 1.0);
        assert_eq!(quantile(Vec::new()), 1.0);
    }
}
