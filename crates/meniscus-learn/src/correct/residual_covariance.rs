//! Residual covariance of step and decoder on the new liquid, from the states of the running filter.
//!
//! ```text
//! c_n  = x^_n - step(x^_(n-1), u_n)            what the measurements of a frame moved the latents by
//! Q    = K C + (1 - K) Q_0 tr C / tr Q_0,      C = < c c^T > / < w >
//! d_i  = < (z_i - S_i(x^))^2 - rho r_i > / < w >,    rho = < (z - S(x^))^2 / r > where w is least
//! ```
//! with the w, Q, d and r of [`meniscus::uncertainty::error_model`], and Q_0 those of the source. Where a filter's covariances are right, what the
//! measurements add to the state tells the covariance of the step's error (Mehra, IEEE Trans. Automat. Control 17 (1972)
//! 693); what the measurements do not reach keeps a share of what the source missed there. A profile states its variance with
//! care, 1 / rho times too large, and a decoder has little error in a surface near rest: what the liquid in motion stands off
//! by more than that is what its shapes have that the latents have not ([`meniscus::uncertainty::discrepancy`]). A glass is round, so that a
//! point and its mirror image miss alike.
//!
//! A blob states Q / rho and d / rho, because only their ratio to the stated r matters to the filter, and the k of heights
//! sqrt(rho) times, because the filter's P is then 1 / rho too large.

use crate::correct::effects::Held;
use crate::correct::parameters::ResidualParameters;
use crate::correct::surface_decoder::SurfaceDecoder;
use crate::correct::training_window::TrainingWindow;
use crate::operators::reference_step::Square;
use meniscus::blob::Tensor;
use meniscus::latent::generic::{Generic, LatentState};
use meniscus::latent::window::WINDOW;
use meniscus::surface::POINTS;
use meniscus::uncertainty::discrepancy::LEAST_M2;
use meniscus_data::blob_file::factors;
use meniscus_data::blob_file::write::Part;

/// Windows with the state of the running filter at each of their frames.
#[derive(Clone, Copy)]
pub(super) struct FilterRun<'a> {
    /// Windows, one a recording.
    pub(super) windows: &'a [TrainingWindow],
    /// States, frame by frame, of the same recordings.
    pub(super) states: &'a [Vec<LatentState>],
}

impl FilterRun<'_> {
    /// Memories of the effects at each of `starts` (window, frame).
    pub(super) fn held(&self, starts: &[(usize, usize)]) -> Vec<Held> {
        starts.iter().map(|&(i, n)| self.states[i][n].held).collect()
    }
}

/// Q, d and rho.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ResidualCovariance {
    process: Square,
    heights: [f64; POINTS],
    rho: f64,
}

impl ResidualCovariance {
    /// As the source's blob states them: Q row by row, and d.
    pub(super) fn stated(process: &[f64], heights: &[f64]) -> Self {
        let mut of_points = [0.0; POINTS];
        of_points.iter_mut().zip(heights).for_each(|(d, stated)| *d = *stated);
        Self { process: Square::from_row_iterator(process.iter().copied()), heights: of_points, rho: 1.0 }
    }

    /// Q with the d and the rho of `other`: the filter that the next ones are measured on follows the heights as closely as
    /// the source's, or each would miss more than the last.
    pub(super) fn with_heights_of(&self, other: &Self) -> Self {
        Self { process: self.process, ..*other }
    }

    /// Puts them in the place of what a blob's `parts` state.
    pub(super) fn put(&self, parts: &mut [Part]) {
        for part in parts.iter_mut() {
            match part.tensor {
                Tensor::ProcessSpread => {
                    let rows = self.process.transpose();
                    part.values = rows.iter().map(|q| (q / self.rho) as f32).collect();
                }
                Tensor::SurfaceMisfit => {
                    part.values = self.heights.iter().map(|d| (d / self.rho) as f32).collect();
                }
                _ => {}
            }
        }
        let care = self.rho.sqrt() as f32;
        factors::change(parts, |of| of.surface.iter_mut().for_each(|k| *k *= care));
    }

    /// Residuals over `run` under `generic`; `self` are the source's.
    pub(super) fn measured(
        &self,
        generic: &Generic<'_>,
        surface: &SurfaceDecoder,
        floor: f64,
        run: &FilterRun<'_>,
        parameters: &ResidualParameters,
    ) -> Self {
        let (mut frames, mut moved) = (Vec::new(), Square::zeros());
        for (window, filter_states) in run.windows.iter().zip(run.states) {
            let said = surface.heights(filter_states);
            for n in WINDOW + 1..window.frames().min(filter_states.len()) {
                let (mut predicted, x) = (filter_states[n - 1], &filter_states[n].latent);
                generic.step(&mut predicted, f64::from(window.u[n]));
                let c = x - predicted.latent;
                moved += c * c.transpose();
                frames.push(FrameResiduals::new(window, &said, n, floor + generic.potential.value(x)));
            }
        }
        let weight: f64 = frames.iter().map(|frame| frame.w).sum();
        let moved = moved / weight.max(f64::MIN_POSITIVE);
        let size = moved.trace() / self.process.trace().max(f64::MIN_POSITIVE);
        if !(size > 0.0 && size.is_finite()) {
            return *self;
        }
        let rho = rho(&mut frames, parameters);
        let measured = parameters.measured_share;
        let misfit = |point: usize| {
            let pair = [point, POINTS - 1 - point];
            let points = || frames.iter().flat_map(|f| pair.map(|point| (f.w, f.points[point])));
            let over = points().filter_map(|(_, off)| off.map(|[square, r]| square - rho * r)).sum::<f64>();
            let seen = points().filter(|(_, off)| off.is_some()).map(|(w, _)| w).sum::<f64>();
            over / seen.max(f64::MIN_POSITIVE)
        };
        let mut heights = self.heights;
        heights.iter_mut().enumerate().for_each(|(point, d)| *d = d.max(misfit(point)));
        Self { process: moved * measured + self.process * ((1.0 - measured) * size), heights, rho }
    }
}

/// w of a frame, and (z - S)^2 and r of every height that was seen in it.
struct FrameResiduals {
    w: f64,
    points: [Option<[f64; 2]>; POINTS],
}

impl FrameResiduals {
    /// Residuals of frame `n` of `window`, where the decoder has `said` all heights over rest.
    fn new(window: &TrainingWindow, said: &[f32], n: usize, w: f64) -> Self {
        let point = |point: usize| {
            let at = n * POINTS + point;
            let off = f64::from(window.height[at] - said[at]);
            (window.seen[at] > 0.0).then_some([off * off, f64::from(window.noise[at]).max(LEAST_M2)])
        };
        Self { w, points: std::array::from_fn(point) }
    }
}

/// rho of `frames`, which it puts in the order of their w.
fn rho(frames: &mut [FrameResiduals], parameters: &ResidualParameters) -> f64 {
    frames.sort_by(|a, b| a.w.total_cmp(&b.w));
    let still = &frames[..(parameters.still_share * frames.len() as f64) as usize];
    let points = || still.iter().flat_map(|frame| frame.points.iter().flatten());
    let (sum, count) = (points().map(|[square, r]| square / r).sum::<f64>(), points().count());
    let [least, most] = parameters.noise_ratio_bounds;
    if count == 0 { most } else { (sum / count as f64).clamp(least, most) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correct::checkpoint_parts::CheckpointParts;
    use crate::networks::noise::normal;
    use meniscus::blob::Model;
    use meniscus::latent::generic::Latent;
    use meniscus_platform::files::AlignedBytes;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    /// Residuals of `run` under the model `blob`, whose `parts` these are.
    fn measured(blob: &[u8], parts: &CheckpointParts, floor: f64, run: &FilterRun<'_>) -> ResidualCovariance {
        let generic = Model::load(blob).expect("the shipped model").generic;
        parts.residuals.measured(&generic, &parts.surface, floor, run, &ResidualParameters::default())
    }

    /// Residuals hidden in a liquid's motion and heights are found: those of the step, the places of the decoder's, and
    /// that the profiles state twice the noise that they have (rho = 0.25).
    #[test]
    fn what_is_hidden_is_measured() {
        let blob = AlignedBytes::copy(meniscus_shipped::MODEL);
        let parts = CheckpointParts::new(&blob).expect("the shipped model");
        let generic = Model::load(&blob).expect("the shipped model").generic;
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let (frames, r, floor) = (3000, 1e-6_f64, 0.01);
        let (mut state, mut filter_states) = (LatentState::default(), Vec::new());
        for n in 0..frames {
            // Lively for three quarters of the time; the second latent is missed three times as far as any other.
            let life = if n % 1000 < 250 { 1e-3 } else { 0.1 };
            let miss = Latent::from_fn(|i, _| life * normal(&mut rng) * if i == 1 { 3.0 } else { 1.0 });
            if n % 1000 == 0 {
                state = LatentState::default();
            } else {
                generic.step(&mut state, 0.0);
            }
            state.latent += miss;
            filter_states.push(state);
        }
        let said = parts.surface.heights(&filter_states);
        let misfit = |point: usize| if (3..=17).contains(&point) { 1e-8 } else { 4e-6 };
        let height = (0..frames * POINTS).map(|at| {
            let w = floor + generic.potential.value(&filter_states[at / POINTS].latent);
            let off =
                (0.25 * r).sqrt() * normal(&mut rng) + (w * misfit(at % POINTS)).sqrt() * normal(&mut rng);
            said[at] + off as f32
        });
        let window = TrainingWindow {
            u: vec![0.0; frames],
            height: height.collect(),
            seen: vec![1.0; frames * POINTS],
            noise: vec![r as f32; frames * POINTS],
            read: vec![1.0; frames],
            hidden: vec![],
        };
        let found =
            measured(&blob, &parts, floor, &FilterRun { windows: &[window], states: &[filter_states] });
        assert!((found.rho - 0.25).abs() < 0.03, "rho {}", found.rho);
        assert!((found.heights[1] / 4e-6 - 1.0).abs() < 0.15, "{:?}", found.heights);
        assert!(found.heights[10] < 1e-7, "{:?}", found.heights);
        let q = |i: usize| found.process[(i, i)];
        // A tenth of Q keeps the shape of the source's.
        assert!(q(1) > 5.0 * q(0) && q(1) > 5.0 * q(5), "{}", found.process);
    }

    /// Of nothing nothing is learnt.
    #[test]
    fn without_frames_the_source_stays() {
        let blob = AlignedBytes::copy(meniscus_shipped::MODEL);
        let parts = CheckpointParts::new(&blob).expect("the shipped model");
        assert_eq!(measured(&blob, &parts, 0.01, &FilterRun { windows: &[], states: &[] }), parts.residuals);
    }
}
