//! First stage of a run: the liquid, stated or identified.

use super::{Run, SimulatedLiquid};
use crate::error::RelearnError;
use crate::identify::{Identified, Law, Simulating, by_simulation, identify, stated};
use crate::liquid_file::{Sources, liquid_text};
use crate::liquid_source::LiquidSource;
use crate::simulate::Shard;
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
        let by = if self.plan.rough { "the reduced model" } else { "the simulator, some minutes" };
        let about = format!("fit of the liquid to {} recordings, by {by}", self.measured.len());
        self.progress.begins(Stage::Identify, &about);
        let rough = identify(self.measured, &self.plan.glass, density_kg_m3, law)?;
        let identified = if self.plan.rough { rough } else { self.simulated(&rough, density_kg_m3)? };
        let text = serde_json::to_string_pretty(&identified).map_err(|error| malformed(error.to_string()))?;
        write_whole(&path, text.as_bytes())?;
        self.progress.ends(&identified.sentence());
        Ok(identified)
    }

    /// The fit of the simulator, from where the reduced model stands.
    fn simulated(&self, rough: &Identified, density_kg_m3: f64) -> Result<Identified, RelearnError> {
        if self.workers.shard != Shard::WHOLE {
            // The simulations of a fit follow from one another; those of the next stage do not.
            return Err(RelearnError::NotIdentified);
        }
        let store = self.folder.identification();
        let how = Simulating {
            spacing_m: self.plan.spacing_m,
            store: &store,
            stop: self.stop,
            progress: self.progress,
        };
        let known = stated(&self.plan.glass, density_kg_m3);
        let fit = || by_simulation(rough, self.measured, &known, &how);
        match rayon::ThreadPoolBuilder::new().num_threads(self.workers.processors).build() {
            Ok(pool) => pool.install(fit),
            Err(_) => fit(),
        }
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
