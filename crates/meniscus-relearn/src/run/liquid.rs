//! First stage of a run: the liquid, stated or identified.

use super::{Run, SimulatedLiquid};
use crate::error::RelearnError;
use crate::identify::{Identified, Law, identify};
use crate::liquid_file::{Sources, liquid_text};
use crate::liquid_source::LiquidSource;
use crate::stage::Stage;
use meniscus::blob::CRC;
use meniscus_data::liquids::Liquid;
use meniscus_platform::files::{FileError, write_whole};

impl Run<'_> {
    /// Writes the liquid file, if it is not there, and returns the result in a sentence.
    pub(super) fn identify(&self) -> Result<String, RelearnError> {
        let path = self.folder.liquid();
        let (liquid, sources, sentence) = match &self.plan.liquid {
            LiquidSource::Stated(name) => {
                let liquid = Liquid::load(name)?;
                let sentence = format!("The liquid is {} as stated", liquid.name);
                (liquid, Sources::one(&format!("as stated in {name}")), sentence)
            }
            source @ LiquidSource::Identified { name, density_kg_m3, law, .. } => {
                let identified = self.fitted(*density_kg_m3, *law)?;
                let sentence = format!("{name}: {}", identified.sentence());
                let (liquid, sources) = identified.liquid(source).ok_or_else(|| RelearnError::Malformed {
                    path: self.folder.identified(),
                    fault: "it is of a stated liquid".into(),
                })?;
                (liquid, sources, sentence)
            }
        };
        // A liquid file that is there may have been edited by a person, who has the last word.
        if !path.exists() {
            write_whole(&path, liquid_text(&liquid, &sources).as_bytes())?;
        }
        Ok(sentence)
    }

    /// The fit of the liquid: that of an earlier run, or a new one.
    fn fitted(&self, density_kg_m3: f64, law: Law) -> Result<Identified, RelearnError> {
        let path = self.folder.identified();
        let malformed = |fault: String| RelearnError::Malformed { path: path.clone(), fault };
        if let Ok(text) = std::fs::read_to_string(&path) {
            return serde_json::from_str(&text).map_err(|error| malformed(error.to_string()));
        }
        let about = format!("fit of the liquid to {} recordings", self.measured.len());
        self.progress.begins(Stage::Identify, &about);
        let identified = identify(self.measured, &self.plan.glass, density_kg_m3, law)?;
        let text = serde_json::to_string_pretty(&identified).map_err(|error| malformed(error.to_string()))?;
        write_whole(&path, text.as_bytes())?;
        self.progress.ends(&identified.sentence());
        Ok(identified)
    }

    /// The liquid in the folder.
    pub(super) fn liquid(&self) -> Result<SimulatedLiquid, RelearnError> {
        let path = self.folder.liquid();
        let text = std::fs::read_to_string(&path).map_err(|cause| FileError {
            path: path.clone(),
            doing: "read",
            cause,
        })?;
        let liquid = Liquid::parse(&path.to_string_lossy(), &text)?;
        let label = match &self.plan.liquid {
            LiquidSource::Stated(name) if Liquid::load(name).is_ok_and(|stated| stated == liquid) => {
                name.clone()
            }
            // Another liquid of the same name must not pass for this one.
            _ => format!("liquid.toml (checksum {:08x})", CRC.checksum(text.as_bytes())),
        };
        Ok(SimulatedLiquid { liquid, label })
    }
}
