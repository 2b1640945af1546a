//! `cargo xtask nightly`: steps that take hours, one log per day in `docs/nightly/DATE.log`.

mod attempt;
mod log;
mod state;

use crate::process::{Step, cargo};
use crate::workspace;
use anyhow::{Result, bail};
use attempt::attempt;
use clap::Args;
use log::Log;
use state::{State, head};
use std::path::Path;

/// Times the usual cases of the fuzz tests: a million for the quickest targets.
const FUZZ_TIMES: &str = "50";

/// Files of the core that mutation testing alters.
const MUTATED: [&str; 13] = [
    "blob/assemble",
    "blob/load",
    "blob/store",
    "filter/covariance",
    "filter/kalman",
    "filter/measurements",
    "latent/generic/friction_law",
    "latent/generic/step",
    "surface/depth",
    "surface/extract",
    "uncertainty/error_model",
    "usb/d4xx/table",
    "usb/uvc/assembler",
];

/// The program that the studies run, in the target folder.
const PROGRAM: &str = "release/meniscus";
/// Name of the step that builds it.
const BUILD: &str = "build";

/// Options of `cargo xtask nightly`.
#[derive(Args)]
pub(crate) struct Options {
    /// Only this step; may be repeated. The day's log keeps the records of the others.
    #[arg(long, value_name = "NAME")]
    only: Vec<String>,
    /// Print the steps and run none.
    #[arg(long)]
    list: bool,
}

/// Runs the steps and returns whether all passed. A step that fails does not stop the others.
pub(crate) fn run(options: &Options) -> Result<bool> {
    let root = workspace::root()?;
    let steps = chosen(steps(&root), &options.only)?;
    if options.list {
        for step in &steps {
            println!("{:<16} {}", step.name, step.line());
        }
        return Ok(true);
    }
    let day = State::now(&root)?.day().to_owned();
    let mut log = Log::open(root.join("docs/nightly").join(format!("{day}.log")), head())?;
    let mut passed = true;
    for step in &steps {
        println!("== {}: {}", step.name, step.line());
        let state = State::now(&root)?;
        let done = attempt(&root, step);
        passed &= done.passed();
        let record = done.record(step, &state);
        print!("{record}");
        log.put(record);
        // After every step, so that an interrupted night leaves what it measured.
        log.write()?;
    }
    println!("nightly: {} in {}", if passed { "all passed" } else { "FAILED" }, log.path().display());
    Ok(passed)
}

/// The steps of a night. The program is built first; the studies run that build.
fn steps(root: &Path) -> Vec<Step> {
    let cargo = cargo();
    let program = workspace::target(root).join(PROGRAM).to_string_lossy().into_owned();
    let study =
        |name: &str, words: &str| Step::new(name, [&program].into_iter().cloned().chain(split(words)));
    let with_cargo =
        |name: &str, words: &str| Step::new(name, [&cargo].into_iter().cloned().chain(split(words)));
    vec![
        with_cargo(BUILD, "build --release --locked -p meniscus-cli --features train,foxglove"),
        // The program of a board, and the build of `cargo view`; CI lints the workspace with all features.
        with_cargo(
            "lints-board",
            "clippy --release --locked -p meniscus-cli --no-default-features -- -D warnings",
        ),
        with_cargo(
            "lints-view",
            "clippy --release --locked -p meniscus-cli --no-default-features --features desk -- -D warnings",
        ),
        with_cargo("house", "xtask house --rebuild --json"),
        with_cargo("package", "xtask package"),
        with_cargo("board", "xtask board --json"),
        // `cargo install cargo-deny typos-cli`; advisories are asked for where their database can be fetched.
        with_cargo("licences", "deny --workspace check licenses bans sources"),
        Step::new("spelling", split("typos")),
        with_cargo("fuzz", "test --release --locked --workspace --test fuzz")
            .with("MENISCUS_FUZZ", FUZZ_TIMES),
        // Sizes by simulation, and laws of the simulator's effects that take minutes.
        with_cargo(
            "sizing",
            "test --release --locked --workspace --test discover_sizing --test effects --test learn -- --include-ignored",
        ),
        // `cargo install cargo-mutants`; `.cargo/mutants.toml` has its settings.
        with_cargo(
            "mutants",
            &format!("mutants {}", MUTATED.map(|file| format!("-f src/{file}.rs")).join(" ")),
        ),
        study("validate", "simulate validate --json --out out/nightly/validation"),
        study("discover", "discover study --json --out out/nightly/discover"),
        study("camera", "camera study --json --check --out out/nightly/camera"),
        study("deadline", "deadline --json --out out/nightly/deadline"),
        // Each attack alone, so that times and memory are its own; CI judges those that the tests ran two at a time.
        with_cargo("trust", "xtask trust --json"),
        with_cargo("under-attack", "xtask under-attack --json"),
        study("people", "people study --json --check"),
        Step::new("hil-gate", split("hil/run gate --json")),
        Step::new("hil-boot", split("hil/run boot --json")),
        Step::new("hil-install", split("hil/run install --json")),
        Step::new("hil-xhci", split("hil/run xhci --json")),
        Step::new("hil-webcam", split("hil/run webcam")),
        Step::new("hil-bare-metal", split("hil/run bare-metal --json")),
        Step::new("hil-soak", split("hil/run soak --json")),
    ]
}

fn split(words: &str) -> impl Iterator<Item = String> {
    words.split_whitespace().map(str::to_owned)
}

/// The steps with the given names; all of them without a name. With a step that runs the program comes the one that builds
/// it: the record names the commit, and an older program would be another's.
fn chosen(steps: Vec<Step>, only: &[String]) -> Result<Vec<Step>> {
    let known: Vec<&str> = steps.iter().map(|step| step.name.as_str()).collect();
    if let Some(name) = only.iter().find(|name| !known.contains(&name.as_str())) {
        bail!("there is no step `{name}`; the steps are {}", known.join(", "));
    }
    let wanted = |step: &Step| only.is_empty() || only.contains(&step.name);
    let needs_build = steps.iter().any(|step| wanted(step) && step.words[0].ends_with(PROGRAM));
    Ok(steps.into_iter().filter(|step| wanted(step) || needs_build && step.name == BUILD).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unknown_steps_are_refused_and_known_ones_chosen() {
        let all = || steps(Path::new("/w"));
        let names = |only: &str| -> Vec<String> {
            chosen(all(), &[only.to_owned()]).unwrap().into_iter().map(|step| step.name).collect()
        };
        assert_eq!(names("fuzz"), ["fuzz"]);
        assert_eq!(names("people"), ["build", "people"]);
        assert_eq!(chosen(all(), &[]).unwrap().len(), all().len());
        let error = chosen(all(), &["fuz".to_owned()]).unwrap_err().to_string();
        assert!(error.contains("`fuz`") && error.contains("validate"), "{error}");
    }
}
