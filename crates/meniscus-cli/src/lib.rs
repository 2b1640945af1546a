//! The `meniscus` command: one file or folder a verb.

#[cfg(not(feature = "train"))]
mod absent;
mod among;
mod bars;
#[cfg(feature = "studies")]
mod bench;
mod bus;
#[cfg(feature = "studies")]
mod cache;
#[cfg(feature = "desk")]
mod camera;
#[cfg(feature = "train")]
mod correct;
#[cfg(feature = "studies")]
mod deadline;
#[cfg(feature = "studies")]
mod discover;
mod doctor;
mod dump;
mod errors;
#[cfg(feature = "train")]
mod evaluate;
#[cfg(feature = "studies")]
mod export;
#[cfg(feature = "desk")]
mod film;
#[cfg(feature = "studies")]
mod filmed;
mod flash;
#[cfg(feature = "train")]
mod generic;
mod glass;
mod help;
mod inputs;
#[cfg(feature = "studies")]
mod insert;
mod kind;
#[cfg(feature = "train")]
mod learn;
mod logging;
#[cfg(feature = "desk")]
mod manual;
mod options_file;
mod outline;
mod outputs;
#[cfg(feature = "studies")]
mod people;
#[cfg(feature = "studies")]
mod plan;
mod profile;
#[cfg(feature = "studies")]
mod quantize;
#[cfg(feature = "studies")]
mod recognise;
#[cfg(all(feature = "bags", feature = "desk"))]
mod record;
#[cfg(feature = "studies")]
mod render;
mod run;
mod service;
mod setup;
#[cfg(feature = "studies")]
mod simulate;
#[cfg(feature = "studies")]
mod stop;
#[cfg(feature = "studies")]
mod sweep;
#[cfg(feature = "desk")]
mod tag;
#[cfg(feature = "train")]
mod train;
mod variant;
mod webcam;
#[cfg(not(all(feature = "bags", feature = "desk")))]
use absent::record;
#[cfg(not(feature = "studies"))]
use absent::{
    bench, deadline, discover, export, insert, people, plan, quantize, recognise, render, simulate, sweep,
};
#[cfg(not(feature = "desk"))]
use absent::{camera, manual, tag};
#[cfg(not(feature = "train"))]
use absent::{correct, evaluate, generic, learn, train};

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use std::ffi::OsString;
use std::process::ExitCode;

/// Estimates the motion of a sloshing liquid in a glass from a depth camera's view of its surface.
#[derive(Parser)]
#[command(name = "meniscus", bin_name = "meniscus", version, max_term_width = 100)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Run(Box<run::Arguments>),
    Simulate(simulate::Arguments),
    Plan(plan::Arguments),
    Tag(tag::Arguments),
    Learn(learn::Arguments),
    Train(train::Arguments),
    Correct(correct::Arguments),
    Evaluate(evaluate::Arguments),
    Sweep(sweep::Arguments),
    Generic(generic::Arguments),
    Discover(discover::Arguments),
    Setup(setup::Arguments),
    Doctor(doctor::Arguments),
    Dump(dump::Arguments),
    Flash(flash::Arguments),
    Service(service::Arguments),
    Camera(camera::Arguments),
    Record(record::Arguments),
    People(people::Arguments),
    Render(render::Arguments),
    Export(export::Arguments),
    #[command(alias = "adopt")]
    Insert(insert::Arguments),
    Quantize(quantize::Arguments),
    Recognise(recognise::Arguments),
    Bench(bench::Arguments),
    Deadline(deadline::Arguments),
    Manual(manual::Arguments),
}

/// Returns the whole command line, as `meniscus` parses it and `--help` shows it.
#[must_use]
pub fn command() -> clap::Command {
    help::laid_out(Arguments::command())
}

/// Returns the arguments of the process; ends it where they ask for help or are wrong.
fn arguments() -> Arguments {
    if std::env::args_os().len() < 2 {
        // A usage error, as any missing argument: a script that forgot the verb must not go on.
        eprint!("{}", help::start());
        std::process::exit(2);
    }
    let (program, words) = (command(), std::env::args_os().collect::<Vec<_>>());
    let matches = program.clone().try_get_matches_from(&words).unwrap_or_else(|error| errors::exit(&error));
    let matches = options_file::with_file(&program, matches, &words).unwrap_or_else(|error| {
        let line = format!("error: {}", errors::plain(error.to_string()));
        eprintln!("{line}");
        meniscus_service::run::tell_failure(&line);
        std::process::exit(2);
    });
    Arguments::from_arg_matches(&matches).unwrap_or_else(|error| error.exit())
}

/// Returns the arguments of `meniscus run` in the command line `words`.
fn run_arguments(words: &[OsString]) -> anyhow::Result<run::Arguments> {
    let program = command();
    let matches = options_file::with_file(&program, program.clone().try_get_matches_from(words)?, words)?;
    match Arguments::from_arg_matches(&matches)?.command {
        Command::Run(arguments) => Ok(*arguments),
        _ => anyhow::bail!("a run is expected"),
    }
}

/// Exit status of a program that a broken pipe has ended, as the shell tells it: 128 and the signal's number.
const PIPE_BROKE: i32 = 141;

/// Ends the program quietly when nobody reads on what it prints (`meniscus ... | head`): `println!` panics then.
fn end_with_the_reader() {
    let otherwise = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        let why = panic.payload_as_str().unwrap_or_default();
        if why.starts_with("failed printing to std") && why.contains("Broken pipe") {
            std::process::exit(PIPE_BROKE);
        }
        otherwise(panic);
    }));
}

/// Runs the command that the arguments of the process name, and returns its exit status.
pub fn main() -> ExitCode {
    end_with_the_reader();
    meniscus_platform::cpu_features::widen();
    #[cfg(feature = "studies")]
    cache::keep_settled();
    logging::begin();
    let done = match arguments().command {
        Command::Run(arguments) => run::run(&arguments),
        Command::Simulate(arguments) => simulate::run(&arguments),
        Command::Plan(arguments) => plan::run(&arguments),
        Command::Tag(arguments) => tag::run(&arguments),
        Command::Learn(arguments) => learn::run(&arguments),
        Command::Train(arguments) => train::run(&arguments),
        Command::Correct(arguments) => correct::run(&arguments),
        Command::Evaluate(arguments) => evaluate::run(&arguments),
        Command::Sweep(arguments) => sweep::run(&arguments),
        Command::Generic(arguments) => generic::run(&arguments),
        Command::Discover(arguments) => discover::run(&arguments),
        Command::Setup(arguments) => setup::run(&arguments),
        Command::Doctor(arguments) => doctor::run(&arguments),
        Command::Dump(arguments) => dump::run(&arguments),
        Command::Flash(arguments) => flash::run(&arguments),
        Command::Service(arguments) => service::run(&arguments),
        Command::Camera(arguments) => camera::run(&arguments),
        Command::Record(arguments) => record::run(&arguments),
        Command::People(arguments) => people::run(&arguments),
        Command::Render(arguments) => render::run(&arguments),
        Command::Export(arguments) => export::run(&arguments),
        Command::Insert(arguments) => insert::run(&arguments),
        Command::Quantize(arguments) => quantize::run(&arguments),
        Command::Recognise(arguments) => recognise::run(&arguments),
        Command::Bench(arguments) => bench::run(&arguments),
        Command::Deadline(arguments) => deadline::run(&arguments),
        #[cfg(feature = "desk")]
        Command::Manual(arguments) => manual::run(&arguments, command()),
        #[cfg(not(feature = "desk"))]
        Command::Manual(arguments) => manual::run(&arguments),
    };
    if let Err(error) = &done {
        // One line, cause after cause; a backtrace helps nobody at a terminal.
        let line = format!("error: {}", errors::line(error));
        eprintln!("{line}");
        meniscus_service::run::tell_failure(&line);
        outputs::remove_empty();
    }
    #[cfg(feature = "studies")]
    if stop::raised() {
        return ExitCode::from(stop::INTERRUPTED);
    }
    if done.is_ok() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
