//! Weights and inputs that the tests and `fixtures/torch/make.py` draw from the same seeds, and what PyTorch made of
//! them.

use npyz::NpyFile;
use npyz::npz::NpzArchive;
use serde_json::Value;
use std::path::PathBuf;

/// Samples in a batch.
pub(crate) const BATCH: usize = 64;

/// The fixtures' folder, read.
pub(crate) struct Seeded {
    folder: PathBuf,
    manifest: Value,
}

impl Seeded {
    /// Reads the manifest; the fixtures are part of the repository, so their absence is a failure.
    pub(crate) fn open() -> Self {
        let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/torch"));
        let text = std::fs::read(folder.join("manifest.json")).expect("the committed manifest.json");
        Self { folder, manifest: serde_json::from_slice(&text).expect("JSON") }
    }

    /// Returns a tensor's numbers, row by row, and its shape.
    pub(crate) fn tensor(&self, name: &str) -> (Vec<f32>, Vec<usize>) {
        let entry = &self.manifest[name];
        let numbers = |key: &str| -> Vec<u64> {
            let values = entry[key].as_array().unwrap_or_else(|| panic!("{name} has no {key}"));
            values.iter().map(|value| value.as_u64().expect("a whole number")).collect()
        };
        let shape: Vec<usize> = numbers("shape").iter().map(|&side| side as usize).collect();
        let scale = numbers("scale");
        let bound = (scale[0] as f64 / scale[1] as f64).sqrt();
        (draw(name, shape.iter().product(), bound), shape)
    }

    /// Returns one of PyTorch's arrays, row by row.
    pub(crate) fn reference(&self, name: &str) -> Vec<f64> {
        let path = self.folder.join("reference.npz");
        let mut archive = NpzArchive::open(path).expect("the committed reference.npz");
        let file: NpyFile<_> = archive.by_name(name).expect(name).expect(name);
        match file.dtype().num_bytes() {
            Some(8) => file.into_vec::<f64>().expect(name),
            _ => file.into_vec::<f32>().expect(name).into_iter().map(f64::from).collect(),
        }
    }
}

/// Uniform numbers in +-`bound`. The seed is FNV-1a of the name; number i is output i of SplitMix64 (G. L. Steele,
/// D. Lea and C. H. Flood, OOPSLA 2014), of which the upper 24 bits are used.
fn draw(name: &str, count: usize, bound: f64) -> Vec<f32> {
    let seed = name.bytes().fold(0xCBF2_9CE4_8422_2325_u64, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01B3)
    });
    let numbers = (1..=count as u64).map(|i| {
        let z = seed.wrapping_add(i.wrapping_mul(0x9E37_79B9_7F4A_7C15));
        let z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        let unit = ((z ^ (z >> 31)) >> 40) as f64 / f64::from(1 << 23) - 1.0;
        (unit * bound) as f32
    });
    numbers.collect()
}

/// Relative L2 difference.
pub(crate) fn difference(ours: impl IntoIterator<Item = f64>, theirs: &[f64]) -> f64 {
    let ours: Vec<f64> = ours.into_iter().collect();
    assert_eq!(ours.len(), theirs.len());
    let square = |sum: f64, x: f64| sum + x * x;
    let error = ours.iter().zip(theirs).map(|(a, b)| a - b).fold(0.0, square);
    (error / theirs.iter().copied().fold(0.0, square)).sqrt()
}
