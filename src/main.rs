//! The `meniscus` command.

mod cli;

use clap::{Parser, Subcommand};

/// Watches the free surface of a sloshing liquid through a depth camera and knows the whole liquid.
#[derive(Parser)]
#[command(version, max_term_width = 100)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Simulate(cli::simulate::Arguments),
}

fn main() -> anyhow::Result<()> {
    match Arguments::parse().command {
        Command::Simulate(arguments) => cli::simulate::run(&arguments),
    }
}
