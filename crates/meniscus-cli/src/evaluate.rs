//! `meniscus evaluate`: a model on liquids that it does not know, before and after correction.

use super::inputs::file;
use super::outputs::check_folder;
use super::stop::{finish, watched_until};
use anyhow::ensure;
use indicatif::ProgressBar;
use meniscus_learn::evaluate::{COURSES, Watch, checks, curves_png, peaks_png, report, study};
use meniscus_platform::files::write_whole;
use meniscus_relearn::learned_rows;
use meniscus_report::checks::table;
use std::path::PathBuf;

/// Evaluate a model on other liquids, before and after correction.
///
/// For each liquid the model sees a recording through the simulated camera (depth noise 2 mm), is corrected by other recordings'
/// surfaces, and sees the first one again. Water, butter and blood are moved along a line and learnt from four recordings of 4 s.
/// Beer, honey, gazpacho and water once more (water_by_hand) are moved as by a hand, a tenth of the travel out of line, and
/// learnt from one.
///
/// With --learned the finished folders of `meniscus learn` are put side by side, and nothing is computed.
///
/// Missing recordings are simulated into --recordings, about 25 s each on two processors, and stay there. The --out folder gets
/// evaluate.html, evaluate.md, curves.png, peaks.png and each corrected blob. A missed target is reported and does not fail the
/// command. Ctrl-C writes no report.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Examples:\n  meniscus evaluate --liquid beer\n  meniscus evaluate --model mine.blob --out mine-evaluation\n  meniscus evaluate --learned water --learned butter --json"
)]
pub(crate) struct Arguments {
    /// The model: the one in the program (shipped) or a blob.
    #[arg(long, default_value = "shipped", value_name = "shipped|FILE", help_heading = "Input")]
    model: String,
    /// Folder of the recordings, LIQUID/KIND-SEED.safetensors.
    #[arg(long, default_value = "data", value_name = "DIR", help_heading = "Input")]
    recordings: PathBuf,
    /// Only this liquid; may be repeated.
    #[arg(long, value_name = "NAME", help_heading = "Input")]
    liquid: Vec<String>,
    /// Only show the figures of this finished folder of `meniscus learn`; may be repeated.
    #[arg(long, value_name = "DIR", conflicts_with_all = ["liquid", "model", "recordings", "seed", "out"], help_heading = "Input")]
    learned: Vec<PathBuf>,
    /// Seed of all random draws.
    #[arg(long, default_value_t = 1, help_heading = "Input")]
    seed: u64,
    /// Folder for the report; it is made.
    #[arg(long, default_value = "evaluation", value_name = "DIR", help_heading = "Output")]
    out: PathBuf,
    /// Print one JSON object.
    #[arg(long, help_heading = "Output")]
    json: bool,
}

/// A bar for what takes long, none for a script.
struct Bar(ProgressBar, bool);

impl Watch for Bar {
    fn tell(&mut self, what: &str, done: f64) {
        if self.0.message() != what {
            self.0.reset();
            self.0.set_message(String::from(what));
        }
        self.0.set_position((1000.0 * done) as u64);
    }

    fn quiet(&self) -> bool {
        self.1
    }
}

/// Shows the figures of finished runs of `meniscus learn`.
fn learned(arguments: &Arguments) -> anyhow::Result<()> {
    let mut checks = Vec::new();
    for folder in &arguments.learned {
        checks.extend(learned_rows(folder)?);
    }
    if arguments.json {
        println!("{:#}", serde_json::json!({ "checks": checks }));
    } else {
        print!("{}", table(&checks));
    }
    Ok(())
}

/// Runs the verb.
pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    if !arguments.learned.is_empty() {
        return learned(arguments);
    }
    for name in &arguments.liquid {
        let known = COURSES.map(|course| course.name);
        ensure!(
            known.contains(&name.as_str()),
            "no liquid of the study is called '{name}': take {}",
            known.join(", ")
        );
    }
    let bytes = file(&arguments.model)?;
    check_folder(&arguments.out)?;
    check_folder(&arguments.recordings)?;
    let stop = watched_until(format!(
        "no report is written; recordings that were simulated stay in {}",
        arguments.recordings.display()
    ))?;
    let bar = if arguments.json { ProgressBar::hidden() } else { crate::bars::bar(1000) };
    bar.set_style(crate::bars::style("{msg:36} {wide_bar} {percent} %, {left}")?);
    let mut watch = Bar(bar, arguments.json);
    let study = study(&bytes, &arguments.recordings, &arguments.liquid, arguments.seed, stop, &mut watch)?;
    watch.0.finish_and_clear();
    finish();
    let checks = checks(&study);
    let command = format!("meniscus evaluate --model {} --seed {}", arguments.model, arguments.seed);
    let report = report(&study, &checks, &command)?;
    write_whole(&arguments.out.join("evaluate.md"), report.markdown().as_bytes())?;
    write_whole(&arguments.out.join("evaluate.html"), report.html().as_bytes())?;
    for (draw, name) in [(curves_png as fn(&[_], &_) -> _, "curves.png"), (peaks_png, "peaks.png")] {
        draw(&study.results, &arguments.out.join(name))?;
    }
    for result in &study.results {
        write_whole(&arguments.out.join(format!("{}.blob", result.course.name)), &result.corrected.blob)?;
    }
    if arguments.json {
        println!("{:#}", report.json());
    } else {
        print!("{}", table(&checks));
        println!("written: {}", arguments.out.display());
    }
    Ok(())
}
