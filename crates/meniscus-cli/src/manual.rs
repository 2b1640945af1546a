//! `meniscus manual`: the man pages and the shell's completions, made from the same words as `--help`.

use anyhow::Context;
use clap::{Command, ValueEnum};
use clap_complete::Shell;
use clap_mangen::Man;
use meniscus_platform::files::write_whole;
use std::path::{Path, PathBuf};

/// Write man pages and completions for the shells.
///
/// Into --out go meniscus.1, a page for every verb (meniscus-run.1), and a file of completions for every shell.
#[derive(clap::Args)]
#[command(
    verbatim_doc_comment,
    after_help = "Examples:\n  meniscus manual --out /tmp/manual && man /tmp/manual/meniscus-run.1\n  meniscus manual --out /tmp/manual && . /tmp/manual/meniscus.bash"
)]
pub(crate) struct Arguments {
    /// Folder for the files; it is made if it is not there.
    #[arg(long, default_value = "manual", value_name = "DIR")]
    out: PathBuf,
}

/// Runs the verb; `program` is the whole command line.
pub(crate) fn run(arguments: &Arguments, mut program: Command) -> anyhow::Result<()> {
    program.build();
    let mut pages = 0;
    page(&program, &arguments.out, &mut pages)?;
    for &shell in Shell::value_variants() {
        let mut script = Vec::new();
        clap_complete::generate(shell, &mut program, "meniscus", &mut script);
        let name = match shell {
            Shell::Zsh => String::from("_meniscus"),
            _ => format!("meniscus.{shell}"),
        };
        write_whole(&arguments.out.join(name), &script)?;
    }
    println!(
        "{}: {pages} man pages, completions for {} shells",
        arguments.out.display(),
        Shell::value_variants().len()
    );
    Ok(())
}

/// The page of `command`, which has been built and so knows its whole name, and those of its verbs.
fn page(command: &Command, out: &Path, pages: &mut usize) -> anyhow::Result<()> {
    let man = Man::new(command.clone());
    let (name, mut text) = (man.get_filename(), Vec::new());
    man.render(&mut text).with_context(|| format!("the page {name}"))?;
    write_whole(&out.join(name), &text)?;
    *pages += 1;
    for verb in command.get_subcommands().filter(|verb| verb.get_name() != "help") {
        page(verb, out, pages)?;
    }
    Ok(())
}
