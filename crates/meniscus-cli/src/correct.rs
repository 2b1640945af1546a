//! `meniscus correct`: a model learns another liquid from recordings of its free surface.

mod new_liquid;

use super::inputs::{file, level, recordings};
use super::kind::check_ending;
use super::outputs::Force;
use super::stop::{finish, watched_until};
use anyhow::{Context, ensure};
use meniscus::blob::{Header, Model};
use meniscus_data::recording::Recording;
use meniscus_data::validity::Validity;
use meniscus_learn::correct::liquid::{SOURCE_SEED, corrected_name, looks};
use meniscus_learn::correct::{Correction, CorrectionParameters, correct};
use meniscus_platform::files::{AlignedBytes, write_whole};
use meniscus_report::checks::{Check, table};
use new_liquid::{NewLiquid, new_liquid};
use std::path::{Path, PathBuf};

/// Correct a model for another liquid from recordings of its surface.
///
/// The last GRU layer, the operators and the energy of the GENERIC step and a gain between the two learn by Adam; decoder and
/// lower layers stay. Energy and entropy keep their laws.
///
/// The free surface teaches the surface and the positions. A model that was corrected to another liquid does not know velocity,
/// internal energy and stresses: every output leaves them out. `meniscus train` makes a model that knows them.
///
/// The last recording is held out (of a single one its last three tenths). The candidate with the least error of the forecast
/// 0.25 s ahead on it is kept. A candidate whose error on the model's own liquid grows by more than --forgetting is refused. If
/// no candidate improves the forecast, no blob is written and the exit status is 1. Ctrl-C writes none either.
///
/// Effects that `meniscus insert` put into the model stay in it with their values, and the weights learn what they leave.
///
/// Recordings of the simulator are seen through the simulated camera. A camera's recordings (.mcap, .bag, .db3, or a folder with
/// frames.csv) need --setup, which has the position of the camera. One correction takes one kind.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Examples:\n  meniscus correct --recordings one.mcap two.mcap \\\n    --setup glass.toml --out mine.blob\n  meniscus simulate --liquid water --motion strokes:1x0.25 \\\n    --motion strokes:2x0.25 --seconds 4 --out water\n  meniscus correct --recordings water --out water.blob"
)]
pub(crate) struct Arguments {
    /// Recordings of the new liquid: files, or a folder for all of its *.safetensors.
    #[arg(long, required = true, num_args = 1.., value_name = "DIR_OR_FILES", help_heading = "Recordings")]
    recordings: Vec<PathBuf>,
    /// Glass and camera position, as `meniscus setup` wrote them, for a camera's recordings.
    #[arg(long, value_name = "FILE.toml", help_heading = "Recordings")]
    setup: Option<PathBuf>,
    /// Liquid in a camera's recordings, by name or file [default: one that the model does not know].
    ///
    /// Recordings of the simulator name theirs.
    #[arg(long, value_name = "NAME|FILE", help_heading = "Recordings")]
    liquid: Option<String>,
    /// Recordings of the model's own liquid, against forgetting [default: the one in the program].
    #[arg(long, num_args = 1.., value_name = "DIR_OR_FILES", help_heading = "Recordings")]
    source: Vec<PathBuf>,
    /// Noise of the simulated camera's disparity, pixels rms, 0 to 5.
    ///
    /// 0.08 is a D435, 0.24 makes 2 mm of depth at 0.4 m.
    #[arg(long, default_value_t = 0.08, value_name = "PX", help_heading = "Recordings")]
    noise_px: f64,
    /// Model to correct: the one in the program (shipped) or a blob.
    #[arg(long, default_value = "shipped", value_name = "shipped|FILE", help_heading = "Method")]
    model: String,
    /// Steps of Adam, 1 to 100000.
    #[arg(long, default_value_t = 300, help_heading = "Method")]
    steps: usize,
    /// Largest growth of the slosh-relative error on the model's own liquid (0.05 = 5 points).
    #[arg(long, default_value_t = 0.05, value_name = "SHARE", help_heading = "Method")]
    forgetting: f64,
    /// Seed of all random draws.
    #[arg(long, default_value_t = 1, help_heading = "Method")]
    seed: u64,
    /// Corrected blob to write, whole or not at all.
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    out: PathBuf,
    #[command(flatten)]
    force: Force,
    /// Print one JSON object.
    #[arg(long, help_heading = "Output")]
    json: bool,
}

/// Refuses arguments that are out of range.
fn within_range(arguments: &Arguments) -> anyhow::Result<()> {
    ensure!(
        (0.0..=10.0).contains(&arguments.forgetting),
        "--forgetting {} is out of range: 0 to 10",
        arguments.forgetting
    );
    ensure!(
        (1..=100_000).contains(&arguments.steps),
        "--steps {} is out of range: 1 to 100000",
        arguments.steps
    );
    ensure!(
        (0.0..=5.0).contains(&arguments.noise_px),
        "--noise-px {} is out of range: 0 to 5",
        arguments.noise_px
    );
    Ok(())
}

/// Names of the effects that a model of `header` carries.
fn names_of_effects(header: &Header) -> Vec<&str> {
    let effects = header.embedded.iter().flat_map(|embedded| &embedded.effects);
    effects.map(|effect| effect.name.as_str()).collect()
}

/// Runs the verb.
pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    within_range(arguments)?;
    check_ending(&arguments.out, "blob")?;
    arguments.force.check(&arguments.out)?;
    let stop = watched_until("nothing is learnt: no blob is written")?;
    let bytes = file(&arguments.model)?;
    let model = Model::load(&bytes).with_context(|| format!("the model {} is refused", arguments.model))?;
    let source = if arguments.source.is_empty() {
        vec![Recording::from_bytes(Path::new("the shipped recording"), meniscus_shipped::RECORDING)?]
    } else {
        recordings(&arguments.source, "", level)?
    };
    let NewLiquid { name, same_as_model, seen } = new_liquid(arguments, &model.header, &source)?;
    let parameters = CorrectionParameters {
        steps: arguments.steps,
        forgetting: arguments.forgetting,
        ..CorrectionParameters::default()
    };
    let how = Correction {
        seed: arguments.seed,
        parameters,
        liquid: corrected_name(&name, &model.header, same_as_model),
        same_liquid: same_as_model,
        command: format!("meniscus correct --steps {} --seed {}", arguments.steps, arguments.seed),
        quiet: arguments.json,
    };
    let source_seen = looks(&source, arguments.noise_px, arguments.seed + SOURCE_SEED)?;
    let corrected = correct(&bytes, &seen, &source_seen, &how, stop)?;
    finish();
    let percent = |x: f64| 100.0 * x;
    let [held, source] = [corrected.held, corrected.source].map(|pair| pair.map(percent));
    let checks = [
        Check::informational("held_before_forecast", held[0], "%"),
        Check::at_most("held_after_forecast", held[1], "%", held[0]),
        Check::informational("source_before_slosh", source[0], "%"),
        Check::at_most("source_after_slosh", source[1], "%", source[0] + percent(arguments.forgetting)),
        Check::informational("refused_for_forgetting", corrected.refused as f64, "1"),
    ];
    let improved = corrected.held[1] < corrected.held[0];
    let new = AlignedBytes::copy(&corrected.blob);
    let validity = Validity::of(&Model::load(&new).context("the corrected model is refused")?.header);
    let effects = names_of_effects(&model.header);
    if arguments.json {
        println!(
            "{:#}",
            serde_json::json!({
                "blob": improved.then_some(&arguments.out),
                "known": improved.then(|| validity.names()),
                "effects": effects,
                "checks": checks,
                "looks": corrected.looks,
                "parameters": how.parameters,
            })
        );
    } else {
        print!("{}", table(&checks));
    }
    ensure!(
        held[0].is_finite(),
        "nothing was learnt, and no blob is written: the surface of the held-out recording was seen in too few frames to judge a \
         forecast; look at it with `meniscus run --source`, or take a smaller --noise-px than {}",
        arguments.noise_px
    );
    ensure!(
        improved,
        "nothing was learnt: no candidate forecasts the held-out recording better than {:.1} %, so no blob is written; \
         record more, and livelier, motions{}",
        held[0],
        if corrected.refused > 0 { ", or allow a larger --forgetting" } else { "" }
    );
    write_whole(&arguments.out, &corrected.blob)?;
    if !arguments.json {
        println!("{}: {} bytes", arguments.out.display(), corrected.blob.len());
        if !effects.is_empty() {
            println!("It keeps its effects with their values: {}.", effects.join(", "));
        }
        validity.sentence.iter().for_each(|sentence| println!("{sentence}"));
    }
    Ok(())
}
