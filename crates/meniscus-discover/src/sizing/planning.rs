//! Expected work of a sizing, for the estimate of the time.

use super::candidate::SizingCandidate;
use super::forward::Point;
use super::stage::Stage;
use super::workload::Workload;
use std::sync::PoisonError;

/// Sizes that a search is expected to take beyond the first, for the estimate of the time.
const EXPECTED_MORE: usize = 3;

impl Stage<'_> {
    /// Adds the expected work of all searches and reports it to the observer.
    pub(super) fn announce(&self, candidates: &[SizingCandidate]) {
        let spacings = self.settings.spacings_m();
        let mut workload = self.simulations.workload.lock().unwrap_or_else(PoisonError::into_inner);
        for (n, candidate) in candidates.iter().enumerate() {
            let (others, packings) = (candidate.others().len(), self.settings.packings);
            for (level, spacing_m) in spacings.iter().enumerate() {
                let sets = match level {
                    0 => 3 + EXPECTED_MORE + others + packings - 1,
                    _ if n == 0 => 2 + EXPECTED_MORE + packings - 1,
                    _ => continue,
                };
                let forward = self.forward(candidate, &self.fitted, *spacing_m);
                let parameters: Vec<f64> = candidate
                    .first_sizes()
                    .into_iter()
                    .skip(1)
                    .take(1)
                    .chain(candidate.first_others())
                    .collect();
                let frames: usize = self.fitted.iter().map(|matched| matched.record.frames()).sum();
                if let Some(setup) = forward.setup(&Point { parameters, packing: 0 }) {
                    workload.expect(&setup, sets * frames, sets * self.fitted.len(), sets);
                }
            }
        }
        self.announce_others(&mut workload, candidates);
        let mut progress = workload.progress();
        progress.left_s = workload.estimate_s(self.simulations.simulator, rayon::current_num_threads());
        drop(workload);
        (self.simulations.watch)(progress);
    }

    /// Adds the expected work of the references and of the held-out recording.
    fn announce_others(&self, workload: &mut Workload, candidates: &[SizingCandidate]) {
        let spacings = self.settings.spacings_m();
        for (level, spacing_m) in spacings.iter().enumerate() {
            let forward = self.forward(&candidates[0], &self.fitted, *spacing_m);
            let parameters: Vec<f64> =
                std::iter::once(candidates[0].range().neutral).chain(candidates[0].first_others()).collect();
            let Some(setup) = forward.setup(&Point { parameters, packing: 0 }) else { continue };
            let references = self.fitted.iter().flat_map(|matched| &matched.references);
            let (frames, count) =
                references.fold((0, 0), |(frames, count), (_, record)| (frames + record.frames(), count + 1));
            let packings = self.settings.packings;
            workload.expect(&setup, packings * frames, packings * count, packings);
            if let Some(held_out) = &self.held_out {
                // With and without the effect, and the reference.
                let runs = if level == 0 { 2 + candidates.len() } else { 2 };
                workload.expect(&setup, runs * held_out.record.frames(), runs, runs);
            }
        }
    }
}
