//! Liquid, glass and measured recordings of a run, from what the command line names.

use super::Arguments;
use crate::inputs::{plain, recordings};
use crate::kind::Kind;
use anyhow::{Context, bail, ensure};
use meniscus_data::liquids::{Liquid, known};
use meniscus_data::recording::Glass;
use meniscus_data::scene_file::{Experiment, GLASS};
use meniscus_discover::recordings::load::load;
use meniscus_relearn::LiquidSource;
use meniscus_relearn::identify::{Law, MeasuredRecording};
use std::path::{Path, PathBuf};

/// Largest relative difference of two sizes of one glass.
const SAME_SIZE: f64 = 0.01;

/// Inputs of a run.
pub(super) struct Inputs {
    /// Liquid as stated, or to be identified.
    pub(super) liquid: LiquidSource,
    /// Glass.
    pub(super) glass: Glass,
    /// Measured recordings, by name.
    pub(super) measured: Vec<MeasuredRecording>,
}

/// Statements of the recordings themselves.
#[derive(Default)]
struct Found {
    glass: Option<Glass>,
    density_kg_m3: Option<f64>,
    name: Option<String>,
    measured: Vec<MeasuredRecording>,
}

/// Reads what `arguments` name.
pub(super) fn read(arguments: &Arguments) -> anyhow::Result<Inputs> {
    // Before the recordings are read, which takes a while.
    arguments.density.map_or(Ok(()), check_density)?;
    let scene = arguments.scene.as_deref().map(Experiment::load).transpose()?;
    let scene_glass = scene.and_then(|scene| scene.glass);
    let rim_m = scene_glass.map(|glass| glass.rim_m);
    let mut liquid: Option<String> = None;
    let mut found = Found::default();
    for input in &arguments.inputs {
        if is_liquid(input) {
            Liquid::load(input)?;
            ensure!(
                liquid.is_none(),
                "two liquids are named, {} and {input}: give one",
                liquid.unwrap_or_default()
            );
            liquid = Some(input.clone());
        } else {
            measured(Path::new(input), rim_m, arguments.seed, &mut found)?;
        }
    }
    let Found { glass, density_kg_m3, name, measured } = found;
    if let (Some(scene), Some(own)) = (scene_glass, glass) {
        same_glass(&scene, &own).context("--scene has another glass than the recordings")?;
    }
    let glass = scene_glass.or(glass).unwrap_or(GLASS);
    ensure!(
        glass.is_cylinder(),
        "a model is learned in a glass with upright sides, and those of this one are conical or round"
    );
    let liquid = if measured.is_empty() {
        let Some(name) = liquid else { bail!("name a liquid, or recordings of one") };
        ensure!(arguments.density.is_none(), "--density goes with recordings; a liquid file has the density");
        ensure!(
            Law::from(arguments.law) == Law::Newtonian,
            "--law goes with recordings; a liquid file has the law"
        );
        LiquidSource::Stated(name)
    } else {
        let stated = liquid.as_deref().map(Liquid::load).transpose()?;
        let own = stated.as_ref().map(|liquid| liquid.density_kg_m3);
        let Some(density_kg_m3) = arguments.density.or(own).or(density_kg_m3) else {
            bail!("the density of the liquid is not known: give --density KG_M3, or name the liquid")
        };
        check_density(density_kg_m3)?;
        let name = stated.as_ref().map(|liquid| liquid.name.clone()).or(name).unwrap_or("learned".into());
        let newtonian = stated.filter(|liquid| liquid.rheology.is_newtonian());
        LiquidSource::Identified {
            name,
            density_kg_m3,
            stated_viscosity_pa_s: newtonian.map(|liquid| liquid.rheology.consistency),
            law: arguments.law.into(),
        }
    };
    Ok(Inputs { liquid, glass, measured })
}

/// Refuses a density that no liquid has.
fn check_density(density_kg_m3: f64) -> anyhow::Result<()> {
    ensure!(
        (100.0..=20_000.0).contains(&density_kg_m3),
        "--density {density_kg_m3} is out of range: 100 to 20000 kg/m3"
    );
    Ok(())
}

/// Whether `input` names a liquid rather than recordings.
fn is_liquid(input: &str) -> bool {
    let path = Path::new(input);
    let file = path.extension().is_some_and(|extension| extension == "toml");
    known().any(|name| name == input) || file || !path.exists()
}

/// Adds the recordings at `path`: a folder of profiles, or recordings of the simulator.
fn measured(path: &Path, rim_m: Option<f64>, seed: u64, found: &mut Found) -> anyhow::Result<()> {
    if path.join("setup.toml").exists() {
        let set = load(path)?;
        for reason in &set.left_out {
            eprintln!("left out: {reason}");
        }
        let glass =
            MeasuredRecording::glass(&set.known, rim_m.unwrap_or(GLASS.rim_m.max(set.known.fill_m + 0.04)));
        join(found, glass, set.known.density_kg_m3, None)?;
        found.measured.extend(MeasuredRecording::of_set(path, &set)?);
        return Ok(());
    }
    if let Some(Kind::Camera) = Kind::of(path) {
        bail!(
            "{} is a camera's recording: `meniscus record` writes its profiles, and a folder with setup.toml, NAME.profile.csv \
             and NAME.motion.csv can be learned from",
            path.display()
        );
    }
    let files = if path.is_dir() { listed(path)? } else { vec![path.to_owned()] };
    for file in files {
        let stem = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        for recording in recordings(std::slice::from_ref(&file), "", plain)? {
            let provenance = &recording.provenance;
            join(found, recording.glass, provenance.density_kg_m3, Some(provenance.liquid.clone()))?;
            let draw = seed + found.measured.len() as u64;
            found.measured.push(MeasuredRecording::seen(&stem, &recording, draw)?);
        }
    }
    Ok(())
}

/// Recordings of the simulator in `folder`, by name.
fn listed(folder: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let entries = folder.read_dir().with_context(|| format!("{} cannot be listed", folder.display()))?;
    let mut files: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    files.retain(|file| file.extension().is_some_and(|extension| extension == "safetensors"));
    files.sort();
    ensure!(
        !files.is_empty(),
        "{} holds no recordings: *.safetensors of the simulator, or setup.toml with NAME.profile.csv and NAME.motion.csv",
        folder.display()
    );
    Ok(files)
}

/// Joins what one more recording states to what those before it do.
fn join(found: &mut Found, glass: Glass, density_kg_m3: f64, name: Option<String>) -> anyhow::Result<()> {
    if let Some(before) = &found.glass {
        same_glass(before, &glass).context("the recordings are of different glasses")?;
    }
    if let (Some(before), Some(now)) = (&found.name, &name) {
        ensure!(before == now, "the recordings are of two liquids, {before} and {now}: learn one at a time");
    }
    found.glass.get_or_insert(glass);
    found.density_kg_m3.get_or_insert(density_kg_m3);
    found.name = found.name.take().or(name);
    Ok(())
}

/// Refuses two glasses that differ.
fn same_glass(a: &Glass, b: &Glass) -> anyhow::Result<()> {
    for (what, a, b) in [("radius", a.radius_m, b.radius_m), ("fill", a.fill_m, b.fill_m)] {
        ensure!(
            (a / b - 1.0).abs() <= SAME_SIZE,
            "{what} of {:.2} mm and of {:.2} mm: give recordings of one glass",
            1e3 * a,
            1e3 * b
        );
    }
    Ok(())
}
