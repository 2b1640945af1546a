//! tract, on the same graph.

use crate::Peer;
use anyhow::Context;
use std::hint::black_box;
use std::sync::Arc;
use tract_onnx::prelude::*;

struct Tract(Arc<TypedRunnableModel>);

/// The model in tract, optimised.
pub fn peer(model: &[u8]) -> anyhow::Result<Box<dyn Peer>> {
    let mut bytes = model;
    let model = tract_onnx::onnx().model_for_read(&mut bytes).context("tract does not read the graph")?;
    let model = model.into_optimized().context("tract does not optimise the graph")?;
    Ok(Box::new(Tract(model.into_runnable()?)))
}

impl Peer for Tract {
    fn run(&mut self, window: &[f32], keep: Option<&mut Vec<f32>>) -> anyhow::Result<()> {
        let input = Tensor::from_shape(&[16, 1, 42], window)?;
        let output = self.0.run(tvec!(input.into()))?;
        let field = output[0].to_plain_array_view::<f32>()?;
        if let Some(keep) = keep {
            keep.extend(field.iter());
        }
        black_box(field);
        Ok(())
    }
}
