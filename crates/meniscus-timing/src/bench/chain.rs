//! The paper's chain on the camera side's kernels: window to full field, nothing allocated.

use super::networks::{DEALT, DT, FIELD, Layer, Networks, WINDOW};
use meniscus::blob::Tensor;
use meniscus::latent::nn::{Dense, Element, Gru, HIDDEN, Weights, relu, section_len};
use meniscus_data::blob_file::write::{Part, pack};
use meniscus_platform::files::AlignedBytes;

/// Widest layer but the last ones.
const ROOM: usize = 256;

/// Layers packed in one run of memory, as in a blob.
#[derive(Debug)]
pub struct Packed {
    bytes: AlignedBytes,
    places: Vec<(std::ops::Range<usize>, Element, usize, usize)>,
    biases: Vec<Vec<f32>>,
    relus: Vec<bool>,
    spnn: usize,
    decoders: Vec<usize>,
}

impl Packed {
    /// `networks` with GRU, SPNN and decoders in the element that `element` gives for the name of a layer.
    #[must_use]
    pub fn new(networks: &Networks, element: impl Fn(&Layer) -> Element) -> Self {
        let mut bytes = Vec::new();
        let (mut places, mut biases, mut relus) = (Vec::new(), Vec::new(), Vec::new());
        for layer in networks.layers() {
            let element = element(layer);
            let start = bytes.len();
            let length = section_len(element, layer.rows, layer.columns).unwrap_or(0);
            bytes.resize((start + length).next_multiple_of(64), 0);
            let part = Part {
                // Only a name; packing does not look at it.
                tensor: Tensor::HeadWeight,
                rows: layer.rows,
                columns: layer.columns,
                values: layer.weights.clone(),
            };
            pack(&part, element, &mut bytes[start..start + length]);
            places.push((start..start + length, element, layer.rows, layer.columns));
            biases.push(layer.bias.clone());
            relus.push(layer.relu);
        }
        Self {
            bytes: AlignedBytes::copy(&bytes),
            places,
            biases,
            relus,
            spnn: networks.spnn.len(),
            decoders: networks.decoders.iter().map(Vec::len).collect(),
        }
    }

    /// Bytes of weights that a call reads.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.bytes.len()
    }

    /// The weights as they lie.
    #[must_use]
    pub fn memory(&self) -> &[u8] {
        &self.bytes
    }

    /// The chain over these weights; `None` if a layer has not the shape that the chain needs.
    #[must_use]
    pub fn chain(&self) -> Option<Chain<'_>> {
        let mut all = Vec::new();
        for (index, (place, element, rows, columns)) in self.places.iter().enumerate() {
            let weights = Weights::new(*element, &self.bytes[place.clone()], *rows, *columns)?;
            all.push((Dense { weights, bias: &self.biases[index] }, self.relus[index]));
        }
        let mut all = all.into_iter();
        let mut gru = Vec::new();
        for _ in 0..3 {
            let ((input, _), (hidden, _)) = (all.next()?, all.next()?);
            gru.push(Gru {
                input: input.weights,
                hidden: hidden.weights,
                input_bias: input.bias,
                hidden_bias: hidden.bias,
            });
        }
        let (head, _) = all.next()?;
        let spnn = all.by_ref().take(self.spnn).collect();
        let decoders = self.decoders.iter().map(|count| all.by_ref().take(*count).collect()).collect();
        Some(Chain { gru, head, spnn, decoders })
    }
}

/// The networks at work.
#[derive(Debug)]
pub struct Chain<'p> {
    gru: Vec<Gru<'p>>,
    head: Dense<'p>,
    spnn: Vec<(Dense<'p>, bool)>,
    decoders: Vec<Vec<(Dense<'p>, bool)>>,
}

impl Chain<'_> {
    /// Latents of a window.
    #[must_use]
    pub fn encode(&self, window: &[f32]) -> [f32; 13] {
        let mut memory = [[0.0; HIDDEN]; 3];
        for row in window.chunks(WINDOW.1) {
            let mut below = row;
            for (layer, h) in self.gru.iter().zip(&mut memory) {
                layer.step(below, h);
                below = h;
            }
        }
        let mut x = [0.0; 13];
        self.head.apply(&memory[2], &mut x);
        x
    }

    /// One step of the paper's kind: x1 = x + dt (L DE + M DS), M = C C^T with a diagonal of C that is not negative.
    #[must_use]
    pub fn step(&self, x: &[f32; 13]) -> [f32; 13] {
        let out = through(&self.spnn, x);
        let (triangles, rest) = out.split_at(78 + 91);
        let (skew, factor) = triangles.split_at(78);
        let (de, ds) = rest[..26].split_at(13);
        let mut x1 = *x;
        let (mut transposed, mut at) = ([0.0_f32; 13], 0);
        for i in 0..13 {
            for j in 0..i {
                x1[i] += DT * skew[at] * de[j];
                x1[j] -= DT * skew[at] * de[i];
                at += 1;
            }
        }
        let entry = |at: usize, diagonal: bool| if diagonal { factor[at].abs() } else { factor[at] };
        at = 0;
        for (i, &s) in ds.iter().enumerate() {
            for (j, sum) in transposed.iter_mut().enumerate().take(i + 1) {
                *sum += entry(at, i == j) * s;
                at += 1;
            }
        }
        at = 0;
        for (i, x1) in x1.iter_mut().enumerate() {
            for (j, c) in transposed.iter().enumerate().take(i + 1) {
                *x1 += DT * entry(at, i == j) * c;
                at += 1;
            }
        }
        x1
    }

    /// The full field of latents.
    pub fn decode(&self, x: &[f32; 13], field: &mut [f32]) {
        let (mut rest, mut first) = (field, 0);
        for (decoder, dealt) in self.decoders.iter().zip(DEALT) {
            let Some(((last, _), before)) = decoder.split_last() else { continue };
            let hidden = through(before, &x[first..first + dealt]);
            let (part, tail) = rest.split_at_mut(last.weights.rows());
            last.apply(&hidden, part);
            (rest, first) = (tail, first + dealt);
        }
    }

    /// Returns the input of the last layer of decoder `group`.
    #[must_use]
    pub fn last_input(&self, group: usize, x: &[f32; 13]) -> [f32; ROOM] {
        let first: usize = DEALT[..group].iter().sum();
        let decoder = &self.decoders[group];
        through(&decoder[..decoder.len() - 1], &x[first..first + DEALT[group]])
    }

    /// Window to field.
    pub fn run(&self, window: &[f32], field: &mut [f32]) {
        let x = self.step(&self.encode(window));
        self.decode(&x, field);
    }

    /// A field's room.
    #[must_use]
    pub fn field() -> Vec<f32> {
        vec![0.0; FIELD]
    }
}

/// x through layers, ReLU where it belongs.
fn through(layers: &[(Dense<'_>, bool)], x: &[f32]) -> [f32; ROOM] {
    let mut now = [0.0; ROOM];
    now[..x.len()].copy_from_slice(x);
    for (layer, is_relu) in layers {
        let mut next = [0.0; ROOM];
        layer.apply(&now, &mut next);
        if *is_relu {
            relu(&mut next);
        }
        now = next;
    }
    now
}
