//! The workspace as `cargo metadata` describes it: packages, targets and the dependencies between members.

use crate::process;
use anyhow::{Context, Result};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Package of the workspace.
#[derive(Clone, Debug)]
pub(crate) struct Package {
    /// Name in its manifest.
    pub(crate) name: String,
    /// Folder of its manifest.
    pub(crate) folder: PathBuf,
    /// Root files of its libraries and programs.
    pub(crate) roots: Vec<PathBuf>,
    /// Whether it has a library.
    pub(crate) has_library: bool,
    /// Names of its dependencies of all kinds that are members, too.
    pub(crate) members: Vec<String>,
    /// Whether its manifest allows publication.
    pub(crate) published: bool,
    /// Package table of the manifest, for checks of its fields.
    pub(crate) manifest: Value,
}

/// Folder of the workspace.
pub(crate) fn root() -> Result<PathBuf> {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let parent = here.parent().with_context(|| format!("{} has no parent folder", here.display()))?;
    Ok(parent.to_owned())
}

/// Folder of what cargo builds.
pub(crate) fn target(root: &Path) -> PathBuf {
    std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), |folder| root.join(folder))
}

/// Returns the packages of the workspace in `folder`.
pub(crate) fn packages(folder: &Path) -> Result<Vec<Package>> {
    let cargo = process::cargo();
    let text = process::output(folder, [cargo.as_str(), "metadata", "--no-deps", "--format-version", "1"])?;
    from_json(&serde_json::from_str(&text).context("cargo metadata printed no JSON")?)
}

/// Packages of a `cargo metadata` document.
fn from_json(metadata: &Value) -> Result<Vec<Package>> {
    let all = list(metadata, "packages");
    let names: Vec<&str> = all.iter().filter_map(|package| package["name"].as_str()).collect();
    all.iter().map(|package| package_from(package, &names)).collect()
}

fn package_from(package: &Value, names: &[&str]) -> Result<Package> {
    let name = text(package, "name")?;
    let folder = PathBuf::from(text(package, "manifest_path")?);
    let folder = folder.parent().with_context(|| format!("{name}: manifest without folder"))?.to_owned();
    let is = |target: &Value, kind: &str| list(target, "kind").iter().any(|k| k == kind);
    let targets = list(package, "targets");
    let compiled = targets.iter().filter(|target| is(target, "lib") || is(target, "bin"));
    let roots = compiled.map(|target| text(target, "src_path").map(PathBuf::from)).collect::<Result<_>>()?;
    let dependencies = list(package, "dependencies").iter().filter_map(|d| d["name"].as_str());
    let mut members: Vec<String> = dependencies.filter(|d| names.contains(d)).map(str::to_owned).collect();
    members.sort_unstable();
    members.dedup();
    Ok(Package {
        has_library: targets.iter().any(|target| is(target, "lib")),
        // `publish = false` is an empty list of registries in the metadata.
        published: package["publish"].as_array().is_none_or(|registries| !registries.is_empty()),
        manifest: package.clone(),
        name,
        folder,
        roots,
        members,
    })
}

fn list<'a>(value: &'a Value, key: &str) -> &'a [Value] {
    value[key].as_array().map_or(&[], Vec::as_slice)
}

fn text(value: &Value, key: &str) -> Result<String> {
    Ok(value[key].as_str().with_context(|| format!("cargo metadata has no `{key}`"))?.to_owned())
}

/// Returns the package that owns the file at `path`: the one with the deepest folder. A file of the root folder that is
/// not in `src` belongs to none.
pub(crate) fn owner<'a>(packages: &'a [Package], root: &Path, path: &Path) -> Option<&'a Package> {
    let holds = |package: &&Package| {
        let folder = if package.folder == root { root.join("src") } else { package.folder.clone() };
        path.starts_with(folder)
    };
    packages.iter().filter(holds).max_by_key(|package| package.folder.components().count())
}

/// Returns the tracked and the new files of the repository whose path ends with `suffix`.
pub(crate) fn files(root: &Path, suffix: &str) -> Result<Vec<PathBuf>> {
    let listed = process::output(root, ["git", "ls-files", "--cached", "--others", "--exclude-standard"])?;
    let paths = listed.lines().filter(|path| path.ends_with(suffix)).map(|path| root.join(path));
    // A file that was deleted and not committed is still listed.
    Ok(paths.filter(|path| path.is_file()).collect())
}

/// A path below the repository's folder.
pub(crate) fn shown(root: &Path, path: &Path) -> String {
    path.strip_prefix(root).unwrap_or(path).display().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn metadata_becomes_packages() {
        let metadata = serde_json::json!({"packages": [
            {"name": "a", "manifest_path": "/w/Cargo.toml", "publish": null, "dependencies": [],
             "targets": [{"kind": ["lib"], "src_path": "/w/src/lib.rs"}]},
            {"name": "b", "manifest_path": "/w/crates/b/Cargo.toml", "publish": [],
             "dependencies": [{"name": "a"}, {"name": "elsewhere"}, {"name": "a", "kind": "dev"}],
             "targets": [{"kind": ["bin"], "src_path": "/w/crates/b/src/main.rs"},
                         {"kind": ["test"], "src_path": "/w/crates/b/tests/t.rs"}]},
        ]});
        let packages = from_json(&metadata).unwrap();
        assert_eq!(packages[1].members, ["a"]);
        assert!(packages[0].published && !packages[1].published);
        assert!(packages[0].has_library && !packages[1].has_library);
        assert_eq!(packages[1].roots, [PathBuf::from("/w/crates/b/src/main.rs")]);
        let name = |path: &str| owner(&packages, Path::new("/w"), Path::new(path)).map(|p| p.name.as_str());
        assert_eq!(name("/w/crates/b/src/x.rs"), Some("b"));
        assert_eq!(name("/w/src/x.rs"), Some("a"));
        assert_eq!(name("/w/docs/x.md"), None);
    }

    #[test]
    fn incomplete_metadata_is_an_error() {
        let error = from_json(&serde_json::json!({"packages": [{"name": "a"}]})).unwrap_err().to_string();
        assert!(error.contains("manifest_path"), "{error}");
    }
}
