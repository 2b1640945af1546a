//! The `meniscus` command.
#![allow(clippy::disallowed_methods, reason = "only storey 1 must compute the same bits on every platform")]

mod cli;

use clap::{CommandFactory, Parser, Subcommand};
use meniscus::host::allocations::CountingAllocator;
use std::process::ExitCode;

/// Counts what the worker allocates in a turn: nothing.
#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

/// Watches the free surface of a sloshing liquid through a depth camera and knows the whole liquid.
#[derive(Parser)]
#[command(version, max_term_width = 100)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Run(Box<cli::run::Arguments>),
    Simulate(cli::simulate::Arguments),
    Train(cli::train::Arguments),
    Correct(cli::correct::Arguments),
    Evaluate(cli::evaluate::Arguments),
    Generic(cli::generic::Arguments),
    Discover(cli::discover::Arguments),
    Setup(cli::setup::Arguments),
    Doctor(cli::doctor::Arguments),
    Dump(cli::dump::Arguments),
    Flash(cli::flash::Arguments),
    Camera(cli::camera::Arguments),
    Record(cli::record::Arguments),
    People(cli::people::Arguments),
    Render(cli::render::Arguments),
    Adopt(cli::adopt::Arguments),
    Quantize(cli::quantize::Arguments),
    Recognise(cli::recognise::Arguments),
    Bench(cli::bench::Arguments),
    Deadline(cli::deadline::Arguments),
    Manual(cli::manual::Arguments),
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

fn main() -> ExitCode {
    end_with_the_reader();
    meniscus::host::wide::widen();
    let done = match Arguments::parse().command {
        Command::Run(arguments) => cli::run::run(&arguments),
        Command::Simulate(arguments) => cli::simulate::run(&arguments),
        Command::Train(arguments) => cli::train::run(&arguments),
        Command::Correct(arguments) => cli::correct::run(&arguments),
        Command::Evaluate(arguments) => cli::evaluate::run(&arguments),
        Command::Generic(arguments) => cli::generic::run(&arguments),
        Command::Discover(arguments) => cli::discover::run(&arguments),
        Command::Setup(arguments) => cli::setup::run(&arguments),
        Command::Doctor(arguments) => cli::doctor::run(&arguments),
        Command::Dump(arguments) => cli::dump::run(&arguments),
        Command::Flash(arguments) => cli::flash::run(&arguments),
        Command::Camera(arguments) => cli::camera::run(&arguments),
        Command::Record(arguments) => cli::record::run(&arguments),
        Command::People(arguments) => cli::people::run(&arguments),
        Command::Render(arguments) => cli::render::run(&arguments),
        Command::Adopt(arguments) => cli::adopt::run(&arguments),
        Command::Quantize(arguments) => cli::quantize::run(&arguments),
        Command::Recognise(arguments) => cli::recognise::run(&arguments),
        Command::Bench(arguments) => cli::bench::run(&arguments),
        Command::Deadline(arguments) => cli::deadline::run(&arguments),
        Command::Manual(arguments) => cli::manual::run(&arguments, Arguments::command()),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // One line, cause after cause; a backtrace helps nobody at a terminal.
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}
