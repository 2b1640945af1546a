//! `meniscus manual`: the man pages and the shell's completions, made from the same words as `--help`.

use anyhow::Context;
use clap::{Command, ValueEnum};
use clap_complete::Shell;
use clap_mangen::Man;
use meniscus_platform::files::write_whole;
use std::path::{Path, PathBuf};

/// Write man pages and completions for the shells.
///
/// The --out folder gets meniscus.1, a page for every verb (meniscus-run.1), and a file of completions for every shell.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  meniscus manual --out /tmp/manual && man /tmp/manual/meniscus-run.1\n  meniscus manual --out /tmp/manual && . /tmp/manual/meniscus.bash"
)]
pub(crate) struct Arguments {
    /// Folder for the files; it is made.
    #[arg(long, default_value = "manual", value_name = "DIR", help_heading = "Output")]
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

/// Writes the page of `command`, which has been built and so knows its whole name, and those of its verbs.
fn page(command: &Command, out: &Path, pages: &mut usize) -> anyhow::Result<()> {
    let name = Man::new(command.clone()).get_filename();
    write_whole(&out.join(&name), &text(command).with_context(|| format!("the page {name}"))?)?;
    *pages += 1;
    for verb in command.get_subcommands().filter(|verb| verb.get_name() != "help") {
        page(verb, out, pages)?;
    }
    Ok(())
}

/// Returns the page of `command`. Its examples and its appendix keep their lines, which clap's own section would join.
fn text(command: &Command) -> std::io::Result<Vec<u8>> {
    let (man, mut text) = (Man::new(command.clone()), Vec::new());
    man.render_title(&mut text)?;
    man.render_name_section(&mut text)?;
    man.render_synopsis_section(&mut text)?;
    man.render_description_section(&mut text)?;
    if let Some(examples) = command.get_after_help() {
        literal(&mut text, "EXAMPLES", examples.to_string().lines().skip(1));
    }
    man.render_options_section(&mut text)?;
    if command.has_subcommands() {
        man.render_subcommands_section(&mut text)?;
    }
    if let Some(more) = command.get_after_long_help() {
        literal(&mut text, "NOTES", more.to_string().lines());
    }
    if command.get_version().is_some() {
        man.render_version_section(&mut text)?;
    }
    Ok(text)
}

/// Appends a section whose lines stay as they are.
fn literal<'l>(text: &mut Vec<u8>, title: &str, lines: impl Iterator<Item = &'l str>) {
    text.extend(format!(".SH {title}\n.nf\n").bytes());
    for line in lines {
        let line = line.trim_start().replace('\\', "\\e").replace('-', "\\-");
        let guard = if line.starts_with(['.', '\'']) { "\\&" } else { "" };
        text.extend(format!("{guard}{line}\n").bytes());
    }
    text.extend(b".fi\n");
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn a_page_has_every_example_on_a_line_of_its_own() {
        let mut program = crate::Arguments::command();
        program.build();
        let run = program.find_subcommand("run").expect("a verb");
        let page = String::from_utf8(text(run).expect("written")).expect("text");
        assert!(page.contains(".SH EXAMPLES\n.nf\nmeniscus run\nmeniscus run \\-\\-view\n"), "{page}");
        assert!(page.contains(".SH OPTIONS") && page.contains("Coasting"), "{page}");
        assert!(!page.contains("meniscus run\n.PP"), "{page}");
    }
}
