//! The depth filters beside frames that the reference library has filtered.
//!
//! A folder holds `manifest.json` (the camera, and a case for each filter and setting) and `frames.npz` (inputs and
//! outputs, `[frame, row, column]`). `tests/fixtures/depth-filters/make.py` makes both from synthetic images.

use meniscus::depth_filters::{
    Decimation, HoleFilling, LANES, Persistence, SizeError, Spatial, SpatialDisparity, Temporal,
    TemporalState, decimate, disparity_factor, fill_holes, threshold, to_depth, to_disparity,
};
use meniscus_platform::files::FileError;
use npyz::npz::NpzArchive;
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// Number of pixels in which one case differs from the library's frames.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Compared {
    /// Name of the case: its array in `frames.npz`.
    pub case: String,
    /// Pixels that differ by any bit.
    pub different: usize,
}

/// Why the frames cannot be compared.
#[derive(Debug)]
pub enum GoldenError {
    /// A file cannot be read.
    File(FileError),
    /// The manifest does not have its form.
    Manifest(PathBuf, serde_json::Error),
    /// An array is absent or does not fit its case.
    Array {
        /// The file of arrays.
        path: PathBuf,
        /// The array.
        name: String,
        /// Fault of the file.
        why: String,
    },
}

impl std::fmt::Display for GoldenError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::File(error) => error.fmt(f),
            Self::Manifest(path, error) => {
                write!(f, "{}: {error}; make it anew with make.py beside it", path.display())
            }
            Self::Array { path, name, why } => write!(f, "{}: array '{name}': {why}", path.display()),
        }
    }
}

impl std::error::Error for GoldenError {}

/// The folder's manifest.
#[derive(Clone, Debug, Deserialize)]
struct Manifest {
    /// Metres a depth unit.
    unit_m: f32,
    /// Distance of the two imagers, metres.
    baseline_m: f32,
    /// Focal length, pixels.
    focal_px: f32,
    cases: Vec<Case>,
}

/// One filter with its settings, the frames that it gets and those that the library made of them.
#[derive(Clone, Debug, Deserialize)]
struct Case {
    input: String,
    output: String,
    #[serde(flatten)]
    filter: Filter,
}

/// A filter with the library's numbers for its settings.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(tag = "filter", rename_all = "snake_case")]
enum Filter {
    HoleFilling { mode: u8 },
    Spatial { alpha: f32, delta: u16, iterations: u8, holes: u8 },
    SpatialDisparity { alpha: f32, delta: f32, iterations: u8, holes: u8, depth: bool },
    Disparity,
    Decimation { factor: usize },
    Temporal { alpha: f32, delta: u16, persistence: usize },
    Threshold { min_m: f32, max_m: f32 },
}

/// Frames of one size, one behind the other; a pixel is its bits, be it a depth or a disparity.
struct Frames {
    width: usize,
    height: usize,
    bits: Vec<u32>,
}

/// A folder of reference frames.
#[derive(Debug)]
pub struct Golden {
    frames: PathBuf,
    manifest: Manifest,
}

/// Returns the folder of the frames that the repository holds.
#[must_use]
pub fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/fixtures/depth-filters")
}

impl Golden {
    /// Reads the manifest in `folder`.
    ///
    /// # Errors
    /// [`GoldenError`], also if the folder holds none.
    pub fn open(folder: &Path) -> Result<Self, GoldenError> {
        let path = folder.join("manifest.json");
        let bytes = std::fs::read(&path)
            .map_err(|cause| GoldenError::File(FileError { path: path.clone(), doing: "read", cause }))?;
        let manifest = serde_json::from_slice(&bytes).map_err(|error| GoldenError::Manifest(path, error))?;
        Ok(Self { frames: folder.join("frames.npz"), manifest })
    }

    /// Filters the inputs of every case and compares the outputs.
    ///
    /// # Errors
    /// [`GoldenError`].
    pub fn compare(&self) -> Result<Vec<Compared>, GoldenError> {
        self.manifest.cases.iter().map(|case| self.one(case)).collect()
    }

    fn one(&self, case: &Case) -> Result<Compared, GoldenError> {
        let input = self.read(&case.input)?;
        let wanted = self.read(&case.output)?;
        let made = self.apply(case.filter, &input).map_err(|why| self.fault(&case.input, why.to_string()))?;
        let unequal = made.iter().zip(&wanted.bits).filter(|(made, wanted)| made != wanted).count();
        let different = unequal + made.len().abs_diff(wanted.bits.len());
        Ok(Compared { case: case.output.clone(), different })
    }

    fn fault(&self, name: &str, why: String) -> GoldenError {
        GoldenError::Array { path: self.frames.clone(), name: name.into(), why }
    }

    fn read(&self, name: &str) -> Result<Frames, GoldenError> {
        let fault = |why: String| self.fault(name, why);
        let mut archive = NpzArchive::open(&self.frames).map_err(|cause| {
            GoldenError::File(FileError { path: self.frames.clone(), doing: "read", cause })
        })?;
        let array = archive.by_name(name).map_err(|why| fault(why.to_string()))?;
        let array = array.ok_or_else(|| fault("is not in the file".into()))?;
        let shape: Vec<usize> = array.shape().iter().map(|&side| side as usize).collect();
        let [_, height, width] = shape[..] else {
            return Err(fault(format!("has the shape {shape:?}, not [frame, row, column]")));
        };
        // Depths are two bytes, disparities four.
        let bits = match array.dtype().num_bytes() {
            Some(2) => array.into_vec::<u16>().map(|z| z.into_iter().map(u32::from).collect()),
            _ => array.into_vec::<f32>().map(|d| d.into_iter().map(f32::to_bits).collect()),
        };
        Ok(Frames { width, height, bits: bits.map_err(|why| fault(why.to_string()))? })
    }

    /// Returns the bits of the frames that `filter` makes of `input`.
    fn apply(&self, filter: Filter, input: &Frames) -> Result<Vec<u32>, SizeError> {
        let (width, size) = (input.width, input.width * input.height);
        // The temporal filter alone remembers anything from frame to frame.
        let (mut last, mut history) = (vec![0; size], vec![0; size]);
        let mut memory = TemporalState::new(&mut last, &mut history);
        let mut made = Vec::new();
        for frame in input.bits.chunks_exact(size.max(1)) {
            let mut image: Vec<u16> = frame.iter().map(|&z| z as u16).collect();
            match filter {
                Filter::HoleFilling { mode } => fill_holes(&mut image, width, hole_filling(mode))?,
                Filter::Spatial { alpha, delta, iterations, holes } => {
                    let settings = Spatial { alpha, delta, iterations, holes };
                    settings.apply(&mut image, width, &mut vec![[0; LANES]; width])?;
                }
                Filter::Decimation { factor } => {
                    let settings = Decimation::new(factor, (width, input.height));
                    let (small, tall) = settings.output_size();
                    let mut out = vec![0; small * tall];
                    decimate(settings, &image, &mut out)?;
                    image = out;
                }
                Filter::Temporal { alpha, delta, persistence } => {
                    let persistence = PERSISTENCE.get(persistence).copied().unwrap_or_default();
                    Temporal { alpha, delta, persistence }.apply(&mut image, &mut memory)?;
                }
                Filter::Threshold { min_m, max_m } => {
                    threshold(&mut image, self.manifest.unit_m, min_m, max_m);
                }
                Filter::Disparity => {
                    made.extend(self.disparity(&image)?.iter().map(|d| d.to_bits()));
                    continue;
                }
                Filter::SpatialDisparity { alpha, delta, iterations, holes, depth } => {
                    let mut disparity = self.disparity(&image)?;
                    let settings = SpatialDisparity { alpha, delta, iterations, holes };
                    settings.apply(&mut disparity, width, &mut vec![[0.0; LANES]; width])?;
                    if !depth {
                        made.extend(disparity.iter().map(|d| d.to_bits()));
                        continue;
                    }
                    to_depth(&disparity, self.factor(), &mut image)?;
                }
            }
            made.extend(image.iter().map(|&z| u32::from(z)));
        }
        Ok(made)
    }

    fn factor(&self) -> f32 {
        let Manifest { unit_m, baseline_m, focal_px, .. } = self.manifest;
        disparity_factor(baseline_m, focal_px, unit_m)
    }

    fn disparity(&self, depth: &[u16]) -> Result<Vec<f32>, SizeError> {
        let mut disparity = vec![0.0; depth.len()];
        to_disparity(depth, self.factor(), &mut disparity)?;
        Ok(disparity)
    }
}

/// Persistences in the order of the library's numbers.
const PERSISTENCE: [Persistence; 9] = [
    Persistence::Disabled,
    Persistence::In8Of8,
    Persistence::In2Of3,
    Persistence::In2Of4,
    Persistence::In2Of8,
    Persistence::In1Of2,
    Persistence::In1Of5,
    Persistence::In1Of8,
    Persistence::Always,
];

/// Returns the mode of the library's number.
fn hole_filling(mode: u8) -> HoleFilling {
    match mode {
        0 => HoleFilling::Left,
        1 => HoleFilling::Farthest,
        _ => HoleFilling::Nearest,
    }
}
