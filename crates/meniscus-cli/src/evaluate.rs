//! `meniscus evaluate`: a model on liquids that it does not know, before and after correction.

use super::inputs::file;
use super::stop::watched;
use anyhow::{Context, ensure};
use indicatif::{ProgressBar, ProgressStyle};
use meniscus_learn::evaluate::{COURSES, Watch, checks, curves_png, peaks_png, report, study};
use meniscus_platform::files::write_whole;
use meniscus_report::checks::table;
use std::path::PathBuf;

/// Evaluate a model on liquids that it was not trained on, before and after correction.
///
/// For each liquid the model sees a recording through the simulated camera (depth noise 2 mm), is corrected
/// by other recordings' free surfaces, and sees the first one again. Water, butter and blood are moved
/// along a line and learnt from four recordings of 4 s; beer, honey, gazpacho and water once more (water_by_hand)
/// are moved as by a hand, a tenth of the way out of line, and learnt from one. Missing recordings are simulated
/// into --recordings, about 25 s each on two processors, and stay there.
///
/// Into --out go evaluate.html (the report, one file), evaluate.md, curves.png, peaks.png and each corrected blob. A missed target is reported,
/// and is no error of the command.
#[derive(clap::Args, Debug)]
pub(crate) struct Arguments {
    /// The model: the one in the program (shipped) or a blob file.
    #[arg(long, default_value = "shipped", value_name = "shipped|FILE")]
    model: String,
    /// Folder of the recordings, LIQUID/KIND-SEED.safetensors.
    #[arg(long, default_value = "data", value_name = "DIR")]
    recordings: PathBuf,
    /// Folder for the report; it is made if it is not there.
    #[arg(long, default_value = "evaluation", value_name = "DIR")]
    out: PathBuf,
    /// Only these liquids, by the study's names.
    #[arg(long, value_name = "NAME")]
    liquid: Vec<String>,
    /// Seed of everything that is drawn.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// One JSON object on standard output.
    #[arg(long)]
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

/// Runs the verb.
pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let stop = watched()?;
    for name in &arguments.liquid {
        let known = COURSES.map(|course| course.name);
        ensure!(
            known.contains(&name.as_str()),
            "no liquid of the study is called '{name}': take {}",
            known.join(", ")
        );
    }
    let bytes = file(&arguments.model)?;
    std::fs::create_dir_all(&arguments.out)
        .with_context(|| format!("cannot make the directory {}", arguments.out.display()))?;
    let bar = if arguments.json { ProgressBar::hidden() } else { ProgressBar::new(1000) };
    bar.set_style(ProgressStyle::with_template("{msg:36} {wide_bar} {percent} %, {eta} left")?);
    let mut watch = Bar(bar, arguments.json);
    let study = study(&bytes, &arguments.recordings, &arguments.liquid, arguments.seed, stop, &mut watch)?;
    watch.0.finish_and_clear();
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
