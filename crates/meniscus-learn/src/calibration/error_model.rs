//! Error model of the blob, measured; [`meniscus::uncertainty::error_model`] has the mathematics.
//!
//! Covariances come from the tracks that the gain was fitted on, the misfit of the decoder from what it
//! makes of true latents, and the factors k from runs of the finished blob behind the rendered camera.

use crate::calibration::learnt_model::LearntModel;
use crate::data::dataset::{Frame, Sequence};
use crate::data::groups::SURFACE;
use crate::data::trajectory::Track;
use crate::networks::encoded::EncodedRecordings;
use crate::operators::reference_step::{Dynamics, Square};
use meniscus::blob::Tensor;
use meniscus::latent::generic::MAX_HIDDEN;
use meniscus::latent::generic::{LATENTS, Latent};
use meniscus::latent::window::WINDOW;
use meniscus::surface::POINTS;
use meniscus::uncertainty::error_factors::ErrorFactors;
use meniscus::uncertainty::error_model::SPREAD_GROUPS;
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_data::blob_file::factors;
use meniscus_data::blob_file::write::Part;

const _: () = assert!(crate::operators::reference_step::HIDDEN <= MAX_HIDDEN);

/// Distance from rest at which a slope is taken, in units of H: half of what a lively slosh has.
const SLOPE_AT: f64 = 0.5;

/// A slosh below this share of a lively one counts as rest.
pub(crate) const REST: f64 = 0.02;

/// Everything but the factors k.
#[derive(Clone, Debug)]
pub(crate) struct MeasuredErrors {
    transition: Square,
    process: Square,
    reading: Square,
    /// `POINTS x LATENTS`, row-major, m.
    surface: Vec<f32>,
    /// `4 LATENTS x LATENTS`, row-major.
    groups: Vec<f32>,
    surface_misfit: Vec<f32>,
    group_misfit: Vec<f32>,
    floor: f64,
}

/// A = (1 - dt/2 F Q)^-1 (1 + dt/2 F Q): the closed step about rest, F = L - D, Q = grad^2 H(0).
#[must_use]
pub(crate) fn transition(dynamics: &Dynamics) -> Square {
    let half = dynamics.flow() * dynamics.stiffness() * (0.5 * FRAME_INTERVAL_S);
    let identity = Square::identity();
    (identity - half).try_inverse().map_or(identity, |inverse| inverse * (identity + half))
}

/// Sum of `of` over all tracks from the first full window on, over the sum of w.
fn per_weight(tracks: &[Track], of: &dyn Fn(&Track, usize) -> Latent, w: &dyn Fn(&Latent) -> f64) -> Square {
    let (mut sum, mut weight) = (Square::zeros(), 0.0);
    for track in tracks {
        for n in WINDOW..track.truth.len() {
            let miss = of(track, n);
            sum += miss * miss.transpose();
            weight += w(&track.truth[n]);
        }
    }
    sum / f64::max(weight, f64::MIN_POSITIVE)
}

/// The floor of w: the slosh at which the reading's error has grown to twice that at rest.
fn floor(dynamics: &Dynamics, tracks: &[Track], metric: &Square) -> f64 {
    let (mut still, mut moving, mut slosh) = ((0.0, 0.0_f64), (0.0, 0.0_f64), 0.0);
    for track in tracks {
        for (y, truth) in track.y.iter().zip(&track.truth).skip(WINDOW) {
            let (energy, miss) = (dynamics.energy(truth), (metric * (y - truth)).norm_squared());
            let sum = if energy < REST { &mut still } else { &mut moving };
            *sum = (sum.0 + miss, sum.1 + 1.0);
            slosh += if energy < REST { 0.0 } else { energy };
        }
    }
    let mean = |(sum, count): (f64, f64)| sum / count.max(1.0);
    let (still, slosh) = (mean(still), slosh / moving.1.max(1.0));
    let growth = (mean(moving) - still).max(f64::MIN_POSITIVE) / slosh.max(f64::MIN_POSITIVE);
    (still / growth).clamp(1e-3, 10.0)
}

impl MeasuredErrors {
    /// Measures everything on `tracks` and on the recordings of `held`.
    #[must_use]
    pub(crate) fn new(
        model: &LearntModel,
        tracks: &[Track],
        held: &EncodedRecordings,
        metric: &Square,
    ) -> Self {
        let (dynamics, frame) = (&model.dynamics, &model.frame);
        let floor = floor(dynamics, tracks, metric);
        let w = |x: &Latent| floor + dynamics.energy(x);
        let step =
            |track: &Track, n: usize| track.truth[n] - dynamics.turn(&track.truth[n - 1], track.u[n]).x;
        let process = per_weight(tracks, &step, &w);
        let reading = per_weight(tracks, &|track, n| track.y[n] - track.truth[n], &w);
        let slope = slope(model);
        let (surface_misfit, group_misfit) = misfit(model, held, &w);
        let ranges = frame.ranges();
        let mut groups = Vec::new();
        for (range, basis) in ranges.iter().zip(&frame.bases).take(SPREAD_GROUPS) {
            // The modes are orthonormal, so that |field|^2 = |coefficients|^2.
            let numbers = basis.modes.nrows() as f64;
            let dot =
                |i: usize, j: usize| range.clone().map(|c| slope[i][c] * slope[j][c]).sum::<f64>() / numbers;
            groups.extend((0..LATENTS * LATENTS).map(|k| dot(k / LATENTS, k % LATENTS) as f32));
        }
        let modes = &frame.bases[SURFACE].modes;
        let height = |point: usize, latent: usize| {
            let c = ranges[SURFACE].clone().map(|c| slope[latent][c]);
            modes.row(point).iter().zip(c).map(|(m, c)| f64::from(*m) * c).sum::<f64>() as f32
        };
        let surface = (0..POINTS * LATENTS).map(|k| height(k / LATENTS, k % LATENTS)).collect();
        let transition = transition(dynamics);
        Self { transition, process, reading, surface, groups, surface_misfit, group_misfit, floor }
    }

    /// Returns the tensors, with the factors of a blob that is not calibrated.
    #[must_use]
    pub(crate) fn parts(&self) -> Vec<Part> {
        let part =
            |tensor, rows, columns, values: &[f32]| Part { tensor, rows, columns, values: values.to_vec() };
        let square = |tensor, m: &Square| {
            let values: Vec<f32> = m.transpose().iter().map(|&v| v as f32).collect();
            part(tensor, LATENTS, LATENTS, &values)
        };
        vec![
            square(Tensor::Transition, &self.transition),
            square(Tensor::ProcessSpread, &self.process),
            square(Tensor::ReadingSpread, &self.reading),
            part(Tensor::SurfaceSlope, POINTS, LATENTS, &self.surface),
            part(Tensor::GroupSlope, SPREAD_GROUPS * LATENTS, LATENTS, &self.groups),
            part(Tensor::SurfaceMisfit, POINTS, 1, &self.surface_misfit),
            part(Tensor::GroupMisfit, SPREAD_GROUPS, 1, &self.group_misfit),
            factors::part(&ErrorFactors::uncalibrated(self.floor as f32)),
        ]
    }
}

/// Slope of the coefficients in each latent, SI units: the secant through two states of a lively slosh.
fn slope(model: &LearntModel) -> Vec<Vec<f64>> {
    let stiffness = model.dynamics.stiffness();
    let aside = |latent: usize| {
        let mut x = Latent::zeros();
        x[latent] = (2.0 * SLOPE_AT / stiffness[(latent, latent)].max(1e-6)).sqrt();
        x
    };
    let states: Vec<Latent> = (0..LATENTS).flat_map(|l| [aside(l), -aside(l)]).collect();
    let coefficients = model.autoencoder.decode(&states, &model.frame);
    let width = model.frame.width();
    let pair = |latent: usize| {
        let (up, down) = coefficients[2 * latent * width..2 * (latent + 1) * width].split_at(width);
        let way = 2.0 * aside(latent)[latent];
        up.iter().zip(down).map(|(u, d)| f64::from(u - d) / way).collect()
    };
    (0..LATENTS).map(pair).collect()
}

/// Variance of what the decoder makes of true latents, for a unit of w: of each height, and of one number
/// of each group.
fn misfit(model: &LearntModel, held: &EncodedRecordings, w: &dyn Fn(&Latent) -> f64) -> (Vec<f32>, Vec<f32>) {
    let frame = &model.frame;
    let (mut heights, mut groups, mut weight) = (vec![0.0; POINTS], vec![0.0; SPREAD_GROUPS], 0.0);
    for (sequence, latents) in held.sequences.iter().zip(&held.latents) {
        let said = model.autoencoder.decode(latents, frame);
        weight += latents.iter().map(w).sum::<f64>();
        for (n, row) in said.chunks_exact(frame.width()).enumerate() {
            add_misfit(frame, sequence, n, row, &mut heights, &mut groups);
        }
    }
    let per = |sums: Vec<f64>| sums.into_iter().map(|s| (s / weight.max(f64::MIN_POSITIVE)) as f32).collect();
    (per(heights), per(groups))
}

/// Adds the squares that frame `n` of `sequence` is missed by.
fn add_misfit(
    frame: &Frame,
    sequence: &Sequence,
    n: usize,
    said: &[f32],
    heights: &mut [f64],
    groups: &mut [f64],
) {
    let width = frame.width();
    let truth = &sequence.coefficients[n * width..(n + 1) * width];
    let ranges = frame.ranges();
    for ((range, basis), group) in ranges.iter().zip(&frame.bases).zip(groups.iter_mut()) {
        let pairs = truth[range.clone()].iter().zip(&said[range.clone()]);
        let square: f64 = pairs.map(|(t, s)| f64::from(t - s).powi(2)).sum();
        *group += square / basis.modes.nrows() as f64;
    }
    let modes = &frame.bases[SURFACE].modes;
    let range = ranges[SURFACE].clone();
    for (point, height) in heights.iter_mut().enumerate() {
        let pairs = truth[range.clone()].iter().zip(&said[range.clone()]);
        let row = modes.row(point);
        let miss: f32 = pairs.zip(row.iter()).map(|((t, s), m)| (t - s) * m).sum();
        *height += f64::from(miss).powi(2);
    }
}
