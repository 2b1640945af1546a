//! `meniscus insert`: insert effects into a flashed model.

use super::inputs::file;
use super::kind::check_ending;
use super::outputs::Force;
use anyhow::{Context, anyhow, bail, ensure};
use meniscus::blob::Model;
use meniscus::reduced::effects::{Active, Effect, Stated, find};
use meniscus_data::effects::Effects;
use meniscus_data::liquids::Liquid;
use meniscus_data::validity::Validity;
use meniscus_discover::findings::gap::left_m;
use meniscus_discover::insert::latent::roll_out;
use meniscus_discover::insert::{Inserted, TrainedLiquid, insert, resistance};
use meniscus_discover::recordings::load::load;
use meniscus_platform::files::{AlignedBytes, read_text, write_whole};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Insert effects into a model: differences from the trained liquid.
///
/// The weights stay as they are. The blob gets a list of effects with their values. Whoever loads it derives the changes of
/// energy, friction and relaxation in the step, whose laws stay exact for any value, and the corrections of the camera's
/// profile. Old effects are replaced; without any they are removed.
///
/// The decoder stays that of the liquid without effects. With an effect of the liquid the model no longer knows internal energy
/// and stresses, with slip or a film nor velocity: every output leaves them out.
///
/// --effect NAME=VALUE takes the names, SI values and units of `meniscus simulate` and scene files: `viscosity=0.8` is 0.8 Pa s,
/// `fill=0.072` a height of 72 mm. `meniscus simulate --list` shows them all. The first parameter is enough. Latency, delay,
/// detuning and swirl cannot be inserted, and the command says why.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Examples:\n  meniscus insert --effect yield_stress=3 --out yields.blob\n  meniscus insert --verdict found/verdict.json --out better.blob\n  meniscus insert --effect viscosity=0.8 --effect camera_slope=0.03 \\\n    --recordings mine --out new.blob --json"
)]
pub(crate) struct Arguments {
    /// The model: the one in the program (shipped) or a blob.
    #[arg(long, default_value = "shipped", value_name = "shipped|FILE", help_heading = "Input")]
    model: String,
    /// Effect with the values of its parameters, SI units; may be repeated.
    #[arg(long, value_name = "NAME=VALUE[,VALUE]", help_heading = "Input")]
    effect: Vec<String>,
    /// Verdict of `meniscus discover` to take the effects from.
    #[arg(long, value_name = "FILE", conflicts_with = "effect", help_heading = "Input")]
    verdict: Option<PathBuf>,
    /// Liquid of the model's training, by name or file [default: the blob's].
    #[arg(long, value_name = "NAME|FILE", help_heading = "Input")]
    liquid: Option<String>,
    /// Folder of recordings, as for `meniscus discover`, to roll out before and after.
    ///
    /// Every recording is rolled out from rest with its motion known.
    #[arg(long, value_name = "DIR", help_heading = "Input")]
    recordings: Option<PathBuf>,
    /// Blob to write, whole or not at all.
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    out: PathBuf,
    #[command(flatten)]
    force: Force,
    /// Print one JSON object.
    #[arg(long, help_heading = "Output")]
    json: bool,
}

/// Runs the verb.
pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    check_ending(&arguments.out, "blob")?;
    arguments.force.check(&arguments.out)?;
    let bytes = file(&arguments.model)?;
    let model = Model::load(&bytes).with_context(|| format!("the model {} is refused", arguments.model))?;
    let name = arguments.liquid.as_deref().unwrap_or(&model.header.liquid);
    let liquid = Liquid::load(name).with_context(|| {
        format!("the model was trained on '{}': say with --liquid which that is", model.header.liquid)
    })?;
    let rheology = resistance(&liquid.rheology);
    let (radius_m, fill_m) = (model.header.radius_m, model.header.fill_m);
    let stated = Stated { consistency_pa_sn: rheology.consistency, radius_m, fill_m };
    let effects = match &arguments.verdict {
        Some(path) => of_verdict(path, &stated)?,
        None => spelled(&arguments.effect)?
            .active(&stated)
            .with_context(|| format!("a model of {name}, filled to {} m", stated.fill_m))?,
    };
    let trained = TrainedLiquid { density_kg_m3: liquid.density_kg_m3, rheology };
    ensure!(
        !effects.is_empty() || model.header.embedded.is_some(),
        "no effect is given, and {} has none to remove: give --effect NAME=VALUE or --verdict FILE",
        arguments.model
    );
    let Inserted { blob, mapped } = insert(&bytes, trained, &effects)?;
    let aligned = AlignedBytes::copy(&blob);
    let new = Model::load(&aligned).context("the new blob does not load")?;
    let tried = arguments.recordings.as_deref().map(|path| tried(path, &model, &new)).transpose()?;
    write_whole(&arguments.out, &blob)?;
    let validity = Validity::of(&new.header);
    report(arguments, &effects, &stated, mapped.explained, &tried.unwrap_or_default(), &validity);
    Ok(())
}

/// One recording, rolled out by both models.
struct Tried {
    name: String,
    before_mm: f64,
    after_mm: f64,
}

/// Prints what was written.
fn report(
    arguments: &Arguments,
    effects: &[Active],
    stated: &Stated,
    explained: [f64; 2],
    rows: &[Tried],
    validity: &Validity,
) {
    if arguments.json {
        let row = |row: &Tried| json!({ "recording": row.name, "before_mm": row.before_mm, "after_mm": row.after_mm });
        let one = |active: &Active| {
            let values = active.stated_values(stated).into_iter().flatten();
            let values: Vec<f64> = values.map(nine_digits).collect();
            json!({ "effect": active.entry.name, "values": values })
        };
        let object = json!({
            "effects": effects.iter().map(one).collect::<Vec<Value>>(), "explained": explained,
            "recordings": rows.iter().map(row).collect::<Vec<_>>(), "written": arguments.out,
            "known": validity.names(),
        });
        println!("{object}");
        return;
    }
    println!(
        "the latents explain {:.2} % of the first mode's height and {:.2} % of its rate",
        100.0 * explained[0],
        100.0 * explained[1]
    );
    for active in effects {
        let values = active.entry.parameters.iter().zip(active.stated_values(stated).into_iter().flatten());
        for (parameter, value) in values {
            let unit = if parameter.unit == "1" { "" } else { parameter.unit };
            let line = format!("{} = {} {unit}", parameter.spelling, nine_digits(value));
            println!("  {}", line.trim_end());
        }
    }
    for Tried { name, before_mm, after_mm } in rows {
        println!("  {name}: {before_mm:.3} mm before, {after_mm:.3} mm after");
    }
    println!("written: {} with {} effect(s)", arguments.out.display(), effects.len());
    validity.sentence.iter().for_each(|sentence| println!("{sentence}"));
}

/// `value` to nine digits: a viscosity is stored as a factor, and what comes back of 0.25 Pa s differs in the seventeenth.
fn nine_digits(value: f64) -> f64 {
    format!("{value:.8e}").parse().unwrap_or(value)
}

/// The effects that `texts` spell.
fn spelled(texts: &[String]) -> anyhow::Result<Effects> {
    let mut effects = Effects::default();
    for text in texts {
        effects.parse(text).with_context(|| format!("--effect {text}"))?;
    }
    Ok(effects)
}

/// The effects of a verdict.json, at their fitted values, counted from `stated`.
fn of_verdict(path: &Path, stated: &Stated) -> anyhow::Result<Vec<Active>> {
    let text = read_text(path).with_context(|| {
        format!(
            "cannot read {}, which should be the verdict.json of `meniscus discover --out`",
            path.display()
        )
    })?;
    let json: Value = serde_json::from_str(&text).with_context(|| {
        format!("{} is not the verdict.json of `meniscus discover --out`", path.display())
    })?;
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
        let (place, coordinate) = coordinate(entry, which, value, stated)
            .with_context(|| format!("{}: {effect} has no parameter '{which}'", path.display()))?;
        if !out.iter().any(|active| active.entry.kind == entry.kind) {
            out.push(Active { entry, values: entry.neutral() });
        }
        if let Some(active) = out.iter_mut().find(|active| active.entry.kind == entry.kind) {
            active.values[place] = coordinate;
        }
    }
    Ok(out)
}

/// Returns the place and coordinate of the parameter `which` of `effect` at `value`. Verdicts of before the one list of
/// effects name the coordinate itself: the factor of a viscosity, the excess of a fill.
fn coordinate(effect: &Effect, which: &str, value: f64, stated: &Stated) -> Option<(usize, f64)> {
    effect.parameters.iter().enumerate().find_map(|(place, parameter)| {
        if parameter.name == which {
            Some((place, parameter.to_coordinate(value, stated)))
        } else {
            (parameter.coordinate_name() == which).then_some((place, value))
        }
    })
}

/// Returns the errors of every recording in the folder at `path`, before and after.
fn tried(path: &Path, before: &Model<'_>, after: &Model<'_>) -> anyhow::Result<Vec<Tried>> {
    let folder = load(path)?;
    folder.left_out.iter().for_each(|why| eprintln!("left out: {why}"));
    let mut rows = Vec::new();
    for record in &folder.records {
        let left = |model| -> anyhow::Result<f64> {
            let expected = roll_out(model, record, 0.0).map_err(|why| anyhow!(why))?;
            Ok(1e3 * left_m(record, &expected))
        };
        rows.push(Tried { name: record.name.clone(), before_mm: left(before)?, after_mm: left(after)? });
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    const STATED: Stated = Stated { consistency_pa_sn: 0.95, radius_m: 0.035, fill_m: 0.07 };

    fn read(parameters: &str) -> anyhow::Result<Vec<Active>> {
        let path = std::env::temp_dir().join(format!("meniscus-verdict-{}.json", std::process::id()));
        std::fs::write(&path, format!("{{\"verdict\":\"named\",\"parameters\":[{parameters}]}}"))?;
        let read = of_verdict(&path, &STATED);
        std::fs::remove_file(&path)?;
        read
    }

    /// An old verdict names the coordinate, a new one the SI value; both are the same effect.
    #[test]
    fn old_verdicts_keep_their_meaning() -> anyhow::Result<()> {
        let one = |effect: &str, parameter: &str, value: f64| -> anyhow::Result<f64> {
            let text = json!({ "effect": effect, "parameter": parameter, "value": value }).to_string();
            Ok(read(&text)?[0].values[0])
        };
        let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
        assert!(
            near(one("viscosity", "factor", 0.8)?, 0.8) && near(one("viscosity", "consistency", 0.76)?, 0.8)
        );
        assert!(near(one("fill", "excess", 0.002)?, 0.002) && near(one("fill", "height", 0.072)?, 0.002));
        assert!(near(one("yield_stress", "stress", 3.0)?, 3.0));
        let unknown = one("yield_stress", "factor", 3.0).expect_err("it has no factor");
        assert!(format!("{unknown:#}").contains("yield_stress has no parameter 'factor'"), "{unknown:#}");
        Ok(())
    }
}
