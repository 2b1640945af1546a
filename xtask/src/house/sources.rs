//! Rust files of the repository, parsed once, and the module trees that they form.

use crate::workspace::{self, Package, shown};
use anyhow::{Context, Result};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A parsed file.
pub(super) struct Source {
    pub(super) path: PathBuf,
    /// Package that it belongs to; none outside the workspace.
    pub(super) package: Option<String>,
    pub(super) text: String,
    pub(super) syntax: syn::File,
}

/// Files below the root file of one library or program, by their module path (`["usb", "uvc"]`).
pub(super) struct Tree<'a> {
    pub(super) package: &'a str,
    pub(super) modules: BTreeMap<Vec<String>, &'a Source>,
}

/// Reads and parses every Rust file of the repository.
pub(super) fn read_all(root: &Path, packages: &[Package]) -> Result<Vec<Source>> {
    let read = |path: PathBuf| {
        let package = workspace::owner(packages, root, &path).map(|package| package.name.clone());
        let text =
            std::fs::read_to_string(&path).with_context(|| format!("{} is not readable", path.display()))?;
        parse(path, package, text)
    };
    workspace::files(root, ".rs")?.into_iter().map(read).collect()
}

pub(super) fn parse(path: PathBuf, package: Option<String>, text: String) -> Result<Source> {
    let syntax = syn::parse_file(&text).with_context(|| format!("{} is no Rust", path.display()))?;
    Ok(Source { path, package, text, syntax })
}

/// The module trees of all libraries and programs. A file belongs to the root whose folder is the deepest around it;
/// files of a package outside all of them (tests, examples) belong to none.
pub(super) fn trees<'a>(packages: &'a [Package], all: &'a [Source]) -> Vec<Tree<'a>> {
    let mut trees = Vec::new();
    for package in packages {
        let mut folders: Vec<&Path> = package.roots.iter().filter_map(|root| root.parent()).collect();
        folders.sort_unstable();
        folders.dedup();
        for &folder in &folders {
            let deepest = |path: &Path| {
                let around = folders.iter().filter(|other| path.starts_with(other));
                around.max_by_key(|other| other.components().count()) == Some(&folder)
            };
            let own = all.iter().filter(|s| s.package.as_ref() == Some(&package.name) && deepest(&s.path));
            let modules =
                own.filter_map(|source| Some((module_path(folder, &source.path)?, source))).collect();
            trees.push(Tree { package: &package.name, modules });
        }
    }
    trees
}

/// Module path of a file below the folder of its root file; the root itself has an empty one.
fn module_path(folder: &Path, file: &Path) -> Option<Vec<String>> {
    let below = file.strip_prefix(folder).ok()?.with_extension("");
    let mut names: Vec<String> = below.iter().map(|name| name.to_string_lossy().into_owned()).collect();
    let root = names.len() == 1 && (names[0] == "lib" || names[0] == "main");
    if root || names.last().is_some_and(|name| name == "mod") {
        names.pop();
    }
    Some(names)
}

/// A place in a file, for a message.
pub(super) fn place(root: &Path, source: &Source, span: proc_macro2::Span) -> String {
    format!("{}:{}", shown(root, &source.path), span.start().line)
}

/// Whether attributes make an item part of tests alone.
pub(super) fn is_test(attributes: &[syn::Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        let path = attribute.path();
        let of_cfg = || matches!(&attribute.meta, syn::Meta::List(list) if list.tokens.to_string() == "test");
        path.is_ident("test") || (path.is_ident("cfg") && of_cfg())
    })
}

#[cfg(test)]
pub(super) mod fixture {
    use super::*;

    /// Parsed files of a crate, whose paths begin at its `src`.
    pub(in crate::house) fn sources(files: &[(&str, &str)]) -> Vec<Source> {
        let one = |&(path, text): &(&str, &str)| {
            parse(PathBuf::from("/w/src").join(path), Some("sample".to_owned()), text.to_owned()).unwrap()
        };
        files.iter().map(one).collect()
    }

    /// The module tree of [`sources`].
    pub(in crate::house) fn tree(sources: &[Source]) -> Tree<'_> {
        let module = |source: &Source| module_path(Path::new("/w/src"), &source.path);
        let modules = sources.iter().filter_map(|source| Some((module(source)?, source)));
        Tree { package: "sample", modules: modules.collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_become_modules() {
        let module = |file: &str| module_path(Path::new("/w/src"), &Path::new("/w/src").join(file)).unwrap();
        assert!(module("lib.rs").is_empty() && module("main.rs").is_empty());
        assert_eq!(module("usb/mod.rs"), ["usb"]);
        assert_eq!(module("usb/uvc/header.rs"), ["usb", "uvc", "header"]);
    }

    #[test]
    fn a_program_in_a_folder_of_its_own_has_its_own_tree() {
        let package = Package {
            name: "sample".to_owned(),
            folder: PathBuf::from("/w"),
            roots: vec![PathBuf::from("/w/src/lib.rs"), PathBuf::from("/w/src/guest/main.rs")],
            has_library: true,
            members: Vec::new(),
            published: true,
            manifest: serde_json::Value::Null,
        };
        let all =
            fixture::sources(&[("lib.rs", ""), ("guest/main.rs", ""), ("guest/x.rs", ""), ("y.rs", "")]);
        let packages = [package];
        let trees = trees(&packages, &all);
        let of = |tree: &Tree<'_>| tree.modules.keys().map(|k| k.join("::")).collect::<Vec<_>>();
        assert_eq!(of(&trees[0]), ["", "y"]);
        assert_eq!(of(&trees[1]), ["", "x"]);
    }

    #[test]
    fn tests_are_recognised() {
        let item: syn::ItemMod = syn::parse_quote!(
            #[cfg(test)]
            mod tests {}
        );
        assert!(is_test(&item.attrs));
        let item: syn::ItemMod = syn::parse_quote!(
            #[cfg(unix)]
            mod system {}
        );
        assert!(!is_test(&item.attrs));
    }
}
