//! `meniscus discover`: name the effect that is missing between simulation and measurement.

mod study;

/// Name what is missing between simulation and measurement, with evidence, or say honestly that it is unknown.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(clap::Subcommand)]
enum Verb {
    Study(study::Arguments),
}

/// Runs the verb.
pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    match &arguments.verb {
        Verb::Study(arguments) => study::run(arguments),
    }
}
