//! Liquid of the recordings of a correction: what the camera saw of it, and whether it is the model's own.
//!
//! A correction to the model's own liquid leaves every field group known, one to another liquid the surface and the positions.
//! Recordings of the simulator are of the model's liquid if name, density and effects are those of the source recordings. A
//! camera's recordings do not tell their liquid: without `--liquid` they are of another one.

use super::Arguments;
use crate::filmed::{all_filmed, by_camera};
use crate::glass;
use crate::inputs::{level, recordings};
use anyhow::{Context, ensure};
use meniscus::blob::Header;
use meniscus_data::liquids::Liquid;
use meniscus_data::recording::{Provenance, Recording};
use meniscus_learn::correct::Sightings;
use meniscus_virtual::observe_recording::sightings;
use meniscus_virtual::render::SceneSettings;
use std::path::PathBuf;

/// Largest relative difference of two densities of one liquid.
const SAME_DENSITY: f64 = 0.01;

/// Returns the profiles that the simulated camera sees of `all`, with seeds from `first` on.
pub(super) fn looks(arguments: &Arguments, all: &[Recording], first: u64) -> anyhow::Result<Vec<Sightings>> {
    let seen = |(k, recording): (u64, &Recording)| {
        let scene = SceneSettings {
            disparity_rms_px: arguments.noise_px,
            seed: arguments.seed + first + k,
            ..SceneSettings::of(&recording.glass)
        };
        Ok(sightings(recording, scene)?)
    };
    (0..).zip(all).map(seen).collect()
}

/// New liquid: its name, whether the model was trained on it, and its profiles by recording.
pub(super) struct NewLiquid {
    pub(super) name: String,
    pub(super) same_as_model: bool,
    pub(super) seen: Vec<Sightings>,
}

/// Reads the recordings of the new liquid, those of a camera or those of the simulator, for a model of `header` with recordings
/// `source` of its own liquid.
pub(super) fn new_liquid(
    arguments: &Arguments,
    header: &Header,
    source: &[Recording],
) -> anyhow::Result<NewLiquid> {
    if all_filmed(&arguments.recordings)? {
        return filmed(arguments, header, source);
    }
    ensure!(arguments.setup.is_none(), "--setup is for a camera's recordings, and these are the simulator's");
    ensure!(
        arguments.liquid.is_none(),
        "--liquid is for a camera's recordings, and these of the simulator name their liquid: leave it out"
    );
    let new = recordings(&arguments.recordings, "", level)?;
    let name = new.first().map_or(String::new(), |recording| recording.provenance.liquid.clone());
    let own = |recording: &Recording| is_own(&recording.provenance, header, source);
    Ok(NewLiquid { name, same_as_model: new.iter().all(own), seen: looks(arguments, &new, 0)? })
}

/// Reads a camera's recordings.
fn filmed(arguments: &Arguments, header: &Header, source: &[Recording]) -> anyhow::Result<NewLiquid> {
    // A standard position of the camera would make a worse model without a word.
    ensure!(
        arguments.setup.is_some(),
        "a camera's recordings need --setup FILE.toml, which has the position of the camera: `meniscus setup` writes it"
    );
    let stated = arguments.liquid.as_deref().map(Liquid::load).transpose().context("--liquid")?;
    // Without --liquid nobody says which liquid stood before the camera: the file's name does.
    let stem = arguments.recordings.first().and_then(|path| path.file_stem()).unwrap_or_default();
    let name = stated.as_ref().map_or(stem.to_string_lossy().into_owned(), |liquid| liquid.name.clone());
    let same_as_model = stated.is_some_and(|liquid| is_stated(&liquid, header, source));
    let setup = arguments.setup.as_deref();
    let outline = glass::outline(setup)?;
    let look =
        |path: &PathBuf| by_camera(path, outline, |camera| glass::settings(setup, header, camera.optics()));
    let seen = arguments.recordings.iter().map(look).collect::<anyhow::Result<Vec<_>>>()?;
    Ok(NewLiquid { name, same_as_model, seen })
}

/// Whether a recording of the simulator shows the model's own liquid.
fn is_own(new: &Provenance, header: &Header, source: &[Recording]) -> bool {
    let alike = |own: &Recording| {
        let own = &own.provenance;
        own.liquid == new.liquid
            && same_density(own.density_kg_m3, new.density_kg_m3)
            && own.effects == new.effects
    };
    new.liquid == header.liquid.as_str() && source.iter().all(alike)
}

/// Whether the liquid that the user states is the model's own: by name, density and rheology.
fn is_stated(new: &Liquid, header: &Header, source: &[Recording]) -> bool {
    let own = Liquid::load(&header.liquid);
    let rheology = own.is_ok_and(|own| own.rheology == new.rheology && own.effects == new.effects);
    let density = |own: &Recording| same_density(own.provenance.density_kg_m3, new.density_kg_m3);
    new.name == header.liquid.as_str() && rheology && source.iter().all(density)
}

fn same_density(a: f64, b: f64) -> bool {
    (a / b - 1.0).abs() <= SAME_DENSITY
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus::blob::Model;
    use meniscus_platform::files::AlignedBytes;
    use std::path::Path;

    #[test]
    fn glycerine_is_the_models_own_and_water_heavier_or_slipping_glycerine_is_not() -> anyhow::Result<()> {
        let bytes = AlignedBytes::copy(meniscus_shipped::MODEL);
        let header = Model::load(&bytes)?.header;
        let own = Recording::from_bytes(Path::new("shipped"), meniscus_shipped::RECORDING)?;
        let source = std::slice::from_ref(&own);
        let same = own.provenance.clone();
        assert!(is_own(&same, &header, source));
        let water = Provenance { liquid: "water".into(), ..same.clone() };
        let heavier = Provenance { density_kg_m3: 1.05 * same.density_kg_m3, ..same.clone() };
        let slipping = Provenance { effects: vec![("wall_slip".into(), 1e-3)], ..same };
        for other in [water, heavier, slipping] {
            assert!(!is_own(&other, &header, source), "{other:?}");
        }
        assert!(is_stated(&Liquid::load("glycerine")?, &header, source));
        assert!(!is_stated(&Liquid::load("water")?, &header, source));
        Ok(())
    }
}
