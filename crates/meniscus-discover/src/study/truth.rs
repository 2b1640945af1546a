//! Glasses of liquid whose truth is known: simulated particles with an effect switched on, kept on disk.
//!
//! A file of the cache is named after a digest of what made it, so that nothing about the effect can be
//! read from it, and a study that is run again simulates only what is missing.

use crate::sizing::store::SIMULATOR_VERSION;
use crate::study::motions::{MotionKind, motions};
use crc::{CRC_64_ECMA_182, Crc};
use meniscus::blob::{FieldGroup, KnownGroups};
use meniscus_data::effects::Effects;
use meniscus_data::glass::Glass;
use meniscus_data::liquids::{Liquid, Rheology};
use meniscus_data::motion::Motion;
use meniscus_data::recording::{Recording, States};
use meniscus_data::scene_file::GLASS;
use meniscus_platform::files::write_whole;
use meniscus_sph::{Setup, record_surfaces};
use safetensors::tensor::{Dtype, SafeTensors, TensorView};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Density of every liquid of the study, kg/m3.
pub const DENSITY_KG_M3: f64 = 1261.0;

/// Spacing of the particles, m: the one at which the simulator's wall laws are validated.
const SPACING_M: f64 = 0.005;

/// One glass of liquid.
#[derive(Clone, Debug, PartialEq)]
pub struct Truth {
    /// Viscosity, Pa s.
    pub viscosity_pa_s: f64,
    /// Seed of the packing.
    pub packing: u64,
    /// Effects that the simulator has switched on.
    pub effects: Effects,
    /// Motions that it makes.
    pub kind: MotionKind,
}

impl Truth {
    /// Returns the digest that names the files of this glass.
    #[must_use]
    pub fn digest(&self) -> String {
        let Glass { radius_m, fill_m, rim_m, .. } = GLASS;
        // In the words of the first version, so that trials keep their names.
        let glass =
            format!("Glass {{ radius_m: {radius_m:?}, fill_m: {fill_m:?}, rim_m: {rim_m:?}, taper: 0.0 }}");
        let text =
            format!("simulator {SIMULATOR_VERSION} {SPACING_M} {glass} {self:?} {:?}", motions(self.kind));
        format!("{:016x}", Crc::<u64>::new(&CRC_64_ECMA_182).checksum(text.as_bytes()))
    }

    fn path(&self, cache: &Path, motion: usize) -> PathBuf {
        cache.join(format!("{}-{motion}.safetensors", self.digest()))
    }

    /// Returns whether every motion of it is in the cache.
    #[must_use]
    pub fn is_there(&self, cache: &Path) -> bool {
        (0..motions(self.kind).len()).all(|motion| self.path(cache, motion).exists())
    }

    /// Simulates what is not in the cache.
    ///
    /// # Errors
    /// In words, when the simulator stops or a file cannot be written.
    pub fn make(&self, cache: &Path) -> Result<(), String> {
        if self.is_there(cache) {
            return Ok(());
        }
        let liquid = Liquid {
            name: "study".into(),
            density_kg_m3: DENSITY_KG_M3,
            rheology: Rheology::newtonian(self.viscosity_pa_s),
            effects: Effects::default(),
        };
        let setup = Setup {
            glass: GLASS,
            liquid,
            spacing_m: SPACING_M,
            seed: self.packing,
            no_slip: true,
            effects: self.effects,
            step_s: None,
        };
        let mut wanted = Vec::new();
        for (number, plan) in motions(self.kind).iter().enumerate() {
            let path = cache.join(format!("motion-{:?}-{number}.csv", self.kind).to_lowercase());
            // Several glasses are taken through the same motion at once.
            let mine = path.with_extension(format!("{}.csv", self.digest()));
            write_whole(&mine, plan.csv().as_bytes()).map_err(|error| format!("{error}"))?;
            let motion =
                Motion::parse(&mine.to_string_lossy(), plan.seconds).map_err(|error| format!("{error}"))?;
            std::fs::rename(&mine, &path).map_err(|error| format!("{}: {error}", path.display()))?;
            wanted.push((motion, plan.frames(), String::from("meniscus discover study")));
        }
        let recordings = record_surfaces(&setup, &wanted)
            .map_err(|error| format!("{:?} could not be simulated: {error}", self.effects))?;
        for (number, recording) in recordings.iter().enumerate() {
            write_whole(&self.path(cache, number), &bytes(recording)?).map_err(|error| format!("{error}"))?;
        }
        Ok(())
    }

    /// Returns the recording of a motion, surface only, from the cache.
    ///
    /// # Errors
    /// In words, when the file is not there or not whole.
    pub fn recording(&self, cache: &Path, motion: usize) -> Result<Recording, String> {
        let path = self.path(cache, motion);
        let bytes = std::fs::read(&path).map_err(|error| format!("{}: {error}", path.display()))?;
        read(&bytes).map_err(|why| format!("{}: {why}; remove it and run again", path.display()))
    }
}

/// Names of the surface's tensors.
const TENSORS: [&str; 3] = ["column_m", "wall_m", "profile_m"];

fn bytes(recording: &Recording) -> Result<Vec<u8>, String> {
    let floats = [&recording.column_m, &recording.wall_m, &recording.profile_m];
    let mut raw: Vec<(&str, Dtype, Vec<u8>)> = TENSORS
        .iter()
        .zip(floats)
        .map(|(name, values)| (*name, Dtype::F32, values.iter().flat_map(|v| v.to_le_bytes()).collect()))
        .collect();
    let x = recording.glass_x_m.iter().flat_map(|v| v.to_le_bytes()).collect();
    raw.push(("glass_x_m", Dtype::F64, x));
    let views: Result<Vec<_>, _> = raw
        .iter()
        .map(|(name, dtype, bytes)| {
            let size = if *dtype == Dtype::F32 { 4 } else { 8 };
            TensorView::new(*dtype, vec![bytes.len() / size], bytes).map(|view| (*name, view))
        })
        .collect();
    let views = views.map_err(|error| format!("{error}"))?;
    let glass = serde_json::to_string(&recording.glass).map_err(|error| format!("{error}"))?;
    let provenance = serde_json::to_string(&recording.provenance).map_err(|error| format!("{error}"))?;
    let notes = HashMap::from([("glass".into(), glass), ("provenance".into(), provenance)]);
    safetensors::serialize(views, Some(notes)).map_err(|error| format!("{error}"))
}

fn read(bytes: &[u8]) -> Result<Recording, String> {
    let wrong = |error: &dyn std::fmt::Display| format!("{error}");
    let (_, header) = SafeTensors::read_metadata(bytes).map_err(|e| wrong(&e))?;
    let notes = header.metadata().as_ref().ok_or("no metadata")?;
    let note = |name: &str| notes.get(name).ok_or_else(|| format!("no {name} in its metadata"));
    let tensors = SafeTensors::deserialize(bytes).map_err(|e| wrong(&e))?;
    let data = |name: &str| tensors.tensor(name).map(|t| t.data().to_vec()).map_err(|e| wrong(&e));
    let floats = |name: &str| -> Result<Vec<f32>, String> {
        Ok(data(name)?.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect())
    };
    let glass_x_m: Vec<f64> =
        data("glass_x_m")?.as_chunks::<8>().0.iter().map(|b| f64::from_le_bytes(*b)).collect();
    let frames = glass_x_m.len();
    Ok(Recording {
        glass: serde_json::from_str(note("glass")?).map_err(|e| wrong(&e))?,
        provenance: serde_json::from_str(note("provenance")?).map_err(|e| wrong(&e))?,
        glass_x_m,
        acceleration_m_s2: vec![0.0; frames],
        glass_y_m: vec![0.0; frames],
        glass_z_m: vec![0.0; frames],
        tilt_rad: vec![0.0; frames],
        column_m: floats("column_m")?,
        wall_m: floats("wall_m")?,
        profile_m: floats("profile_m")?,
        energy: Vec::new(),
        spilled_m3: vec![0.0; frames],
        states: States::Full(Vec::new()),
        known: KnownGroups::NONE.with(FieldGroup::Surface),
    })
}
