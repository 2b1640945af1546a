//! Scene files: a glass, a liquid, its effects and a motion in one TOML file.
//!
//! ```toml
//! liquid = "honey"                       # a known name, or the path of a liquid file
//! motion = "strokes:7"                   # KIND:SEED, or the path of a CSV file
//! spacing_mm = 5.0
//! step_us = 400.0                        # only to go slower than the simulator would
//!
//! [glass]                                # inner sizes, m; taper = dr/dz
//! radius_m = 0.035
//! fill_m = 0.070
//! rim_m = 0.110
//! taper = 0.05
//! # or, in place of radius and taper, heights and radii from the bottom to the rim; a first radius of 0 is a round bottom:
//! # profile_m = [[0, 0], [0.005, 0.018], [0.015, 0.029], [0.03, 0.036], [0.05, 0.038], [0.08, 0.034], [0.1, 0.03]]
//!
//! [effects]                              # SI values, as `meniscus simulate --list` has them
//! surface_tension = 0.055
//! wall_slip = { value = 0.001, source = "a guess" }
//! contact_line = 0.02
//! contact_line_reach = 0.0005            # a second parameter
//! ```
//! Everything may lack; paths are those of the folder where the command runs.

use crate::effects::{EffectError, Effects};
use crate::glass::{Glass, Profile, WallShape};
use meniscus_platform::files::read_text;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The glass of the recordings where a scene says nothing of it.
pub const GLASS: Glass = Glass { radius_m: 0.035, fill_m: 0.070, rim_m: 0.110, wall: WallShape::UPRIGHT };

/// Content of a scene file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Experiment {
    /// The glass.
    pub glass: Option<Glass>,
    /// The liquid, by name or path.
    pub liquid: Option<String>,
    /// The motion, as the command line spells it.
    pub motion: Option<String>,
    /// Spacing of the particles, mm.
    pub spacing_mm: Option<f64>,
    /// Step of the simulator, s.
    pub step_s: Option<f64>,
    /// Effects that are on.
    pub effects: Effects,
}

/// Why a scene was refused.
#[derive(Debug)]
pub enum ExperimentError {
    /// The file could not be read.
    Io(PathBuf, std::io::Error),
    /// The text is not a scene.
    Malformed(PathBuf, String),
    /// An effect is unknown, out of range or not simulated.
    Effect(PathBuf, EffectError),
}

impl std::fmt::Display for ExperimentError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Io(path, error) => write!(f, "{}: {error}", path.display()),
            Self::Malformed(path, why) => write!(f, "{} is not a scene: {why}", path.display()),
            Self::Effect(path, error) => write!(f, "{}: {error}", path.display()),
        }
    }
}

impl std::error::Error for ExperimentError {}

/// A number, with or without its source.
#[derive(Deserialize)]
#[serde(untagged)]
enum Number {
    Plain(f64),
    Sourced {
        value: f64,
        #[serde(rename = "source")]
        _source: String,
    },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    glass: Option<GlassTable>,
    liquid: Option<String>,
    motion: Option<String>,
    spacing_mm: Option<f64>,
    step_us: Option<f64>,
    #[serde(default)]
    effects: BTreeMap<String, Number>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct GlassTable {
    radius_m: Option<f64>,
    fill_m: Option<f64>,
    rim_m: Option<f64>,
    taper: Option<f64>,
    profile_m: Option<Vec<[f64; 2]>>,
}

impl GlassTable {
    /// The glass that the table describes.
    fn glass(self) -> Result<Glass, String> {
        let fill_m = self.fill_m.unwrap_or(GLASS.fill_m);
        let Some(points) = self.profile_m else {
            return Ok(Glass {
                radius_m: self.radius_m.unwrap_or(GLASS.radius_m),
                fill_m,
                rim_m: self.rim_m.unwrap_or(GLASS.rim_m),
                wall: WallShape::Straight { taper: self.taper.unwrap_or(0.0) },
            });
        };
        if self.radius_m.is_some() || self.taper.is_some() {
            return Err("its glass has a profile_m beside a radius_m or a taper: leave those out".into());
        }
        let profile = Profile::new(&points).map_err(|e| format!("its glass: {e}"))?;
        Ok(Glass::curved(profile, fill_m, self.rim_m.unwrap_or(profile.top_m())))
    }
}

impl Experiment {
    /// The scene in the file at `path`.
    ///
    /// # Errors
    /// When it cannot be read, is not a scene, or names an effect that is unknown, out of range or not simulated. Whether
    /// glass, liquid and motion can be simulated is for those to say.
    pub fn load(path: &Path) -> Result<Self, ExperimentError> {
        let text = read_text(path).map_err(|e| ExperimentError::Io(path.into(), e))?;
        Self::parse(path, &text)
    }

    /// The scene that `text` describes; `origin` names it in errors.
    ///
    /// # Errors
    /// As for [`Self::load`].
    pub fn parse(origin: &Path, text: &str) -> Result<Self, ExperimentError> {
        let file: File =
            toml::from_str(text).map_err(|e| ExperimentError::Malformed(origin.into(), format!("{e}")))?;
        let mut effects = Effects::default();
        for (name, number) in file.effects {
            let (Number::Plain(value) | Number::Sourced { value, .. }) = number;
            effects.set(&name, value).map_err(|e| ExperimentError::Effect(origin.into(), e))?;
        }
        effects.require_simulated().map_err(|e| ExperimentError::Effect(origin.into(), e))?;
        let glass = file.glass.map(GlassTable::glass).transpose();
        let glass = glass.map_err(|why| ExperimentError::Malformed(origin.into(), why))?;
        Ok(Self {
            glass,
            liquid: file.liquid,
            motion: file.motion,
            spacing_mm: file.spacing_mm,
            step_s: file.step_us.map(|us| 1e-6 * us),
            effects,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus::reduced::effects::EffectKind;

    #[test]
    fn a_scene_is_read_and_nonsense_refused() {
        let parse = |text: &str| Experiment::parse(Path::new("s.toml"), text);
        let text = "liquid = 'honey'\n[glass]\ntaper = 0.05\n[effects]\nfoam = 0.1\nwall_slip = { value = inf, source = 'x' }";
        let scene = parse(text).expect("a scene");
        assert_eq!(scene.glass, Some(Glass { wall: WallShape::Straight { taper: 0.05 }, ..GLASS }));
        let bowl = parse("[glass]\nfill_m = 0.03\nprofile_m = [[0, 0], [0.02, 0.03], [0.06, 0.04]]")
            .expect("a bowl");
        let bowl = bowl.glass.expect("a glass");
        assert_eq!((bowl.radius_at(0.06), bowl.fill_m, bowl.rim_m), (0.04, 0.03, 0.06));
        let value = |kind| scene.effects.value(kind);
        assert_eq!((value(EffectKind::Foam), value(EffectKind::WallSlip)), (Some(0.1), Some(f64::INFINITY)));
        let refusal = |text: &str| format!("{}", parse(text).expect_err(text));
        assert!(refusal("colour = 3").contains("s.toml is not a scene"));
        assert!(refusal("[effects]\nviscosity = -1").contains("s.toml: effect viscosity = -1"));
        assert!(refusal("[effects]\nghosts = 1").contains("no effect is called 'ghosts'"));
        let both = "[glass]\ntaper = 0.1\nprofile_m = [[0, 0], [0.02, 0.03], [0.06, 0.04]]";
        assert!(refusal(both).contains("leave those out"));
        assert!(refusal("[glass]\nprofile_m = [[0, 0.1]]").contains("it needs 3 to 32"));
        let camera = refusal("[effects]\ncamera_pitch = 0.03");
        assert!(camera.contains("s.toml: effect camera_pitch is not simulated"), "{camera}");
    }

    /// Scene files of before the one list of effects: the same names, units and meaning.
    #[test]
    fn an_old_scene_file_keeps_its_meaning() {
        let text = "[effects]\nviscosity = 0.6\nfill = 0.05\ncontact_line = 0.3\ncontact_line_reach = 0.02\n\
                    viscoelastic = 10.0\nviscoelastic_time = 0.05\nyield_stress = 500.0";
        let scene = Experiment::parse(Path::new("s.toml"), text).expect("a scene");
        let on: Vec<_> =
            scene.effects.on().into_iter().map(|(p, value)| (p.spelling, value, p.unit)).collect();
        assert_eq!(
            on,
            [
                ("viscosity", 0.6, "Pa s^n"),
                ("yield_stress", 500.0, "Pa"),
                ("contact_line", 0.3, "N/m"),
                ("contact_line_reach", 0.02, "m"),
                ("viscoelastic", 10.0, "Pa"),
                ("viscoelastic_time", 0.05, "s"),
                ("fill", 0.05, "m"),
            ]
        );
    }
}
