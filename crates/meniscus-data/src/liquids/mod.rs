//! Liquids: one small TOML file each, every number with its source.
//!
//! Glycerine, water, blood, honey and (but for its density) chocolate carry the numbers of their sources.
//! The other five carry typical values of general literature, as their files say: they are the right kind of liquid, not a certain bottle of it.
//!
//! The files of the known liquids are compiled in; any other file may be given by its path.

mod rheology;

pub use rheology::{Rheology, SHEAR_RATE_SCALE};

use crate::effects::{EffectError, Effects};
use meniscus_platform::files::read_text;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The files compiled in, by the name that the command line uses.
const KNOWN: [(&str, &str); 10] = [
    ("glycerine", include_str!("../../liquids/glycerine.toml")),
    ("water", include_str!("../../liquids/water.toml")),
    ("blood", include_str!("../../liquids/blood.toml")),
    ("butter", include_str!("../../liquids/butter.toml")),
    ("honey", include_str!("../../liquids/honey.toml")),
    ("beer", include_str!("../../liquids/beer.toml")),
    ("gazpacho", include_str!("../../liquids/gazpacho.toml")),
    ("chocolate", include_str!("../../liquids/chocolate.toml")),
    ("mayonnaise", include_str!("../../liquids/mayonnaise.toml")),
    ("ketchup", include_str!("../../liquids/ketchup.toml")),
];

/// A liquid at 20 degrees Celsius unless its file says otherwise.
#[derive(Clone, Debug, PartialEq)]
pub struct Liquid {
    /// Name as in its file.
    pub name: String,
    /// Density, kg/m3.
    pub density_kg_m3: f64,
    /// Rheology: stress as a function of the shear rate.
    pub rheology: Rheology,
    /// Effects that belong to the liquid; those of a setup go before them.
    pub effects: Effects,
}

/// Why a liquid could not be had.
#[derive(Debug)]
pub enum LiquidError {
    /// Neither a known name nor a file.
    Unknown(String),
    /// The file could not be read.
    Io(PathBuf, std::io::Error),
    /// The text is not a liquid.
    Malformed(String, String),
    /// An effect in the file is unknown, out of range or not simulated.
    Effect(String, EffectError),
    /// A number is out of its range.
    Range {
        /// The liquid.
        name: String,
        /// The field of the file.
        field: &'static str,
        /// Value in the file.
        value: f64,
        /// Allowed range, in words.
        allowed: &'static str,
    },
}

impl std::fmt::Display for LiquidError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Unknown(name) => {
                let known: Vec<_> = known().collect();
                write!(
                    f,
                    "no liquid is called '{name}': take one of {}, or the path of a liquid file",
                    known.join(", ")
                )
            }
            Self::Io(path, error) => write!(f, "{}: {error}", path.display()),
            Self::Malformed(name, why) => write!(f, "{name} is not a liquid file: {why}"),
            Self::Effect(name, error) => write!(f, "{name}: {error}"),
            Self::Range { name, field, value, allowed } => {
                write!(f, "{name}: {field} = {value} is out of range: it must be {allowed}")
            }
        }
    }
}

impl std::error::Error for LiquidError {}

/// A number and where it comes from.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Sourced {
    value: f64,
    #[serde(rename = "source")]
    _source: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LiquidFile {
    name: String,
    density_kg_m3: Sourced,
    viscosity_pa_s: Option<Sourced>,
    consistency_pa_sn: Option<Sourced>,
    index: Option<Sourced>,
    yield_stress_pa: Option<Sourced>,
    largest_viscosity_pa_s: Option<Sourced>,
    #[serde(default)]
    effects: BTreeMap<String, Sourced>,
}

/// Names of the liquids compiled in.
pub fn known() -> impl Iterator<Item = &'static str> {
    KNOWN.iter().map(|(name, _)| *name)
}

impl Liquid {
    /// A known liquid by name, or the liquid in the file of that path.
    ///
    /// # Errors
    /// When there is no such liquid, or its file is wrong.
    pub fn load(name_or_path: &str) -> Result<Self, LiquidError> {
        if let Some((_, text)) = KNOWN.iter().find(|(name, _)| *name == name_or_path) {
            return Self::parse(name_or_path, text);
        }
        let path = Path::new(name_or_path);
        if path.extension().is_none() && !path.exists() {
            return Err(LiquidError::Unknown(name_or_path.into()));
        }
        let text = read_text(path).map_err(|e| LiquidError::Io(path.into(), e))?;
        Self::parse(name_or_path, &text)
    }

    /// The liquid that `text` describes; `origin` names it in errors.
    ///
    /// # Errors
    /// When the text is not a liquid, or a number is out of range.
    pub fn parse(origin: &str, text: &str) -> Result<Self, LiquidError> {
        let file: LiquidFile =
            toml::from_str(text).map_err(|e| LiquidError::Malformed(origin.into(), format!("{e}")))?;
        let malformed = |why: &str| LiquidError::Malformed(origin.into(), why.into());
        let value = |number: Option<Sourced>, otherwise: f64| number.map_or(otherwise, |n| n.value);
        let rheology = match (file.viscosity_pa_s, file.consistency_pa_sn) {
            (Some(mu), None) => {
                if file.index.is_some() || file.yield_stress_pa.is_some() {
                    return Err(malformed(
                        "index and yield_stress_pa go with consistency_pa_sn, not viscosity_pa_s",
                    ));
                }
                Rheology::newtonian(mu.value)
            }
            (None, Some(k)) => Rheology {
                consistency: k.value,
                index: value(file.index, 1.0),
                yield_stress: value(file.yield_stress_pa, 0.0),
                largest: value(file.largest_viscosity_pa_s, rheology::LARGEST),
            },
            _ => return Err(malformed("it needs either viscosity_pa_s or consistency_pa_sn")),
        };
        let ranges = [
            ("density_kg_m3", file.density_kg_m3.value, 100.0..=20_000.0, "between 100 and 20000"),
            ("viscosity", rheology.consistency, 0.0..=100.0, "between 0 and 100"),
            ("index", rheology.index, 0.1..=2.0, "between 0.1 and 2"),
            ("yield_stress_pa", rheology.yield_stress, 0.0..=1000.0, "between 0 and 1000"),
            ("largest_viscosity_pa_s", rheology.largest, 1e-4..=1000.0, "between 0.0001 and 1000"),
        ];
        for (field, value, range, allowed) in ranges {
            if !range.contains(&value) {
                return Err(LiquidError::Range { name: file.name, field, value, allowed });
            }
        }
        let mut effects = Effects::default();
        for (name, number) in file.effects {
            effects.set(&name, number.value).map_err(|e| LiquidError::Effect(file.name.clone(), e))?;
        }
        effects.require_simulated().map_err(|e| LiquidError::Effect(file.name.clone(), e))?;
        Ok(Self { name: file.name, density_kg_m3: file.density_kg_m3.value, rheology, effects })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus::reduced::effects::EffectKind;

    #[test]
    fn every_known_liquid_loads() {
        for name in known() {
            assert_eq!(Liquid::load(name).expect("a known liquid").name, name);
        }
        let glycerine = Liquid::load("glycerine").expect("glycerine is known");
        assert_eq!((glycerine.density_kg_m3, glycerine.rheology.viscosity(3.0)), (1261.0, 0.950));
    }

    #[test]
    fn wrong_files_are_refused_with_the_reason() {
        let good = include_str!("../../liquids/glycerine.toml");
        let refusal = |text: &str| format!("{}", Liquid::parse("x", text).expect_err("must be refused"));
        assert!(refusal(&good.replace("0.950", "-0.950")).contains("viscosity = -0.95"));
        assert!(refusal(&good.replace("0.950", "nan")).contains("NaN"));
        assert!(refusal(&format!("{good}\ncolour = 3\n")).contains("colour"));
        let effect = "[effects]\nsurface_tension = { value = 0.063, source = \"x\" }\n";
        let liquid = Liquid::parse("x", &format!("{good}\n{effect}")).expect("effects belong to a liquid");
        assert_eq!(liquid.effects.value(EffectKind::SurfaceTension), Some(0.063));
        assert!(
            refusal(&format!("{good}\n{}", effect.replace("0.063", "-1"))).contains("surface_tension = -1")
        );
        assert!(
            refusal(&format!("{good}\n{}", effect.replace("_tension", ""))).contains("no effect is called")
        );
        let camera = refusal(&format!("{good}\n{}", effect.replace("surface_tension", "camera_pitch")));
        assert!(camera.contains("camera_pitch is not simulated"), "{camera}");
        // A liquid file of before the one list of effects: the reach beside its line.
        let line = effect.replace("surface_tension", "contact_line");
        let reach = "contact_line_reach = { value = 0.001, source = \"x\" }\n";
        let liquid = Liquid::parse("x", &format!("{good}\n{line}{reach}")).expect("a liquid");
        assert_eq!(liquid.effects.values(EffectKind::ContactLine), [Some(0.063), Some(0.001)]);
        let unknown = format!("{}", Liquid::load("treacle").expect_err("is not known"));
        assert!(unknown.contains("glycerine, water"), "{unknown}");
    }
}
