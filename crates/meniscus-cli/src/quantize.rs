//! `meniscus quantize`: a model in fewer bytes, and the error that this adds.

use super::inputs::file;
use super::kind::check_ending;
use super::outputs::Force;
use anyhow::{Context, ensure};
use indicatif::ProgressBar;
use meniscus::blob::{FieldGroup, Model};
use meniscus::latent::nn::Element;
use meniscus::runtime::{Estimate, Mode};
use meniscus::surface::Settings;
use meniscus_data::blob_file::quantize::{Added, Quantized, added, quantize};
use meniscus_data::recording::{GROUP_NAMES, Recording, STATE};
use meniscus_platform::files::{AlignedBytes, write_whole};
use meniscus_report::checks::{Check, table};
use meniscus_score::baseline::linear_with_motion;
use meniscus_score::score::{Score, score};
use meniscus_service::timed_turn::TimedTurn;
use meniscus_virtual::camera::START;
use meniscus_virtual::observe_recording::{sightings, turns};
use meniscus_virtual::render::SceneSettings;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Largest amount by which the error of the surface, relative to the slosh, may differ: 0.1 percentage point.
const SURFACE: f64 = 0.1;

/// Store a model's weights in fewer bits and measure the added error.
///
/// The GRU, the decoder's trunk and its bases go into bf16 or i8 (the GRU never below bf16). Energy, operators, port, gain and
/// intervals keep their f32 bits, so the laws hold exactly as before.
///
/// With --rank-budget the bases are cut first. Each group keeps the smallest rank whose largest error over the recording stays
/// within that share of the group's range (0.005 is half a per cent).
///
/// Before and after, the model sees the recording through the simulated camera. The table has both errors against the truth, and
/// the difference of both fields over the same latents. A missed target is reported and does not fail the command.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Examples:\n  meniscus quantize --to bf16 --out half.blob\n  meniscus quantize --to i8 --rank-budget 0.005 --out small.blob\n  meniscus run --model small.blob"
)]
pub(crate) struct Arguments {
    /// The model: the one in the program (shipped) or a blob.
    #[arg(long, default_value = "shipped", value_name = "shipped|FILE", help_heading = "Input")]
    model: String,
    /// Recording that the errors are measured on: shipped or a file.
    #[arg(long, default_value = "shipped", value_name = "shipped|FILE", help_heading = "Input")]
    source: String,
    /// Type of the stored weights.
    #[arg(long, value_enum, value_name = "f32|bf16|i8", help_heading = "Method")]
    to: To,
    /// Largest error by cutting the bases, as a share of each group's range, 1e-6 to 0.2.
    #[arg(long, value_name = "SHARE", help_heading = "Method")]
    rank_budget: Option<f64>,
    /// Blob to write, whole or not at all.
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    out: PathBuf,
    #[command(flatten)]
    force: Force,
    /// Print one JSON object.
    #[arg(long, help_heading = "Output")]
    json: bool,
}

/// The elements by name.
#[derive(clap::ValueEnum, Clone, Copy, Debug)]
enum To {
    F32,
    Bf16,
    I8,
}

/// Runs the verb.
pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    if let Some(budget) = arguments.rank_budget {
        ensure!((1e-6..=0.2).contains(&budget), "--rank-budget {budget} is out of range: 0.000001 to 0.2");
    }
    let to = match arguments.to {
        To::F32 => Element::F32,
        To::Bf16 => Element::Bf16,
        To::I8 => Element::I8,
    };
    let bytes = file(&arguments.model)?;
    let model = Model::load(&bytes).with_context(|| format!("the model {} is refused", arguments.model))?;
    let recording = match arguments.source.as_str() {
        "shipped" => Recording::from_bytes(Path::new("the shipped recording"), meniscus_shipped::RECORDING)?,
        path => super::inputs::recording(Path::new(path))?,
    };
    ensure!(
        recording.is_plain() && model.field_len() == STATE,
        "{} and the model are not of the same glass: take an upright cylinder moved along x",
        arguments.source
    );
    check_ending(&arguments.out, "blob")?;
    arguments.force.check(&arguments.out)?;
    let bar = if arguments.json { ProgressBar::hidden() } else { crate::bars::spinner() };
    bar.enable_steady_tick(Duration::from_millis(100));
    bar.set_message("rendering the recording");
    let header = &model.header;
    let camera = Settings::for_glass(header.radius_m, header.fill_m, header.rim_m);
    let seen = sightings(&recording, SceneSettings { camera, ..SceneSettings::default() })?;
    bar.set_message("the model as it is");
    let linear = linear_with_motion(&recording);
    let log = turns(&model, &seen);
    let before = score(&model, &recording, &linear, &log, START);
    let run: Vec<Estimate> = log.iter().map(|logged| logged.turn.estimate).collect();
    let tracked: Vec<Estimate> = run.into_iter().filter(|estimate| estimate.mode == Mode::Tracking).collect();
    bar.set_message("choosing and storing");
    let quantized = quantize(&bytes, to, arguments.rank_budget, &tracked)?;
    bar.set_message("the new model");
    let new = AlignedBytes::copy(&quantized.blob);
    let coarse = Model::load(&new).context("the new blob does not load")?;
    let coarse_log = turns(&coarse, &seen);
    let after = score(&coarse, &recording, &linear, &coarse_log, START);
    let added = added(&model, &coarse, &tracked);
    bar.finish_and_clear();

    let outcome = Outcome { bytes: bytes.len(), quantized, before, after, added, coarse_log };
    // Figures first: a disk that has become full does not take them.
    print(arguments, &outcome, to);
    write_whole(&arguments.out, &outcome.quantized.blob)?;
    if !arguments.json {
        println!("{}: {} bytes, {to}", arguments.out.display(), outcome.quantized.blob.len());
    }
    Ok(())
}

/// Both models on the recording, and the new blob.
struct Outcome {
    /// Length of the old blob.
    bytes: usize,
    quantized: Quantized,
    before: Score,
    after: Score,
    added: [Added; 5],
    /// Turns of the new model.
    coarse_log: Vec<TimedTurn>,
}

/// Figures of the new model beside those of the old one.
fn checks(arguments: &Arguments, outcome: &Outcome) -> Vec<Check> {
    let Outcome { bytes, quantized, before, after, added, coarse_log } = outcome;
    let percent = |score: &Score| 100.0 * score.estimate.slosh_rel();
    let mut checks = vec![
        Check::informational("bytes_before", *bytes as f64, "byte"),
        Check::informational("bytes_after", quantized.blob.len() as f64, "byte"),
        Check::informational("surface_before", percent(before), "%"),
        Check::informational("surface_after", percent(after), "%"),
        Check::at_most("surface_added", percent(after) - percent(before), "%", SURFACE),
        Check::at_most("energy_drift_step", drift(coarse_log), "H", 1e-6),
        Check::exactly("entropy_falls", falls(coarse_log) as f64, "1", 0.0),
    ];
    for (group, name) in known(before) {
        let informational = |what: String, value: f64| Check::informational(what, value, "%");
        checks.push(informational(format!("field_error_{name}_before"), 100.0 * before.field[group]));
        checks.push(informational(format!("field_error_{name}_after"), 100.0 * after.field[group]));
        checks.push(informational(format!("added_rms_{name}"), 100.0 * added[group].rms));
        let most = 100.0 * added[group].most;
        checks.push(match arguments.rank_budget {
            Some(budget) if to_is_f32(arguments.to) => {
                Check::at_most(format!("added_most_{name}"), most, "%", 100.0 * budget * 1.01)
            }
            _ => informational(format!("added_most_{name}"), most),
        });
    }
    checks
}

/// Prints the figures, as JSON or as a table.
fn print(arguments: &Arguments, outcome: &Outcome, to: Element) {
    let checks = checks(arguments, outcome);
    let Outcome { quantized, before, after, added, .. } = outcome;
    if arguments.json {
        let ranks = quantized.ranks.map(|(was, is)| [was, is]);
        let object = serde_json::json!({ "blob": arguments.out, "to": to, "ranks": ranks, "checks": checks });
        println!("{object:#}");
        return;
    }
    println!("group   rank        error against the truth       added, of the group's range");
    for (group, name) in known(before) {
        let (was, is) = quantized.ranks[group];
        println!(
            "{name:6} {was:3} -> {is:3}   {:6.2} -> {:6.2} %             rms {:.4} %, most {:.3} %",
            100.0 * before.field[group],
            100.0 * after.field[group],
            100.0 * added[group].rms,
            100.0 * added[group].most
        );
    }
    print!("{}", table(&checks[..7]));
}

/// Indices and names of the groups that the model knows.
fn known(score: &Score) -> impl Iterator<Item = (usize, &'static str)> {
    let known = score.known;
    let names = GROUP_NAMES.into_iter().enumerate().zip(FieldGroup::ALL);
    names.filter(move |(_, group)| known.contains(*group)).map(|(named, _)| named)
}

/// Whether nothing but the rank changed.
fn to_is_f32(to: To) -> bool {
    matches!(to, To::F32)
}

/// Largest |dE - work| of a step, in units of the energy scale.
fn drift(log: &[TimedTurn]) -> f64 {
    log.iter().map(|logged| logged.turn.estimate.audit.energy_residual.abs()).fold(0.0, f64::max)
}

/// Turns after which there was less heat than before.
fn falls(log: &[TimedTurn]) -> usize {
    let heat = |logged: &TimedTurn| logged.turn.estimate.heat_j;
    log.windows(2).filter(|pair| heat(&pair[1]) < heat(&pair[0])).count()
}
