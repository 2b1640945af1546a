//! The paper's networks with random weights by a seed: what the chain and its peers are timed on.
//!
//! ```text
//! window 16 x 42 --GRU 3 x 26, linear--> x (13) --SPNN 13 x 195, 195--> L, C, DE, DS
//! x1 = x + dt (L DE + C C^T DS) --five decoders--> q 6402, v 6402, e 2134, sigma 6402, tau 6402
//! ```
//! The decoders are 20-120-120-q, 20-200-200-200-200-v, 10-40-40-40-e and twice 20-200-200-200; the first and the last layer
//! of each are linear, ReLU between. The 13 latents are dealt out 3, 3, 1, 3, 3; the rest of each bottleneck is
//! zero, as truncated latents are.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use safetensors::tensor::{Dtype, TensorView};

/// Frames of a window, and numbers of a frame (21 points, position and height).
pub const WINDOW: (usize, usize) = (16, 42);

/// Latents of each of q, v, e, sigma, tau.
pub const DEALT: [usize; 5] = [3, 3, 1, 3, 3];

/// Time step, s.
pub const DT: f32 = 0.005;

/// Layer widths of the five decoders.
pub const DECODERS: [&[usize]; 5] = [
    &[20, 120, 120, 6402],
    &[20, 200, 200, 200, 200, 6402],
    &[10, 40, 40, 40, 2134],
    &[20, 200, 200, 200, 6402],
    &[20, 200, 200, 200, 6402],
];

/// Numbers of a field.
pub const FIELD: usize = 27_742;

/// A dense layer.
#[derive(Clone, Debug)]
pub struct Layer {
    /// Name under which its weights are handed on, with `.w` and `.b` behind it.
    pub name: String,
    /// Outputs.
    pub rows: usize,
    /// Inputs.
    pub columns: usize,
    /// Row-major.
    pub weights: Vec<f32>,
    /// One a row.
    pub bias: Vec<f32>,
    /// Whether ReLU follows.
    pub relu: bool,
}

/// All networks of the chain.
#[derive(Clone, Debug)]
pub struct Networks {
    /// Input and recurrent half of each GRU layer, gates stacked r, z, n.
    pub gru: Vec<[Layer; 2]>,
    /// GRU to latents.
    pub head: Layer,
    /// The SPNN.
    pub spnn: Vec<Layer>,
    /// q, v, e, sigma, tau.
    pub decoders: Vec<Vec<Layer>>,
}

impl Networks {
    /// Weights by `seed`, uniform, of the variance that keeps signals as large from layer to layer.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut layer = |name: &str, rows: usize, columns: usize, relu: bool| {
            let gain = if relu { 6.0 } else { 3.0 };
            let reach = (gain / columns as f32).sqrt();
            let mut draw = |count: usize, reach: f32| -> Vec<f32> {
                (0..count).map(|_| reach * (2.0 * random.random::<f32>() - 1.0)).collect()
            };
            let (weights, bias) = (draw(rows * columns, reach), draw(rows, 0.1));
            Layer { name: name.to_string(), rows, columns, weights, bias, relu }
        };
        let gru = (0..3)
            .map(|index| {
                let inputs = if index == 0 { WINDOW.1 } else { 26 };
                [
                    layer(&format!("gru.{index}.input"), 78, inputs, false),
                    layer(&format!("gru.{index}.hidden"), 78, 26, false),
                ]
            })
            .collect();
        let head = layer("head", 13, 26, false);
        let spnn = (0..14)
            .map(|index| layer(&format!("spnn.{index}"), 195, if index == 0 { 13 } else { 195 }, index < 13))
            .collect();
        let decoders = DECODERS
            .iter()
            .zip(["q", "v", "e", "sigma", "tau"])
            .map(|(widths, group)| {
                let last = widths.len() - 2;
                let of = |(index, pair): (usize, &[usize])| {
                    layer(&format!("{group}.{index}"), pair[1], pair[0], index > 0 && index < last)
                };
                widths.windows(2).enumerate().map(of).collect()
            })
            .collect();
        Self { gru, head, spnn, decoders }
    }

    /// All layers.
    pub fn layers(&self) -> impl Iterator<Item = &Layer> {
        let gru = self.gru.iter().flatten();
        gru.chain([&self.head]).chain(&self.spnn).chain(self.decoders.iter().flatten())
    }

    /// Bytes of the weights in f32.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.layers().map(|layer| 4 * (layer.weights.len() + layer.bias.len())).sum()
    }

    /// The networks with a window and what they make of it, as a safetensors file.
    ///
    /// # Errors
    /// What the format says.
    pub fn file(&self, window: &[f32], field: &[f32]) -> Result<Vec<u8>, safetensors::SafeTensorError> {
        let bytes = |numbers: &[f32]| -> Vec<u8> { numbers.iter().flat_map(|x| x.to_le_bytes()).collect() };
        let mut tensors = vec![
            (String::from("window"), vec![WINDOW.0, WINDOW.1], bytes(window)),
            (String::from("field"), vec![field.len()], bytes(field)),
        ];
        for layer in self.layers() {
            tensors.push((
                format!("{}.w", layer.name),
                vec![layer.rows, layer.columns],
                bytes(&layer.weights),
            ));
            tensors.push((format!("{}.b", layer.name), vec![layer.rows], bytes(&layer.bias)));
        }
        let mut views = Vec::new();
        for (name, shape, data) in &tensors {
            views.push((name, TensorView::new(Dtype::F32, shape.clone(), data)?));
        }
        safetensors::serialize(views, None)
    }

    /// Window `index` of a made-up slosh: a travelling wave whose size and pace differ from window to window.
    #[must_use]
    pub fn window(index: usize) -> Vec<f32> {
        let (frames, features) = WINDOW;
        let pace = 0.2 + 0.013 * (index % 29) as f32;
        let size = 0.3 + 0.05 * (index % 17) as f32;
        let number = |k: usize| {
            let (frame, feature) = ((k / features) as f32, (k % features) as f32);
            let phase = 0.7 * index as f32 + pace * frame;
            size * (phase + 0.3 * feature).sin() + 0.2 * size * (1.7 * phase - 0.11 * feature).cos()
        };
        (0..frames * features).map(number).collect()
    }
}
