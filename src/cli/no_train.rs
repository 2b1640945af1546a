//! `meniscus train` in a program that was built without it: says how to get it.

/// Learn a liquid from recordings and write the weight blob (not in this build: see below).
///
/// Training needs the feature `train`, which takes some minutes to build. From the repository:
///
///   cargo run --release --features train -- train --help
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub(crate) struct Arguments {
    /// Whatever the training would have been asked.
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
    _rest: Vec<String>,
}

/// Refuses, with the remedy.
pub(crate) fn run(_: &Arguments) -> anyhow::Result<()> {
    anyhow::bail!(
        "this program was built without training; from the repository: \
         cargo run --release --features train -- train --help"
    )
}
