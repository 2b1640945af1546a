//! Liquid of the recordings of a correction, read from what the flags name.
//!
//! A camera's recordings do not tell their liquid: without `--liquid` they are of another one than the model's.

use super::Arguments;
use crate::filmed::{all_filmed, by_camera};
use crate::glass;
use crate::inputs::{level, recordings};
use anyhow::{Context, ensure};
use meniscus::blob::Header;
use meniscus_data::liquids::Liquid;
use meniscus_data::recording::Recording;
use meniscus_learn::correct::Sightings;
use meniscus_learn::correct::liquid::{is_own, is_same_density, looks};
use std::path::PathBuf;

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
    Ok(NewLiquid {
        name,
        same_as_model: new.iter().all(own),
        seen: looks(&new, arguments.noise_px, arguments.seed)?,
    })
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

/// Whether the liquid that the user states is the model's own: by name, density and rheology.
fn is_stated(new: &Liquid, header: &Header, source: &[Recording]) -> bool {
    let own = Liquid::load(&header.liquid);
    let rheology = own.is_ok_and(|own| own.rheology == new.rheology && own.effects == new.effects);
    let density = |own: &Recording| is_same_density(own.provenance.density_kg_m3, new.density_kg_m3);
    new.name == header.liquid.as_str() && rheology && source.iter().all(density)
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus::blob::Model;
    use meniscus_data::recording::Provenance;
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
