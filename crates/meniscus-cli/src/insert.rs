//! `meniscus adopt`: put named effects into a flashed model.

use super::inputs::file;
use anyhow::{Context, anyhow, bail, ensure};
use meniscus::blob::Model;
use meniscus::reduced::effects::{Active, find};
use meniscus_data::liquids::Liquid;
use meniscus_discover::gap::left_m;
use meniscus_discover::insert::latent::roll_out;
use meniscus_discover::insert::{Adopted, adopt, resistance};
use meniscus_discover::load::load;
use meniscus_platform::files::{AlignedBytes, write_whole};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Put named effects into a flashed model: what the liquid in the glass has that the one it was trained on has not.
///
/// The weights stay as they are. The blob gets a list of effects with their values, and whoever loads it works out what
/// they do: to the energy, the friction and the memory of the step, whose laws stay exact for any value, and to what
/// the camera sees. Effects that a model had are replaced; with none given they are taken out.
///
/// Effects and their parameters are those of `meniscus discover`; the first parameter is enough. Latency, delay,
/// detuning and swirl have no place in a flashed model, and the command says why.
///
/// With --recordings, a folder as `meniscus discover` reads it, every recording is rolled out from rest with its motion
/// known, before and after.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Examples:\n  meniscus adopt --effect yield_stress=3 --out yields.blob\n  meniscus adopt --model mine.blob --verdict found/verdict.json --out better.blob\n  meniscus adopt --effect viscosity=0.8 --effect camera_slope=0.03 --recordings mine --out new.blob --json"
)]
pub(crate) struct Arguments {
    /// The model: the one in the program (shipped) or a blob file.
    #[arg(long, default_value = "shipped", value_name = "shipped|FILE")]
    model: String,
    /// An effect with the values of its parameters; give it several times for several effects.
    #[arg(long, value_name = "NAME=VALUE[,VALUE]")]
    effect: Vec<String>,
    /// Take effects and values from what a discovery wrote.
    #[arg(long, value_name = "FILE", conflicts_with = "effect")]
    verdict: Option<PathBuf>,
    /// The liquid that the model was trained on, by name or file; the one that its header names, unless given.
    #[arg(long)]
    liquid: Option<String>,
    /// Recordings to roll out before and after.
    #[arg(long, value_name = "DIR")]
    recordings: Option<PathBuf>,
    /// Where the new blob goes; it is written whole or not at all.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// One JSON object on standard output.
    #[arg(long)]
    json: bool,
}

/// Runs the verb.
pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let effects = match &arguments.verdict {
        Some(path) => of_verdict(path)?,
        None => arguments.effect.iter().map(|text| spelled(text)).collect::<anyhow::Result<_>>()?,
    };
    let bytes = file(&arguments.model)?;
    let model = Model::load(&bytes).with_context(|| format!("the model {} is refused", arguments.model))?;
    let name = arguments.liquid.as_deref().unwrap_or(&model.header.liquid);
    let liquid = Liquid::load(name).with_context(|| {
        format!("the model was trained on '{}': say with --liquid which that is", model.header.liquid)
    })?;
    let Adopted { blob, mapped } =
        adopt(&bytes, (liquid.density_kg_m3, resistance(&liquid.rheology)), &effects)?;
    let aligned = AlignedBytes::copy(&blob);
    let new = Model::load(&aligned).context("the new blob does not load")?;
    let tried = arguments.recordings.as_deref().map(|path| tried(path, &model, &new)).transpose()?;
    write_whole(&arguments.out, &blob)?;
    let rows = tried.unwrap_or_default();
    if arguments.json {
        let row = |(name, before, after): &(String, f64, f64)| json!({ "recording": name, "before_mm": before, "after_mm": after });
        let list: Vec<Value> =
            effects.iter().map(|e| json!({ "effect": e.entry.name, "values": e.values })).collect();
        let object = json!({
            "effects": list, "explained": mapped.explained, "recordings": rows.iter().map(row).collect::<Vec<_>>(),
            "written": arguments.out,
        });
        println!("{object}");
        return Ok(());
    }
    println!(
        "the latents explain {:.2} % of the first mode's height and {:.2} % of its rate",
        100.0 * mapped.explained[0],
        100.0 * mapped.explained[1]
    );
    for (name, before, after) in rows {
        println!("  {name}: {before:.3} mm before, {after:.3} mm after");
    }
    println!("written: {} with {} effect(s)", arguments.out.display(), effects.len());
    Ok(())
}

/// The effect that `text` spells.
fn spelled(text: &str) -> anyhow::Result<Active> {
    let (name, values) =
        text.split_once('=').ok_or_else(|| anyhow!("--effect {text}: it is spelled NAME=VALUE"))?;
    let numbers: Result<Vec<f64>, _> = values.split(',').map(|v| v.trim().parse()).collect();
    active(name.trim(), &numbers.with_context(|| format!("--effect {text}: '{values}' is no number"))?)
}

/// The effect `name` with its first values; the others are typical.
fn active(name: &str, given: &[f64]) -> anyhow::Result<Active> {
    let entry =
        find(name).ok_or_else(|| anyhow!("no effect is called '{name}'; `meniscus discover` names them"))?;
    let parameters = entry.parameters;
    ensure!(
        (1..=parameters.len()).contains(&given.len()),
        "{name} has {} parameter(s) and not {}",
        parameters.len(),
        given.len()
    );
    let mut values = entry.neutral();
    for (i, (slot, parameter)) in values.iter_mut().zip(parameters).enumerate() {
        let Some(&value) = given.get(i) else { continue };
        let (least, largest) = parameter.range;
        ensure!(
            least <= value && value <= largest,
            "{name}: {} = {value} {} is out of range: {least} to {largest}",
            parameter.name,
            parameter.unit
        );
        *slot = value;
    }
    Ok(Active { entry, values })
}

/// The effects of a verdict.json, at their fitted values.
fn of_verdict(path: &Path) -> anyhow::Result<Vec<Active>> {
    let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    let json: Value =
        serde_json::from_str(&text).with_context(|| format!("{} is not JSON", path.display()))?;
    let (Some(verdict), Some(parameters)) = (json["verdict"].as_str(), json["parameters"].as_array()) else {
        bail!("{} is not the verdict of a discovery", path.display());
    };
    ensure!(
        verdict == "named",
        "{} says '{verdict}': only effects that are named go into a model; --effect takes one all the same",
        path.display()
    );
    let mut out: Vec<Active> = Vec::new();
    for parameter in parameters {
        let (Some(effect), Some(which), Some(value)) =
            (parameter["effect"].as_str(), parameter["parameter"].as_str(), parameter["value"].as_f64())
        else {
            bail!("{}: a parameter without effect, parameter or value", path.display());
        };
        let entry =
            find(effect).ok_or_else(|| anyhow!("{}: no effect is called '{effect}'", path.display()))?;
        let place = entry.parameters.iter().position(|p| p.name == which);
        let place =
            place.ok_or_else(|| anyhow!("{}: {effect} has no parameter '{which}'", path.display()))?;
        if !out.iter().any(|active| active.entry.name == effect) {
            out.push(Active { entry, values: entry.neutral() });
        }
        if let Some(active) = out.iter_mut().find(|active| active.entry.name == effect) {
            active.values[place] = value;
        }
    }
    Ok(out)
}

/// Name, error before and after, mm, of every recording in the folder at `path`.
fn tried(path: &Path, before: &Model<'_>, after: &Model<'_>) -> anyhow::Result<Vec<(String, f64, f64)>> {
    let folder = load(path)?;
    folder.left_out.iter().for_each(|why| eprintln!("left out: {why}"));
    let mut rows = Vec::new();
    for record in &folder.records {
        let left = |model| -> anyhow::Result<f64> {
            let expected = roll_out(model, record, 0.0).map_err(|why| anyhow!(why))?;
            Ok(1e3 * left_m(record, &expected))
        };
        rows.push((record.name.clone(), left(before)?, left(after)?));
    }
    Ok(rows)
}
