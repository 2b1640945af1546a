//! Which files of a crate import which: `use` declarations and paths that begin with `crate`, `super` or `self`.
//!
//! A path is followed to the file that defines the item: through the modules, and through re-exports. A re-export by
//! itself (`pub use`) is no import, and neither is the use of a module by the one that declares it: a folder is one
//! thing, whose `mod.rs` may call its files and hold what they share. Tests are left out.

use super::sources::{Source, Tree, is_test};
use std::collections::{BTreeMap, BTreeSet};
use syn::visit::{self, Visit};
use syn::{Item, UseTree, Visibility};

/// Re-exports of re-exports that are followed; more is a circle.
const DEPTH: usize = 16;

/// Module path of a file.
pub(super) type Module = Vec<String>;

/// Imports of each file of a crate, by module path, without those of itself and of the modules below it.
pub(super) fn edges(tree: &Tree<'_>) -> BTreeMap<Module, BTreeSet<Module>> {
    let resolver = Resolver::new(tree);
    let imports = |(module, source): (&Module, &&Source)| {
        let mut found = Paths { scope: module.clone(), paths: Vec::new() };
        found.visit_file(&source.syntax);
        let mut targets: BTreeSet<Module> =
            found.paths.into_iter().filter_map(|path| Some(resolver.definition(&path)?.module)).collect();
        targets.retain(|target| !target.starts_with(module));
        (module.clone(), targets)
    };
    tree.modules.iter().map(imports).collect()
}

/// Names that a file makes reachable below its module.
#[derive(Default)]
struct Names {
    /// Items that stand in it.
    items: BTreeSet<String>,
    /// Names by `use`, with the absolute path that each stands for.
    aliases: BTreeMap<String, Vec<String>>,
    /// Absolute paths of its glob imports.
    globs: Vec<Vec<String>>,
}

fn names(module: &Module, source: &Source) -> Names {
    let mut names = Names::default();
    for item in &source.syntax.items {
        let name = match item {
            Item::Use(it) => {
                for leaf in leaves(&it.tree) {
                    add_alias(&mut names, module, leaf);
                }
                continue;
            }
            Item::Macro(it) => {
                names.items.extend(it.ident.iter().map(ToString::to_string));
                continue;
            }
            Item::Const(it) => &it.ident,
            Item::Enum(it) => &it.ident,
            Item::Fn(it) => &it.sig.ident,
            Item::Static(it) => &it.ident,
            Item::Struct(it) => &it.ident,
            Item::Trait(it) => &it.ident,
            Item::Type(it) => &it.ident,
            Item::Union(it) => &it.ident,
            Item::Mod(it) if it.content.is_some() => &it.ident,
            _ => continue,
        };
        names.items.insert(name.to_string());
    }
    names
}

fn add_alias(names: &mut Names, module: &Module, leaf: Leaf) {
    // `use child::Item` begins with a module of this file as much as `use self::child::Item`.
    let relative = || module.iter().cloned().chain(leaf.path.iter().cloned()).collect();
    let path = absolute(module, &leaf.path).unwrap_or_else(relative);
    match leaf.name {
        Some(name) => drop(names.aliases.insert(name, path)),
        None => names.globs.push(path),
    }
}

/// One name that a `use` declares; a glob has none.
pub(super) struct Leaf {
    pub(super) path: Vec<String>,
    pub(super) name: Option<String>,
}

/// The names of a `use` declaration, groups taken apart.
pub(super) fn leaves(tree: &UseTree) -> Vec<Leaf> {
    match tree {
        UseTree::Path(it) => {
            let mut below = leaves(&it.tree);
            for leaf in &mut below {
                leaf.path.insert(0, it.ident.to_string());
                if leaf.name.as_ref().is_some_and(String::is_empty) {
                    leaf.name = Some(it.ident.to_string());
                }
            }
            below
        }
        // `y::{self}` declares `y`, the name that stands before the brackets.
        UseTree::Name(it) if it.ident == "self" => vec![Leaf { path: Vec::new(), name: Some(String::new()) }],
        UseTree::Name(it) => {
            vec![Leaf { path: vec![it.ident.to_string()], name: Some(it.ident.to_string()) }]
        }
        UseTree::Rename(it) => {
            vec![Leaf { path: vec![it.ident.to_string()], name: Some(it.rename.to_string()) }]
        }
        UseTree::Glob(_) => vec![Leaf { path: Vec::new(), name: None }],
        UseTree::Group(it) => it.items.iter().flat_map(leaves).collect(),
    }
}

/// The path from the crate's root of one that begins with `crate`, `self` or `super` in `module`.
fn absolute(module: &Module, path: &[String]) -> Option<Vec<String>> {
    let (first, mut rest) = path.split_first()?;
    let mut base = match first.as_str() {
        "crate" => Vec::new(),
        "self" => module.clone(),
        "super" => module.split_last()?.1.to_vec(),
        _ => return None,
    };
    while let Some((next, after)) = rest.split_first() {
        if next != "super" {
            break;
        }
        base.pop();
        rest = after;
    }
    base.extend(rest.iter().cloned());
    Some(base)
}

/// Where an item stands.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Definition {
    /// Module path of the file.
    pub(super) module: Module,
    /// Name in it; none where the path names the module itself.
    pub(super) item: Option<String>,
}

/// The names of all files of a crate.
pub(super) struct Resolver<'a> {
    names: BTreeMap<&'a Module, Names>,
}

impl<'a> Resolver<'a> {
    /// Reads the names of a crate.
    pub(super) fn new(tree: &'a Tree<'_>) -> Self {
        Self { names: tree.modules.iter().map(|(module, source)| (module, names(module, source))).collect() }
    }

    /// The place where the item of an absolute path is defined.
    pub(super) fn definition(&self, path: &[String]) -> Option<Definition> {
        self.follow(path, DEPTH)
    }

    fn follow(&self, path: &[String], depth: usize) -> Option<Definition> {
        let depth = depth.checked_sub(1)?;
        // The longest prefix that is a file; what is left names an item of it.
        let length = (0..=path.len()).rev().find(|&n| self.names.contains_key(&path[..n].to_vec()))?;
        let module: Module = path[..length].to_vec();
        let names = self.names.get(&module)?;
        let Some(item) = path.get(length) else { return Some(Definition { module, item: None }) };
        let here = Definition { module, item: Some(item.clone()) };
        if names.items.contains(item) {
            return Some(here);
        }
        if let Some(target) = names.aliases.get(item) {
            let further: Vec<String> = target.iter().chain(&path[length + 1..]).cloned().collect();
            // What leaves the crate (`use std::fmt`) leads back here and ends.
            return if further == path { Some(here) } else { self.follow(&further, depth).or(Some(here)) };
        }
        let by_glob = names.globs.iter().find_map(|glob| {
            let further: Vec<String> = glob.iter().cloned().chain([item.clone()]).collect();
            self.follow(&further, depth).filter(|found| self.has(found))
        });
        by_glob.or(Some(here))
    }

    /// Whether the file is sure to have the item.
    fn has(&self, found: &Definition) -> bool {
        let names = self.names.get(&found.module);
        found.item.as_ref().is_none_or(|item| names.is_some_and(|names| names.items.contains(item)))
    }
}

/// Paths in a file that begin with `crate`, `super` or `self`, made absolute.
struct Paths {
    scope: Module,
    paths: Vec<Vec<String>>,
}

impl Paths {
    fn add(&mut self, path: &[String]) {
        if path.len() > 1 {
            self.paths.extend(absolute(&self.scope, path));
        }
    }
}

impl<'ast> Visit<'ast> for Paths {
    fn visit_item(&mut self, item: &'ast Item) {
        if !is_test(attributes(item)) {
            visit::visit_item(self, item);
        }
    }

    fn visit_item_mod(&mut self, it: &'ast syn::ItemMod) {
        self.scope.push(it.ident.to_string());
        visit::visit_item_mod(self, it);
        self.scope.pop();
    }

    fn visit_item_use(&mut self, it: &'ast syn::ItemUse) {
        if !matches!(it.vis, Visibility::Inherited) {
            return;
        }
        for leaf in leaves(&it.tree) {
            // `use super::*` imports from the file of `super`.
            if leaf.path.len() == 1 && leaf.name.is_none() {
                self.paths.extend(absolute(&self.scope, &leaf.path));
            }
            self.add(&leaf.path);
        }
    }

    fn visit_path(&mut self, it: &'ast syn::Path) {
        let names: Vec<String> = it.segments.iter().map(|segment| segment.ident.to_string()).collect();
        self.add(&names);
        visit::visit_path(self, it);
    }
}

fn attributes(item: &Item) -> &[syn::Attribute] {
    match item {
        Item::Const(it) => &it.attrs,
        Item::Enum(it) => &it.attrs,
        Item::Fn(it) => &it.attrs,
        Item::Impl(it) => &it.attrs,
        Item::Macro(it) => &it.attrs,
        Item::Mod(it) => &it.attrs,
        Item::Static(it) => &it.attrs,
        Item::Struct(it) => &it.attrs,
        Item::Trait(it) => &it.attrs,
        Item::Type(it) => &it.attrs,
        Item::Use(it) => &it.attrs,
        _ => &[],
    }
}

#[cfg(test)]
mod tests {
    use super::super::sources::fixture;
    use super::*;

    /// Imports of a sample crate as `FROM -> TO` lines.
    fn lines(files: &[(&str, &str)]) -> Vec<String> {
        let sources = fixture::sources(files);
        let edges = edges(&fixture::tree(&sources));
        let line = |from: &Module, to: &Module| format!("{} -> {}", from.join("::"), to.join("::"));
        edges.iter().flat_map(|(from, targets)| targets.iter().map(move |to| line(from, to))).collect()
    }

    #[test]
    fn an_import_is_followed_through_a_facade_to_the_file() {
        let files = [
            ("lib.rs", "mod a; mod b;"),
            ("a/mod.rs", "mod inner; pub use inner::{Thing, Other as Renamed}; pub use inner::*;"),
            ("a/inner.rs", "pub struct Thing; pub struct Other; pub fn by_glob() {}"),
            ("b.rs", "use crate::a::Thing; fn f() { let _ = crate::a::by_glob(); }"),
            ("c.rs", "fn f(_: crate::a::Renamed) {}"),
        ];
        assert_eq!(lines(&files), ["b -> a::inner", "c -> a::inner"]);
    }

    #[test]
    fn super_and_self_and_groups_are_resolved() {
        let files = [
            ("a/mod.rs", "pub(crate) fn shared() {} mod x;"),
            ("a/x.rs", "use super::{shared, y::{self, Y}}; use super::super::z::Z;"),
            ("a/y.rs", "pub struct Y;"),
            ("z.rs", "pub struct Z; mod part { use super::Z; }"),
        ];
        assert_eq!(lines(&files), ["a::x -> a", "a::x -> a::y", "a::x -> z"]);
    }

    #[test]
    fn tests_and_reexports_are_no_imports() {
        let files = [
            ("a/mod.rs", "pub use b::B; #[cfg(test)] mod tests { use crate::c::C; }"),
            ("a/b.rs", "pub struct B;"),
            ("c.rs", "pub struct C; #[test] fn t() { crate::a::f(); }"),
        ];
        assert!(lines(&files).is_empty());
    }

    #[test]
    fn a_module_may_use_what_stands_below_it() {
        let files = [
            (
                "a/mod.rs",
                "mod b; use self::b::B; fn f() { crate::a::b::g(); } use std::fmt; pub struct Shared;",
            ),
            ("a/b.rs", "pub struct B; use super::Shared;"),
        ];
        assert_eq!(lines(&files), ["a::b -> a"]);
    }
}
