//! The depth filters beside frames that the reference library has filtered.
//!
//! The folder has a `manifest.json` (file, shape, type, note) and plain little-endian arrays. A file is
//! compared if its name tells which filter made it; of the others it is told that they are not covered.

use meniscus::depth_filters::{
    Decimation, HoleFilling, LANES, Spatial, SpatialDisparity, decimate, disparity_factor, fill_holes,
    to_depth, to_disparity,
};
use meniscus_platform::files::FileError;
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// Baseline, focal length and depth unit of the disparity frames, metres, pixels, metres.
const STEREO: [f32; 3] = [0.05, 383.0, 0.001];

/// One frame and what came of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Compared {
    /// The file.
    pub file: String,
    /// Pixels that differ by any bit; `None` if no filter here makes such a frame.
    pub different: Option<usize>,
}

/// Why the frames cannot be compared.
#[derive(Debug)]
pub enum GoldenError {
    /// A file cannot be read.
    File(FileError),
    /// The manifest is not what it should be.
    Manifest(serde_json::Error),
    /// A file has not the bytes that the manifest states.
    Size(PathBuf, usize),
}

impl std::fmt::Display for GoldenError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::File(error) => error.fmt(f),
            Self::Manifest(error) => write!(f, "the manifest of the reference frames is damaged: {error}"),
            Self::Size(path, wanted) => write!(f, "{} should have {wanted} bytes", path.display()),
        }
    }
}

impl std::error::Error for GoldenError {}

/// An entry of the manifest.
#[derive(Clone, Debug, Deserialize)]
struct Entry {
    file: String,
    shape: [usize; 2],
    dtype: String,
}

/// The folder with its manifest.
#[derive(Debug)]
pub struct Golden {
    folder: PathBuf,
    entries: Vec<Entry>,
}

/// Returns the folder of the frames, if they are there: beside the project.
#[must_use]
pub fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/depth-filters")
}

impl Golden {
    /// Reads the manifest; `None` if there is none.
    ///
    /// # Errors
    /// [`GoldenError`].
    pub fn open(folder: &Path) -> Result<Option<Self>, GoldenError> {
        let path = folder.join("manifest.json");
        if !path.exists() {
            return Ok(None);
        }
        let entries = serde_json::from_slice(&read(&path)?).map_err(GoldenError::Manifest)?;
        Ok(Some(Self { folder: folder.into(), entries }))
    }

    /// Filters the inputs and compares every frame.
    ///
    /// # Errors
    /// [`GoldenError`].
    pub fn compare(&self) -> Result<Vec<Compared>, GoldenError> {
        self.entries.iter().map(|entry| self.one(entry)).collect()
    }

    /// An input frame by its scene, with its width.
    ///
    /// # Errors
    /// [`GoldenError`].
    pub fn input(&self, scene: &str) -> Result<Option<(Vec<u16>, usize)>, GoldenError> {
        let file = format!("in_{scene}.bin");
        let Some(entry) = self.entries.iter().find(|entry| entry.file == file) else { return Ok(None) };
        let bytes = self.bytes(entry, 2)?;
        let pixels = bytes.as_chunks().0.iter().map(|z| u16::from_le_bytes(*z)).collect();
        Ok(Some((pixels, entry.shape[1])))
    }

    fn bytes(&self, entry: &Entry, size: usize) -> Result<Vec<u8>, GoldenError> {
        let path = self.folder.join(&entry.file);
        let (bytes, wanted) = (read(&path)?, entry.shape[0] * entry.shape[1] * size);
        if bytes.len() == wanted { Ok(bytes) } else { Err(GoldenError::Size(path, wanted)) }
    }

    fn one(&self, entry: &Entry) -> Result<Compared, GoldenError> {
        let size = if entry.dtype == "float32" { 4 } else { 2 };
        let wanted = self.bytes(entry, size)?;
        let stem = entry.file.trim_end_matches(".bin");
        let (filter, scene) = stem.rsplit_once('_').unwrap_or((stem, ""));
        let made = self.input(scene)?.and_then(|(image, width)| make(filter, image, width));
        let different = made.map(|made| {
            let pixels = made.chunks_exact(size).zip(wanted.chunks_exact(size));
            pixels.filter(|(made, wanted)| made != wanted).count()
                + made.len().abs_diff(wanted.len()).div_ceil(size)
        });
        Ok(Compared { file: entry.file.clone(), different })
    }
}

fn read(path: &Path) -> Result<Vec<u8>, GoldenError> {
    std::fs::read(path)
        .map_err(|cause| GoldenError::File(FileError { path: path.into(), doing: "read", cause }))
}

/// Returns an image after the filter of that name, as bytes.
fn make(filter: &str, mut image: Vec<u16>, width: usize) -> Option<Vec<u8>> {
    let height = image.len() / width;
    let done = match filter {
        "in" => Ok(()),
        "hole_left" => fill_holes(&mut image, width, HoleFilling::Left),
        "hole_farthest" => fill_holes(&mut image, width, HoleFilling::Farthest),
        "hole_nearest" => fill_holes(&mut image, width, HoleFilling::Nearest),
        "spatial_default" | "spatial_holes2" => {
            let holes = if filter == "spatial_default" { 0 } else { 2 };
            Spatial { holes, ..Spatial::default() }.apply(&mut image, width, &mut vec![[0; LANES]; width])
        }
        "decim2" => {
            let settings = Decimation::new(2, (width, height));
            let (small, tall) = settings.output_size();
            let mut out = vec![0; small * tall];
            let done = decimate(settings, &image, &mut out);
            image = out;
            done
        }
        "disp" | "dispspatial_default" | "dispspatial_default_z" => {
            let [baseline_m, fx_px, unit_m] = STEREO;
            let factor = disparity_factor(baseline_m, fx_px, unit_m);
            let mut disparity = vec![0.0; image.len()];
            to_disparity(&image, factor, &mut disparity).ok()?;
            if filter != "disp" {
                let mut room = vec![[0.0; LANES]; width];
                SpatialDisparity::default().apply(&mut disparity, width, &mut room).ok()?;
            }
            if filter != "dispspatial_default_z" {
                return Some(disparity.iter().flat_map(|d| d.to_le_bytes()).collect());
            }
            to_depth(&disparity, factor, &mut image)
        }
        _ => return None,
    };
    done.ok()?;
    Some(image.iter().flat_map(|z| z.to_le_bytes()).collect())
}
