//! The networks, as `meniscus bench` writes them down.

use anyhow::{Context, ensure};
use safetensors::SafeTensors;
use std::collections::BTreeMap;

/// Groups in the order of the field, and the latents that each decoder gets.
pub const GROUPS: [(&str, usize); 5] = [("q", 3), ("v", 3), ("e", 1), ("sigma", 3), ("tau", 3)];

/// Time step, s.
pub const DT: f32 = 0.005;

/// Tensors by name.
pub struct Networks(BTreeMap<String, (Vec<f32>, Vec<usize>)>);

/// A dense layer: row-major weights `[rows, columns]`, bias, whether ReLU follows.
pub struct Layer<'n> {
    pub rows: usize,
    pub columns: usize,
    pub weights: &'n [f32],
    pub bias: &'n [f32],
    pub relu: bool,
}

impl Networks {
    /// Reads the file.
    pub fn read(file: &[u8]) -> anyhow::Result<Self> {
        let tensors = SafeTensors::deserialize(file).context("this is not a safetensors file")?;
        let mut all = BTreeMap::new();
        for (name, view) in tensors.tensors() {
            let numbers = view.data().as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
            all.insert(name, (numbers, view.shape().to_vec()));
        }
        Ok(Self(all))
    }

    /// The numbers of a tensor.
    pub fn numbers(&self, name: &str) -> anyhow::Result<Vec<f32>> {
        Ok(self.0.get(name).with_context(|| format!("no tensor {name}"))?.0.clone())
    }

    /// A layer by name.
    pub fn layer(&self, name: &str, relu: bool) -> anyhow::Result<Layer<'_>> {
        let (weights, shape) =
            self.0.get(&format!("{name}.w")).with_context(|| format!("no layer {name}"))?;
        let (bias, _) = self.0.get(&format!("{name}.b")).with_context(|| format!("no bias of {name}"))?;
        ensure!(shape.len() == 2 && bias.len() == shape[0], "layer {name} is misshapen");
        Ok(Layer { rows: shape[0], columns: shape[1], weights, bias, relu })
    }

    /// The layers `PREFIX.0`, `PREFIX.1`, ... with ReLU where `relu` says so of (index, last index).
    pub fn stack(&self, prefix: &str, relu: impl Fn(usize, usize) -> bool) -> anyhow::Result<Vec<Layer<'_>>> {
        let count = (0..).take_while(|k| self.0.contains_key(&format!("{prefix}.{k}.w"))).count();
        (0..count).map(|k| self.layer(&format!("{prefix}.{k}"), relu(k, count - 1))).collect()
    }

    /// The SPNN.
    pub fn spnn(&self) -> anyhow::Result<Vec<Layer<'_>>> {
        self.stack("spnn", |k, last| k < last)
    }

    /// The decoder of a group: first and last layer linear.
    pub fn decoder(&self, group: &str) -> anyhow::Result<Vec<Layer<'_>>> {
        self.stack(group, |k, last| k > 0 && k < last)
    }
}

/// Where the numbers of L and C lie behind each other in (out, -out, |out|, 0), and of DE and DS in out.
pub struct Places {
    pub skew: Vec<i64>,
    pub factor: Vec<i64>,
    pub de: Vec<i64>,
    pub ds: Vec<i64>,
}

impl Places {
    /// L has 78 numbers below its diagonal, C 91 on and below it, with |diagonal|; rows first.
    pub fn new() -> Self {
        let (width, zero) = (195_i64, 3 * 195_i64);
        let (mut skew, mut factor) = (vec![zero; 169], vec![zero; 169]);
        let (mut below, mut on) = (0, 78);
        for i in 0..13_usize {
            for j in 0..i {
                skew[13 * i + j] = below;
                skew[13 * j + i] = below + width;
                below += 1;
            }
            for j in 0..=i {
                factor[13 * i + j] = if i == j { on + 2 * width } else { on };
                on += 1;
            }
        }
        Self { skew, factor, de: (169..182).collect(), ds: (182..195).collect() }
    }
}
