//! Manifest of a sweep: its parts with their commands, in the file `manifest.json` of its folder.

use super::design::{Design, Values};
use anyhow::{Context, bail, ensure};
use meniscus_platform::files::write_whole;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Part of a sweep.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Part {
    /// Values.
    pub(super) values: Values,
    /// Words of its command, with `{out}` for its folder.
    pub(super) words: Vec<String>,
}

/// Manifest of a sweep.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Manifest {
    /// Version of the program that runs it.
    pub(super) version: String,
    /// Folder that files in the commands are named from.
    pub(super) files_from: PathBuf,
    /// Whether the command continues what it finds in its folder.
    pub(super) resumes: bool,
    /// Checks that are not merged.
    pub(super) leave_out: Vec<String>,
    /// Parts.
    pub(super) parts: Vec<Part>,
}

/// The manifest in the folder of a sweep.
fn path(folder: &Path) -> PathBuf {
    folder.join("manifest.json")
}

impl Manifest {
    /// Manifest of `design`, every part of which is checked as its command would check it.
    pub(super) fn of(design: &Design) -> anyhow::Result<Self> {
        let beside = design.path.parent().filter(|folder| !folder.as_os_str().is_empty());
        let folder = beside.unwrap_or(Path::new("."));
        let files_from =
            folder.canonicalize().with_context(|| format!("{} cannot be found", folder.display()))?;
        let mut parts = Vec::new();
        for (number, values) in design.parts.iter().enumerate() {
            let words = design.command(values, "{out}")?;
            check(&words).with_context(|| format!("part {} cannot run", number + 1))?;
            parts.push(Part { values: values.clone(), words });
        }
        let (resumes, leave_out) = (design.resumes, design.leave_out.clone());
        Ok(Self { version: env!("CARGO_PKG_VERSION").into(), files_from, resumes, leave_out, parts })
    }

    /// Writes it into `folder`; one that is there must be the same.
    pub(super) fn write(&self, folder: &Path) -> anyhow::Result<()> {
        if path(folder).exists() {
            let there = Self::read(folder)?;
            if there == *self {
                return Ok(());
            }
            bail!("{} holds another sweep: name another folder with --out", folder.display());
        }
        write_whole(&path(folder), format!("{}\n", serde_json::to_string_pretty(self)?).as_bytes())?;
        Ok(())
    }

    /// Reads that of `folder`.
    pub(super) fn read(folder: &Path) -> anyhow::Result<Self> {
        let path = path(folder);
        let text = std::fs::read_to_string(&path)
            .with_context(|| format!("{} cannot be read: `meniscus sweep make` writes it", path.display()))?;
        let manifest: Self = serde_json::from_str(&text)
            .with_context(|| format!("{} is no manifest of a sweep", path.display()))?;
        ensure!(
            manifest.version == env!("CARGO_PKG_VERSION"),
            "{} is of version {}, and this is {}: parts of different versions make no one report",
            path.display(),
            manifest.version,
            env!("CARGO_PKG_VERSION")
        );
        Ok(manifest)
    }
}

/// Checks the words of a command as the program would.
fn check(words: &[String]) -> anyhow::Result<()> {
    let line = std::iter::once("meniscus").chain(words.iter().map(String::as_str));
    match crate::command().try_get_matches_from(line) {
        Ok(matches) if matches.subcommand_name() == Some("sweep") => bail!("a sweep runs no sweeps"),
        Ok(_) => Ok(()),
        Err(error) => {
            let text = error.to_string();
            let first = text.lines().next().unwrap_or_default();
            bail!("`meniscus {}`: {}", words.join(" "), first.trim_start_matches("error: "))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_command_that_the_program_would_refuse_is_refused_before_the_work() {
        let words = |line: &str| -> Vec<String> { line.split(' ').map(str::to_owned).collect() };
        check(&words("simulate --motion strokes:1 --out {out}/x.safetensors")).expect("a command");
        for (line, word) in [
            ("simulat --out x", "simulat"),
            ("simulate --motion strokes:1 --seconds x --out y", "--seconds"),
            ("sweep status x", "runs no sweeps"),
        ] {
            let fault = format!("{:#}", check(&words(line)).expect_err(line));
            assert!(fault.contains(word), "`{word}` is missing in: {fault}");
        }
    }
}
