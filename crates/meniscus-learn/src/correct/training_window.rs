//! Training windows of a correction: profiles as the camera side forms them, and the profile measured at the end of each.

use burn::tensor::{Device, Tensor, TensorData};
use meniscus::filter::PORT_LIMIT;
use meniscus::latent::encoder::GRU_LAYERS;
use meniscus::latent::nn::HIDDEN;
use meniscus::latent::window::{FEATURES, Row, Scale, WINDOW};
use meniscus::runtime::{Motion, POINTS_NEEDED};
use meniscus::surface::{POINTS, SurfaceProfile};
use meniscus_optim::nets::gru_layer;
use meniscus_optim::weights::{Matrix, constants, numbers};

/// One recording of the free surface, ready to learn from.
#[derive(Clone, Debug)]
pub(super) struct TrainingWindow {
    /// Port value of every frame.
    pub(super) u: Vec<f32>,
    /// Heights over rest, m, frame by frame, [`POINTS`] each; 0 where not seen.
    pub(super) height: Vec<f32>,
    /// Weight of an error of a height: 1 where it was seen, 0 where not, less where it was stretched.
    pub(super) seen: Vec<f32>,
    /// Variance that the profile states of each height, m2; 0 where not seen.
    pub(super) noise: Vec<f32>,
    /// 1 where the encoder has a reading: a usable profile at the end of a full window.
    pub(super) read: Vec<f32>,
    /// Hidden states of the frozen layers over the window that ends at each frame: `WINDOW x HIDDEN` each.
    pub(super) hidden: Vec<f32>,
}

impl TrainingWindow {
    /// The window of `profiles`; `frozen` are the weights of all GRU layers but the last.
    pub(super) fn new(
        profiles: &[Option<SurfaceProfile>],
        scale: &Scale,
        rest: &[f32],
        frozen: &[Matrix],
    ) -> Self {
        let mut motion = Motion::default();
        let (mut rows, mut u): (Vec<Row>, Vec<f32>) = (Vec::new(), Vec::new());
        let (mut height, mut seen, mut noise, mut read) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for (frame, profile) in profiles.iter().enumerate() {
            let place = profile.and_then(|profile| profile.glass_x_m).map(f64::from);
            let limit = PORT_LIMIT * f64::from(scale.acceleration_m_s2);
            let acceleration = motion.update(place).clamp(-limit, limit) as f32;
            let usable = profile.as_ref().filter(|profile| profile.valid_points() >= POINTS_NEEDED);
            rows.push(scale.row(usable, acceleration));
            u.push(acceleration / scale.acceleration_m_s2);
            read.push(if usable.is_some() && frame + 1 >= WINDOW { 1.0 } else { 0.0 });
            for (point, rest) in rest.iter().enumerate() {
                let there = profile.as_ref().filter(|profile| profile.valid[point]);
                height.push(there.map_or(0.0, |profile| profile.height_m[point] - rest));
                noise.push(there.map_or(0.0, |profile| profile.variance_m2[point]));
                seen.push(if there.is_some() { 1.0 } else { 0.0 });
            }
        }
        let hidden = hidden(&rows, frozen);
        Self { u, height, seen, noise, read, hidden }
    }

    /// Number of frames.
    pub(super) fn frames(&self) -> usize {
        self.u.len()
    }

    /// The same with every error counted `weight` times.
    pub(super) fn counted(mut self, weight: f32) -> Self {
        self.seen.iter_mut().for_each(|seen| *seen *= weight);
        self
    }

    /// Mean square of the heights that were seen, m2.
    pub(super) fn mean_square(&self) -> f32 {
        let count: f32 = self.seen.iter().map(|w| w * w).sum();
        let sum: f32 = self.height.iter().zip(&self.seen).map(|(h, w)| (w * h).powi(2)).sum();
        sum / count.max(f32::MIN_POSITIVE)
    }

    /// The frames from `from` to `to` (excluded) as a window of their own.
    pub(super) fn part(&self, from: usize, to: usize) -> Self {
        let cut = |all: &[f32], width: usize| all[from * width..to * width].to_vec();
        Self {
            u: cut(&self.u, 1),
            height: cut(&self.height, POINTS),
            seen: cut(&self.seen, POINTS),
            noise: cut(&self.noise, POINTS),
            read: cut(&self.read, 1),
            hidden: cut(&self.hidden, WINDOW * HIDDEN),
        }
    }
}

/// Hidden states of the frozen layers over the window that ends at each row; rows before the first are
/// the first again, and count for nothing because nothing is read there.
fn hidden(rows: &[Row], frozen: &[Matrix]) -> Vec<f32> {
    let device = Device::flex();
    let step = |k: usize| {
        let window = (0..rows.len()).flat_map(|end| rows[(end + k + 1).saturating_sub(WINDOW)]);
        let values: Vec<f32> = window.collect();
        Tensor::<2>::from_data(TensorData::new(values, [rows.len(), FEATURES]), &device)
    };
    let inputs = (0..WINDOW).map(step).collect();
    let weights = constants(frozen, &device);
    debug_assert_eq!(weights.len(), 4 * (GRU_LAYERS - 1));
    let states = weights.chunks_exact(4).fold(inputs, gru_layer);
    let states: Vec<Vec<f32>> = states.into_iter().map(numbers).collect();
    let of_window = |end: usize| states.iter().flat_map(move |s| &s[end * HIDDEN..(end + 1) * HIDDEN]);
    (0..rows.len()).flat_map(of_window).copied().collect()
}
