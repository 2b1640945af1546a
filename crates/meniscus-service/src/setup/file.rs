//! The settings file: TOML, written whole, checked when it is read.

use super::lens::StatedLens;
use crate::setup::measured_glass::MeasuredGlass;
use meniscus::blob::Header;
use meniscus::surface::{Config, ConfigError, Liquid, MAX_COLUMNS, Optics, Settings};
use meniscus_platform::files::{FileError, read_text, write_whole};
use meniscus_usb::camera::OutlineImage;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::path::{Path, PathBuf};

/// Largest difference of a measure from the model's, mm: the accuracy of a calliper and a ruler in a glass.
const FITS_MM: f64 = 1.0;
/// Columns that the glass may move between two frames, as in [`Settings::default`].
const MOVE_PX: f32 = 30.0;

/// Glass, appearance of the liquid and position of the camera.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Setup {
    /// The command that wrote it, in words.
    pub made_by: String,
    /// Inner measures, by hand.
    pub glass: MeasuredGlass,
    /// Appearance, as the camera measured it.
    pub liquid: LiquidAppearance,
    /// The place, by the camera.
    pub view: View,
    /// Lens of a webcam, by hand; none of a camera that tells its own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lens: Option<StatedLens>,
}

/// Appearance of the liquid in the image of the outline.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LiquidAppearance {
    /// Before its background: `dark` or `bright`, or `clear` before a bright card.
    pub tone: Tone,
    /// Least difference from it that the reader takes for liquid, grey levels.
    pub least_contrast: f32,
}

/// [`Liquid`] as the file spells it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Tone {
    /// Darker than the background.
    Dark,
    /// Brighter.
    Bright,
    /// Clear: darker than a bright card behind it, and nothing to the depth image.
    Clear,
}

/// Where the camera stands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct View {
    /// Which camera, in words.
    pub camera: String,
    /// From the camera to the line on which the axis of the glass moves, horizontally, mm.
    pub distance_mm: f64,
    /// Of the camera above the inner bottom of the glass, mm.
    pub height_mm: f64,
    /// Of the camera, degrees, positive when it looks up.
    pub pitch_deg: f64,
    /// The image in which the outline is traced, whose lens this is the place of.
    #[serde(default, skip_serializing_if = "is_infrared")]
    pub outline: OutlineImage,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde gives it so")]
fn is_infrared(outline: &OutlineImage) -> bool {
    *outline == OutlineImage::Infrared
}

impl View {
    /// To a hundredth of its units, which is finer than it is known.
    pub(super) fn round(&mut self) {
        for value in [&mut self.distance_mm, &mut self.height_mm, &mut self.pitch_deg] {
            *value = (100.0 * *value).round() / 100.0;
        }
    }
}

/// A setup is not one that the model was made for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Misfit {
    /// Which measure.
    pub name: &'static str,
    /// The model's, mm.
    pub model_mm: f64,
    /// The setup's, mm.
    pub setup_mm: f64,
}

impl fmt::Display for Misfit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, model_mm, setup_mm } = self;
        write!(
            f,
            "the model was made for a glass with {name} {model_mm:.1} mm, the setup says {setup_mm:.1} mm (1 mm is let \
             pass): take that glass, or make a model of this one (docs/tutorial.md)"
        )
    }
}

impl std::error::Error for Misfit {}

/// Why a settings file cannot be used.
#[derive(Debug)]
pub enum SetupError {
    /// It cannot be read or written.
    File(FileError),
    /// It is no settings file; what is wrong with it.
    Text(PathBuf, String),
    /// It says what cannot be.
    Value(PathBuf, String),
}

impl fmt::Display for SetupError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File(error) => error.fmt(f),
            Self::Text(path, what) => {
                write!(
                    f,
                    "{} is no settings file of `meniscus setup`: {what}; mend that line, or run `meniscus setup` again",
                    path.display()
                )
            }
            Self::Value(path, what) => write!(f, "{}: {what}", path.display()),
        }
    }
}

impl std::error::Error for SetupError {}

/// Returns what is wrong with a text, behind its line.
fn with_line(error: &toml::de::Error, text: &str) -> String {
    let line = error.span().map(|span| 1 + text[..span.start.min(text.len())].matches('\n').count());
    line.map_or_else(|| error.message().into(), |line| format!("line {line}: {}", error.message()))
}

impl Setup {
    /// Reads and checks a settings file.
    ///
    /// # Errors
    /// [`SetupError`] names the file and what is wrong in it.
    pub fn read(path: &Path) -> Result<Self, SetupError> {
        let failed = |cause| SetupError::File(FileError { path: path.into(), doing: "read", cause });
        let text = read_text(path).map_err(failed)?;
        let setup: Self =
            toml::from_str(&text).map_err(|error| SetupError::Text(path.into(), with_line(&error, &text)))?;
        let value = |what| SetupError::Value(path.into(), what);
        setup.glass.check().map_err(value)?;
        setup.lens.map_or(Ok(()), |lens| lens.check()).map_err(|error| value(error.to_string()))?;
        let optics = setup.lens.map_or_else(Optics::default, |lens| lens.optics());
        Config::new(setup.settings(optics)).map_err(|error| value(format!("{error}")))?;
        Ok(setup)
    }

    /// Writes it, with a head that tells people what it is.
    ///
    /// # Errors
    /// [`SetupError::File`].
    pub fn write(&self, path: &Path) -> Result<(), SetupError> {
        let body =
            toml::to_string(self).map_err(|error| SetupError::Text(path.into(), format!("{error}")))?;
        let text = format!(
            "# A glass and the camera before it: for run, record and correct --setup. The glass by hand, the rest by the\n\
             # camera; move either and `meniscus setup` has to look again.\n{body}"
        );
        write_whole(path, text.as_bytes()).map_err(SetupError::File)
    }

    /// The reader's settings for a camera of these optics.
    #[must_use]
    pub fn settings(&self, optics: Optics) -> Settings {
        let m = |mm: f64| (1e-3 * mm) as f32;
        let (radius_m, distance_m) = (m(self.glass.radius_mm), m(self.view.distance_mm));
        let slope = radius_m / (distance_m * distance_m - radius_m * radius_m).max(1e-6).sqrt();
        let half_px = (optics.intrinsics.fx * slope + MOVE_PX).ceil() as usize;
        Settings {
            radius_m,
            fill_m: m(self.glass.fill_mm),
            rim_m: m(self.glass.rim_mm),
            wall_m: self.glass.wall_mm.map(m),
            camera_distance_m: distance_m,
            camera_height_m: m(self.view.height_mm),
            camera_pitch_rad: self.view.pitch_deg.to_radians() as f32,
            region_half_width_px: half_px.min(MAX_COLUMNS / 2),
            liquid: match self.liquid.tone {
                Tone::Dark => Liquid::Dark,
                Tone::Bright => Liquid::Bright,
                Tone::Clear => Liquid::Clear,
            },
            least_contrast: self.liquid.least_contrast,
            ..Settings::default()
        }
        .with_optics(optics)
    }

    /// The same for the glass of a model: where the two differ by less than a person can measure the model's measures
    /// hold, and the camera's height moves with the fill, so that rest is where the model has it.
    ///
    /// # Errors
    /// [`Misfit`], when the setup's glass is another one.
    pub fn settings_for(&self, header: &Header, optics: Optics) -> Result<Settings, Misfit> {
        let model_mm = [header.radius_m, header.fill_m].map(|m| 1e3 * m);
        let own_mm = [self.glass.radius_mm, self.glass.fill_mm];
        for (name, (model_mm, setup_mm)) in
            ["radius", "fill"].into_iter().zip(model_mm.into_iter().zip(own_mm))
        {
            if (model_mm - setup_mm).abs() > FITS_MM {
                return Err(Misfit { name, model_mm, setup_mm });
            }
        }
        let mut fitted = self.clone();
        fitted.glass = MeasuredGlass { radius_mm: model_mm[0], fill_mm: model_mm[1], ..self.glass };
        fitted.view.height_mm += model_mm[1] - own_mm[1];
        fitted.view.distance_mm += model_mm[0] - own_mm[0];
        Ok(fitted.settings(optics))
    }

    /// Whether it can be read with a camera at all.
    pub(super) fn config(&self, optics: Optics) -> Result<Config, ConfigError> {
        Config::new(self.settings(optics))
    }
}
