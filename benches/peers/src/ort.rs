//! ONNX Runtime, from the library that ORT_DYLIB_PATH names.

use crate::Peer;
use anyhow::Context;
use ort::session::Session;
use ort::session::builder::GraphOptimizationLevel;
use ort::value::TensorRef;
use std::hint::black_box;

struct Ort(Session);

/// The model in ONNX Runtime, all optimisations, one thread.
pub fn peer(model: &[u8]) -> anyhow::Result<Box<dyn Peer>> {
    let path = std::env::var_os("ORT_DYLIB_PATH").context(
        "ORT_DYLIB_PATH names no libonnxruntime.so; benches/peers/fetch gets one and says where it is",
    )?;
    let environment = ort::init_from(&path)
        .map_err(|error| anyhow::anyhow!("{} does not load: {error}", path.display()))?
        .build()
        .map_err(|error| anyhow::anyhow!("{error}"))?;
    let fails = |error: &dyn std::fmt::Display| anyhow::anyhow!("{error}");
    let session = Session::builder(&environment)
        .map_err(|error| fails(&error))?
        .with_optimization_level(GraphOptimizationLevel::All)
        .map_err(|error| fails(&error))?
        .with_intra_threads(1)
        .map_err(|error| fails(&error))?
        .with_inter_threads(1)
        .map_err(|error| fails(&error))?
        .commit_from_memory(model)
        .map_err(|error| fails(&error))?;
    Ok(Box::new(Ort(session)))
}

impl Peer for Ort {
    fn run(&mut self, window: &[f32], keep: Option<&mut Vec<f32>>) -> anyhow::Result<()> {
        let input =
            TensorRef::from_array_view(([16_usize, 1, 42], window)).map_err(|e| anyhow::anyhow!("{e}"))?;
        let outputs = self.0.run(ort::inputs!["window" => input]).map_err(|e| anyhow::anyhow!("{e}"))?;
        let (_, field) = outputs["field"].try_extract_tensor::<f32>().map_err(|e| anyhow::anyhow!("{e}"))?;
        if let Some(keep) = keep {
            keep.extend_from_slice(field);
        }
        black_box(field);
        Ok(())
    }
}
