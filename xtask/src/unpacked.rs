//! The archives of `cargo xtask package`, unpacked and built away from the repository, as `cargo install` builds them.
//!
//! The unpacked crates are a workspace of their own, with the repository's lock file and release profile. They find each other by
//! `[patch.crates-io]`: their manifests name versions and no paths. What an archive lacks is missing here, too.

use crate::process::{self, Step, cargo};
use crate::workspace::Package;
use anyhow::{Context, Result, ensure};
use std::fmt::Write as _;
use std::path::Path;

/// Crate with the command.
const COMMAND: &str = "meniscus-cli";
/// Run of the built command, without a file of the repository: model and recording are embedded.
const RUN: [&str; 4] = ["run", "--patient", "--seconds", "4"];

/// Folders of a build from archives.
pub(crate) struct Unpacked<'p> {
    /// Folder of the archives.
    pub(crate) archives: &'p Path,
    /// Folder for the unpacked crates; it is made anew.
    pub(crate) folder: &'p Path,
    /// Folder of compiled crates.
    pub(crate) target: &'p Path,
}

impl Unpacked<'_> {
    /// Installs the command from the archives of `published` and runs it in an empty folder; returns the faults.
    pub(crate) fn install(&self, root: &Path, published: &[&Package]) -> Result<Vec<String>> {
        let Self { archives, folder, target } = *self;
        if folder.exists() {
            std::fs::remove_dir_all(folder)?;
        }
        std::fs::create_dir_all(folder)?;
        for package in published {
            let archive = archives.join(format!("{}.crate", stem(package)));
            let words = ["tar".to_owned(), "xzf".to_owned(), archive.to_string_lossy().into_owned()];
            let unpacked =
                Step::new("unpack", words).command(folder)?.status().context("tar did not start")?;
            ensure!(unpacked.success(), "{} cannot be unpacked", archive.display());
            // A lock file of its own would be that of the registry's crates.
            std::fs::remove_file(folder.join(stem(package)).join("Cargo.lock")).ok();
        }
        std::fs::write(folder.join("Cargo.toml"), manifest(published))?;
        std::fs::copy(root.join("Cargo.lock"), folder.join("Cargo.lock"))?;
        // Drops what is not published from the lock file, which `--locked` would refuse to do.
        process::output(folder, [cargo().as_str(), "metadata", "--format-version", "1"])?;
        let installed = folder.join("installed");
        let Some(command) = published.iter().find(|package| package.name == COMMAND) else {
            return Ok(vec![format!("{COMMAND} is not published")]);
        };
        let words = [
            &cargo(),
            "install",
            "--locked",
            "--path",
            &stem(command),
            "--root",
            &installed.to_string_lossy(),
        ]
        .map(str::to_owned);
        let step = Step::new("install", words).with("CARGO_TARGET_DIR", &target.to_string_lossy());
        if !process::timed(folder, &step)?.passed {
            return Ok(vec![format!("{COMMAND} cannot be installed from the archives")]);
        }
        let empty = folder.join("empty");
        std::fs::create_dir(&empty)?;
        let program = installed.join("bin/meniscus").to_string_lossy().into_owned();
        let run = Step::new("run", [program].into_iter().chain(RUN.map(str::to_owned)));
        Ok(if process::timed(&empty, &run)?.passed {
            Vec::new()
        } else {
            vec!["the installed command fails in an empty folder".to_owned()]
        })
    }
}

/// Name of a crate's archive and of the folder in it.
fn stem(package: &Package) -> String {
    format!("{}-{}", package.name, package.manifest["version"].as_str().unwrap_or_default())
}

/// Manifest of a workspace of the unpacked crates.
fn manifest(published: &[&Package]) -> String {
    let members: Vec<String> = published.iter().map(|package| format!("{:?}", stem(package))).collect();
    let mut text = format!(
        "[workspace]\nresolver = \"3\"\nmembers = [{}]\n\n[profile.release]\ndebug = \"line-tables-only\"\n\n[patch.crates-io]\n",
        members.join(", ")
    );
    for package in published {
        // A `String` takes every line.
        let _written = writeln!(text, "{} = {{ path = {:?} }}", package.name, stem(package));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn the_crates_find_each_other_by_their_folders() {
        let package = Package {
            name: "meniscus-cli".to_owned(),
            folder: "/w/crates/meniscus-cli".into(),
            roots: Vec::new(),
            has_library: true,
            members: Vec::new(),
            published: true,
            manifest: json!({"version": "0.1.0"}),
        };
        let text = manifest(&[&package]);
        assert!(text.contains("members = [\"meniscus-cli-0.1.0\"]"), "{text}");
        assert!(
            text.ends_with("[patch.crates-io]\nmeniscus-cli = { path = \"meniscus-cli-0.1.0\" }\n"),
            "{text}"
        );
    }
}
