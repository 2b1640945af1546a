//! candle, layer by layer: it reads no graph with a GRU, so the equations are written out.

use crate::Peer;
use crate::networks::{DT, GROUPS, Layer, Networks, Places};
use candle_core::{Device, Tensor};
use std::hint::black_box;

/// A dense layer: the weights turned round and contiguous, as the product takes them.
struct Dense {
    weights: Tensor,
    bias: Tensor,
    relu: bool,
}

struct Candle {
    gru: Vec<[Dense; 2]>,
    head: Dense,
    spnn: Vec<Dense>,
    decoders: Vec<Vec<Dense>>,
    places: [Tensor; 4],
    zero: Tensor,
}

impl Dense {
    fn new(layer: &Layer<'_>) -> candle_core::Result<Self> {
        let weights = Tensor::from_slice(layer.weights, (layer.rows, layer.columns), &Device::Cpu)?;
        let bias = Tensor::from_slice(layer.bias, (1, layer.rows), &Device::Cpu)?;
        Ok(Self { weights: weights.t()?.contiguous()?, bias, relu: layer.relu })
    }

    fn apply(&self, x: &Tensor) -> candle_core::Result<Tensor> {
        let y = (x.matmul(&self.weights)? + &self.bias)?;
        if self.relu { y.relu() } else { Ok(y) }
    }
}

/// The networks in candle.
pub fn peer(networks: &Networks) -> anyhow::Result<Box<dyn Peer>> {
    let all = |layers: Vec<Layer<'_>>| layers.iter().map(Dense::new).collect::<candle_core::Result<Vec<_>>>();
    let mut gru = Vec::new();
    for k in 0..3 {
        let half = |part: &str| anyhow::Ok(Dense::new(&networks.layer(&format!("gru.{k}.{part}"), false)?)?);
        gru.push([half("input")?, half("hidden")?]);
    }
    let mut decoders = Vec::new();
    for (group, _) in GROUPS {
        decoders.push(all(networks.decoder(group)?)?);
    }
    let places = Places::new();
    let at = |numbers: Vec<i64>| Tensor::new(numbers, &Device::Cpu);
    Ok(Box::new(Candle {
        gru,
        head: Dense::new(&networks.layer("head", false)?)?,
        spnn: all(networks.spnn()?)?,
        decoders,
        places: [at(places.skew)?, at(places.factor)?, at(places.de)?, at(places.ds)?],
        zero: Tensor::zeros(1, candle_core::DType::F32, &Device::Cpu)?,
    }))
}

fn sigmoid(x: &Tensor) -> candle_core::Result<Tensor> {
    (x.neg()?.exp()? + 1.0)?.recip()
}

impl Candle {
    fn field(&self, window: &[f32]) -> candle_core::Result<Tensor> {
        let rows = Tensor::from_slice(window, (16, 42), &Device::Cpu)?;
        let rest = Tensor::zeros((1, 26), candle_core::DType::F32, &Device::Cpu)?;
        let mut memory = [rest.clone(), rest.clone(), rest];
        for k in 0..16 {
            let mut below = rows.narrow(0, k, 1)?;
            for ([input, hidden], h) in self.gru.iter().zip(&mut memory) {
                let (i, r) = (input.apply(&below)?, hidden.apply(h)?);
                let gate = |x: &Tensor, k: usize| x.narrow(1, 26 * k, 26);
                let reset = sigmoid(&(gate(&i, 0)? + gate(&r, 0)?)?)?;
                let update = sigmoid(&(gate(&i, 1)? + gate(&r, 1)?)?)?;
                let new = (gate(&i, 2)? + (reset * gate(&r, 2)?)?)?.tanh()?;
                *h = (&new + (update * (&*h - &new)?)?)?;
                below = h.clone();
            }
        }
        let latent = self.head.apply(&memory[2])?;
        let mut out = latent.clone();
        for layer in &self.spnn {
            out = layer.apply(&out)?;
        }
        let out = out.flatten_all()?;
        let all = Tensor::cat(&[&out, &out.neg()?, &out.abs()?, &self.zero], 0)?;
        let [skew, factor, de, ds] = &self.places;
        let pick = |at: &Tensor, shape: (usize, usize)| all.index_select(at, 0)?.reshape(shape);
        let (skew, factor) = (pick(skew, (13, 13))?, pick(factor, (13, 13))?);
        let inner = factor.t()?.matmul(&pick(ds, (13, 1))?)?;
        let rate = (skew.matmul(&pick(de, (13, 1))?)? + factor.matmul(&inner)?)?;
        let end = (latent.flatten_all()? + (rate.flatten_all()? * f64::from(DT))?)?;
        let (mut first, mut fields) = (0, Vec::new());
        for (decoder, (_, dealt)) in self.decoders.iter().zip(GROUPS) {
            let width = decoder.first().map_or(0, |layer| layer.weights.dims()[0]);
            let mut x =
                end.narrow(0, first, dealt)?.pad_with_zeros(0, 0, width - dealt)?.reshape((1, width))?;
            for layer in decoder {
                x = layer.apply(&x)?;
            }
            fields.push(x);
            first += dealt;
        }
        Tensor::cat(&fields, 1)
    }
}

impl Peer for Candle {
    fn run(&mut self, window: &[f32], keep: Option<&mut Vec<f32>>) -> anyhow::Result<()> {
        let field = self.field(window)?;
        if let Some(keep) = keep {
            keep.extend(field.flatten_all()?.to_vec1::<f32>()?);
        }
        black_box(field);
        Ok(())
    }
}
