//! Circles of imports: those that a top folder of a crate takes part in, and those between files.

use super::imports::{Module, edges};
use super::sources::Tree;
use crate::report::Check;
use crate::workspace::shown;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// The two checks; a circle is a strongly connected set of two or more.
pub(super) fn checks(root: &Path, trees: &[Tree<'_>]) -> [Check; 2] {
    let (mut between, mut inside) = (Vec::new(), Vec::new());
    for tree in trees {
        let files = edges(tree);
        // A circle of single files alone is found below.
        let is_folder =
            |name: &String| files.keys().any(|module| module.len() > 1 && module.first() == Some(name));
        let folders = circles(&top_modules(&files)).into_iter().filter(|names| names.iter().any(is_folder));
        between.extend(folders.map(|names| format!("{}: {}", tree.package, names.join(" <-> "))));
        let path = |module: &Module| tree.modules.get(module).map(|source| shown(root, &source.path));
        let line = |modules: Vec<Module>| modules.iter().filter_map(path).collect::<Vec<_>>().join(" <-> ");
        inside.extend(circles(&files).into_iter().map(line));
    }
    [
        Check::count("file_cycles_between_modules", "", 0.0, between),
        Check::count("file_cycles_inside_crates", "", 0.0, inside),
    ]
}

/// The imports between the first segments of the module paths; the root file is in no folder.
fn top_modules(files: &BTreeMap<Module, BTreeSet<Module>>) -> BTreeMap<String, BTreeSet<String>> {
    let mut folders: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for (from, targets) in files {
        let Some(from) = from.first() else { continue };
        let others = targets.iter().filter_map(|to| to.first()).filter(|&to| to != from);
        folders.entry(from.clone()).or_default().extend(others.cloned());
    }
    folders
}

/// Strongly connected sets of at least two nodes: nodes that reach each other.
fn circles<N: Ord + Clone>(edges: &BTreeMap<N, BTreeSet<N>>) -> Vec<Vec<N>> {
    let reach: BTreeMap<&N, BTreeSet<&N>> = edges.keys().map(|node| (node, reachable(edges, node))).collect();
    let mut seen = BTreeSet::new();
    let mut found = Vec::new();
    for (&node, targets) in &reach {
        let back = |other: &&N| reach.get(*other).is_some_and(|from| from.contains(node));
        if !targets.contains(node) || seen.contains(node) {
            continue;
        }
        let circle: Vec<&N> = targets.iter().copied().filter(back).collect();
        seen.extend(circle.iter().copied());
        if circle.len() > 1 {
            found.push(circle.into_iter().cloned().collect());
        }
    }
    found
}

/// Nodes that a path of one or more edges leads to.
fn reachable<'a, N: Ord>(edges: &'a BTreeMap<N, BTreeSet<N>>, from: &N) -> BTreeSet<&'a N> {
    let mut found = BTreeSet::new();
    let mut open: Vec<&N> = edges.get(from).into_iter().flatten().collect();
    while let Some(node) = open.pop() {
        if found.insert(node) {
            open.extend(edges.get(node).into_iter().flatten());
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::super::sources::fixture;
    use super::*;

    #[test]
    fn circles_between_folders_and_between_files_are_reported() {
        let sources = fixture::sources(&[
            ("lib.rs", "mod a; mod b; mod c;"),
            ("a/mod.rs", "mod one; mod two; pub use one::One;"),
            ("a/one.rs", "pub struct One; use super::two::Two;"),
            ("a/two.rs", "pub struct Two; use super::one::One;"),
            ("b.rs", "pub struct B; use crate::a::One;"),
            ("c.rs", "pub struct C; use crate::b::B;"),
        ]);
        let [between, inside] = checks(Path::new("/w"), &[fixture::tree(&sources)]);
        assert!(between.ok(), "{:?}", between.offenders);
        assert_eq!(inside.offenders, ["src/a/one.rs <-> src/a/two.rs"]);

        let sources = fixture::sources(&[
            ("a/mod.rs", "pub mod one;"),
            ("a/one.rs", "pub struct One; use crate::c::C;"),
            ("b.rs", "pub struct B; use crate::a::one::One;"),
            ("c.rs", "pub struct C; fn f(_: crate::b::B) {}"),
        ]);
        let [between, inside] = checks(Path::new("/w"), &[fixture::tree(&sources)]);
        assert_eq!(between.offenders, ["sample: a <-> b <-> c"]);
        assert!(!between.ok());
        assert_eq!(inside.value, 1.0);
    }

    #[test]
    fn folders_may_form_a_circle_where_no_files_do() {
        let sources = fixture::sources(&[
            ("a/low.rs", "pub struct Low;"),
            ("a/high.rs", "use crate::b::B;"),
            ("b.rs", "pub struct B; use crate::a::low::Low;"),
        ]);
        let [between, inside] = checks(Path::new("/w"), &[fixture::tree(&sources)]);
        assert_eq!((between.value, inside.value), (1.0, 0.0));

        let sources =
            fixture::sources(&[("a.rs", "use crate::b::B;"), ("b.rs", "pub struct B; use crate::a::x;")]);
        let [between, inside] = checks(Path::new("/w"), &[fixture::tree(&sources)]);
        assert_eq!((between.value, inside.value), (0.0, 1.0));
    }
}
