//! The path-traced scenes in a folder: images without noise, and the true contact lines.
//!
//! `tests/fixtures/optics/make.py` makes them; its README describes scenes and files.

use image::{ImageError, ImageReader};
use meniscus::surface::{Intrinsics, Liquid, POINTS, Settings};
use meniscus_platform::files::FileError;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Width and height of the whole image, and the columns and rows that are stored.
const SIZE: (usize, usize) = (640, 480);
const COLUMNS: std::ops::Range<usize> = 176..464;
const ROWS: std::ops::Range<usize> = 136..300;
/// Stored steps of a grey level, and stored units of depth in a metre.
const STEPS: f32 = 128.0;
const UNITS: f32 = 1e4;

/// Fault of a set.
#[derive(Debug)]
pub enum SetError {
    /// A file cannot be read.
    File(FileError),
    /// The truth does not have its form.
    Truth(PathBuf, serde_json::Error),
    /// An image cannot be decoded.
    Image(PathBuf, ImageError),
    /// An image has another size: width and height.
    Size(PathBuf, u32, u32),
}

impl std::fmt::Display for SetError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::File(error) => error.fmt(f),
            Self::Truth(path, error) => {
                write!(f, "{}: {error}; make it anew with make.py beside it", path.display())
            }
            Self::Image(path, error) => {
                write!(f, "{}: {error}; delete it and start make.py beside it", path.display())
            }
            Self::Size(path, width, height) => write!(
                f,
                "{} has {width} x {height} pixels instead of {} x {}; delete it and start make.py beside it",
                path.display(),
                COLUMNS.len(),
                ROWS.len()
            ),
        }
    }
}

impl std::error::Error for SetError {}

/// Kind of liquid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// Scatters and hardly absorbs: bright before a dark background.
    Milk,
    /// Absorbs: dark before a bright background.
    Coffee,
    /// Clear.
    Water,
    /// A glass without a liquid.
    Empty,
}

/// Background of a clear glass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Behind {
    /// A bright card.
    #[default]
    Card,
    /// A wall that is neither bright nor dark.
    Plain,
}

/// Light in which a clear glass stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
pub enum Light {
    /// Of 850 nm, which water absorbs.
    #[default]
    #[serde(rename = "850")]
    NearInfrared,
    /// Visible, which it does not.
    #[serde(rename = "visible")]
    Visible,
}

/// Entry of a scene in `truth.json`; lengths in millimetres.
#[derive(Clone, Debug, Deserialize)]
pub struct Truth {
    /// Name of the scene: its set, its liquid and a number.
    pub name: String,
    /// Kind of liquid.
    pub liquid: Kind,
    /// Thickness of the wall.
    pub wall_mm: f64,
    /// Thickness of the base.
    pub base_mm: f64,
    /// Position of the glass axis.
    pub axis_mm: f64,
    /// Seed that the scene was drawn from.
    pub seed: u64,
    /// Height of the liquid at rest.
    #[serde(default = "usual_fill_mm")]
    pub fill_mm: f64,
    /// Distance of the camera from the axis, and its height.
    #[serde(default = "usual_distance_mm")]
    pub distance_mm: f64,
    /// Height of the camera above the inner bottom.
    #[serde(default = "usual_height_mm")]
    pub camera_height_mm: f64,
    /// Background of a clear glass.
    #[serde(default)]
    pub behind: Behind,
    /// Light in which it stands.
    #[serde(default)]
    pub light: Light,
    /// Heights of the contact line at the abscissas of a profile.
    pub contact_line_mm: [f64; POINTS],
}

fn usual_fill_mm() -> f64 {
    70.0
}

fn usual_distance_mm() -> f64 {
    400.0
}

fn usual_height_mm() -> f64 {
    30.0
}

/// A scene: what a lens without noise sees, and the truth.
#[derive(Clone, Debug)]
pub struct TracedScene {
    /// Parameters and contact line.
    pub truth: Truth,
    /// Grey levels of the whole image, not clipped.
    pub grey: Vec<f32>,
    /// Depth of the whole image, metres; zero where there is none.
    pub depth_m: Vec<f32>,
}

/// Returns the folder of the scenes that the repository holds.
#[must_use]
pub fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/fixtures/optics")
}

/// Reads the scenes in `folder` whose name begins with `set`.
///
/// # Errors
/// [`SetError`].
pub fn read(folder: &Path, set: &str) -> Result<Vec<TracedScene>, SetError> {
    let path = folder.join("truth.json");
    let bytes = std::fs::read(&path)
        .map_err(|cause| SetError::File(FileError { path: path.clone(), doing: "read", cause }))?;
    let all: BTreeMap<String, Truth> =
        serde_json::from_slice(&bytes).map_err(|error| SetError::Truth(path, error))?;
    let of_set = all.into_iter().filter(|(name, _)| name.starts_with(set));
    of_set.map(|(name, truth)| scene(folder, &name, truth)).collect()
}

fn scene(folder: &Path, name: &str, truth: Truth) -> Result<TracedScene, SetError> {
    let grey = whole(&folder.join(format!("{name}.png")))?.into_iter().map(|raw| raw / STEPS);
    let depth_m = whole(&folder.join(format!("{name}-depth.png")))?.into_iter().map(|raw| raw / UNITS);
    Ok(TracedScene { truth, grey: grey.collect(), depth_m: depth_m.collect() })
}

/// Reads a stored image and continues its outermost pixels to the size of the camera's.
fn whole(path: &Path) -> Result<Vec<f32>, SetError> {
    let failed = |error| SetError::Image(path.into(), error);
    let opened = ImageReader::open(path)
        .map_err(|cause| SetError::File(FileError { path: path.into(), doing: "read", cause }))?;
    let image = opened.decode().map_err(failed)?.into_luma16();
    let (width, height) = image.dimensions();
    if (width as usize, height as usize) != (COLUMNS.len(), ROWS.len()) {
        return Err(SetError::Size(path.into(), width, height));
    }
    let within =
        |at: usize, range: std::ops::Range<usize>| at.clamp(range.start, range.end - 1) - range.start;
    let pixels = (0..SIZE.1).flat_map(|row| (0..SIZE.0).map(move |column| (column, row)));
    let stored =
        |(column, row)| image.get_pixel(within(column, COLUMNS) as u32, within(row, ROWS) as u32).0[0];
    Ok(pixels.map(stored).map(f32::from).collect())
}

/// Returns the reader's settings for the glass and the camera of a scene; the tone by the kind of liquid.
#[must_use]
pub fn settings(truth: &Truth) -> Settings {
    let intrinsics =
        Intrinsics { width: SIZE.0, height: SIZE.1, fx: 384.0, fy: 384.0, ppx: 319.5, ppy: 239.5 };
    let m = |mm: f64| (1e-3 * mm) as f32;
    let settings = Settings {
        intrinsics,
        camera_distance_m: m(truth.distance_mm),
        camera_height_m: m(truth.camera_height_mm),
        ..Settings::for_glass(0.035, 1e-3 * truth.fill_mm, 0.110)
    };
    match truth.liquid {
        Kind::Milk => Settings { liquid: Liquid::Bright, ..settings },
        Kind::Coffee => Settings { liquid: Liquid::Dark, ..settings },
        Kind::Water | Kind::Empty => settings.of_clear_liquid(),
    }
}
