//! `cargo xtask package`: the archives that a registry would get, for every crate that is published.

use crate::process::{self, Step, cargo};
use crate::workspace::{self, Package};
use anyhow::Result;
use clap::Args;
use serde_json::Value;
use std::path::Path;

/// Largest compressed archive that crates.io takes, bytes.
const LARGEST_ARCHIVE: u64 = 10_000_000;

/// Texts of the licences: both ask that they go with every copy.
const LICENCES: [&str; 2] = ["LICENSE-APACHE", "LICENSE-MIT"];

/// Options of `cargo xtask package`.
#[derive(Args)]
pub(crate) struct Options {
    /// Only the fields and the lists of files; make no archives.
    #[arg(long)]
    list: bool,
}

/// Checks all published crates and returns whether every one can be published.
pub(crate) fn run(options: &Options) -> Result<bool> {
    let root = workspace::root()?;
    let packages = workspace::packages(&root)?;
    let published: Vec<&Package> = packages.iter().filter(|package| package.published).collect();
    let mut faults = Vec::new();
    for package in &published {
        let listed = list(&root, package)?;
        let needed = needed_files(package)?;
        faults.extend(missing_fields(package));
        faults.extend(missing_files(&package.name, &needed, &listed));
        println!(
            "{:<20} {:>4} files, {} of them embedded or named",
            package.name,
            listed.len(),
            needed.len()
        );
    }
    if !options.list {
        faults.extend(archives(&root, &published)?);
    }
    for fault in &faults {
        println!("{fault}");
    }
    println!("package: {} crates, {} faults", published.len(), faults.len());
    Ok(faults.is_empty())
}

/// Files that cargo would put into the archive.
fn list(root: &Path, package: &Package) -> Result<Vec<String>> {
    let cargo = cargo();
    let words = [cargo.as_str(), "package", "--list", "--allow-dirty", "-p", package.name.as_str()];
    Ok(process::output(root, words)?.lines().map(str::to_owned).collect())
}

/// Fields of the manifest that a registry needs and that are not there.
fn missing_fields(package: &Package) -> Vec<String> {
    let empty = |field: &&&str| match &package.manifest[**field] {
        Value::String(text) => text.trim().is_empty(),
        Value::Array(items) => items.is_empty(),
        _ => true,
    };
    let fields = ["description", "license", "readme", "keywords", "categories"];
    let manifest = package.folder.join("Cargo.toml");
    let line = |field| format!("{}: {} has no `{field}`", manifest.display(), package.name);
    fields.iter().filter(empty).map(line).collect()
}

/// Paths below the package's folder that its sources embed, the file that its manifest names as readme, and the
/// licences.
fn needed_files(package: &Package) -> Result<Vec<String>> {
    let mut needed: Vec<String> = LICENCES.iter().map(|&name| name.to_owned()).collect();
    needed.extend(package.manifest["readme"].as_str().map(file_name));
    for source in workspace::files(&package.folder, ".rs")? {
        let text = std::fs::read_to_string(&source)?;
        let below = source.parent().and_then(|folder| folder.strip_prefix(&package.folder).ok());
        // The root package's folder holds the other packages, too.
        if let Some(folder) = below.filter(|folder| folder.starts_with("src")) {
            needed.extend(embedded(&text).iter().map(|path| normal(folder, path)));
        }
    }
    needed.sort_unstable();
    needed.dedup();
    Ok(needed)
}

fn file_name(path: &str) -> String {
    Path::new(path).file_name().map_or(String::new(), |name| name.to_string_lossy().into_owned())
}

/// Paths in `include_str!` and `include_bytes!` of a source, outside comments.
fn embedded(text: &str) -> Vec<String> {
    let code = text.lines().filter(|line| !line.trim_start().starts_with("//"));
    let in_line = |line: &str| {
        let calls = line.split("include_").skip(1);
        let path = |call: &str| {
            let quoted = call.strip_prefix("str!(\"").or_else(|| call.strip_prefix("bytes!(\""))?;
            Some(quoted.split_once('"')?.0.to_owned())
        };
        calls.filter_map(path).collect::<Vec<_>>()
    };
    code.flat_map(in_line).collect()
}

/// A path without `..`, as archives have it.
fn normal(folder: &Path, path: &str) -> String {
    let mut names: Vec<String> = folder.iter().map(|name| name.to_string_lossy().into_owned()).collect();
    for name in path.split('/') {
        if name == ".." {
            names.pop();
        } else {
            names.push(name.to_owned());
        }
    }
    names.join("/")
}

fn missing_files(name: &str, needed: &[String], listed: &[String]) -> Vec<String> {
    let missing = needed.iter().filter(|path| !listed.contains(path));
    missing.map(|path| format!("{name}: {path} is not in the archive")).collect()
}

/// Makes all archives at once, so that the crates find each other before any is published.
fn archives(root: &Path, published: &[&Package]) -> Result<Vec<String>> {
    let mut words = vec![cargo(), "package".to_owned(), "--no-verify".to_owned(), "--allow-dirty".to_owned()];
    words.extend(published.iter().flat_map(|package| ["-p".to_owned(), package.name.clone()]));
    if !process::timed(root, &Step::new("archives", words))?.passed {
        return Ok(vec!["cargo package failed; its messages stand above".to_owned()]);
    }
    let folder = workspace::target(root).join("package");
    let mut faults = Vec::new();
    for package in published {
        let version = package.manifest["version"].as_str().unwrap_or_default();
        let archive = folder.join(format!("{}-{version}.crate", package.name));
        let size = std::fs::metadata(&archive)?.len();
        println!("{:<20} {size:>9} bytes", package.name);
        if size > LARGEST_ARCHIVE {
            faults.push(format!("{}: {size} bytes, a registry takes {LARGEST_ARCHIVE}", archive.display()));
        }
    }
    Ok(faults)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;
    use std::path::PathBuf;

    #[test]
    fn a_manifest_without_fields_is_reported() {
        let package = Package {
            name: "bare".to_owned(),
            folder: PathBuf::from("/w/crates/bare"),
            roots: Vec::new(),
            has_library: true,
            members: Vec::new(),
            published: true,
            manifest: json!({"description": "Does", "license": "MIT", "readme": null, "keywords": [],
                             "categories": ["science"]}),
        };
        let faults = missing_fields(&package);
        assert_eq!(faults.len(), 2, "{faults:?}");
        assert!(faults[0].contains("`readme`") && faults[1].contains("`keywords`"));
    }

    #[test]
    fn an_embedded_file_outside_the_archive_is_reported() {
        let code = "// include_str!(\"comment\")\nA: include_bytes!(\"../models/a.blob\"); (include_str!(\"b.json\"))";
        let needed: Vec<String> = embedded(code).iter().map(|path| normal(Path::new("src"), path)).collect();
        assert_eq!(needed, ["models/a.blob", "src/b.json"]);
        let faults = missing_files("x", &needed, &["src/b.json".to_owned()]);
        assert_eq!(faults, ["x: models/a.blob is not in the archive"]);
    }
}
