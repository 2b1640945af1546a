//! Share of the core's entry points with a runnable example in their documentation.

use super::entry_points::{self, EntryPoint};
use super::sources::{Tree, place};
use crate::report::{Check, Target};
use std::path::Path;
use syn::{Attribute, Expr, Lit, Meta};

/// The library whose entry points need an example.
const CORE: &str = "meniscus";

/// Entry points with an example over all entry points; the others are listed.
pub(super) fn check(root: &Path, trees: &[Tree<'_>]) -> Check {
    let core = trees.iter().filter(|tree| tree.package == CORE);
    let all: Vec<EntryPoint<'_>> = core.flat_map(entry_points::of).collect();
    let without: Vec<&EntryPoint<'_>> = all.iter().filter(|entry| !has_example(entry)).collect();
    let line = |entry: &&EntryPoint<'_>| format!("{}: {}", place(root, entry.source, entry.span), entry.name);
    Check {
        name: "rustdoc_examples",
        value: (all.len() - without.len()) as f64 / all.len().max(1) as f64,
        unit: "of entry points",
        target: Target::AtLeast(1.0),
        offenders: without.iter().map(line).collect(),
    }
}

fn has_example(entry: &EntryPoint<'_>) -> bool {
    entry.docs.iter().any(|attributes| runs(&text(attributes)))
}

/// Doc comment of an item.
fn text(attributes: &[Attribute]) -> String {
    let line = |attribute: &Attribute| match &attribute.meta {
        Meta::NameValue(it) if it.path.is_ident("doc") => match &it.value {
            Expr::Lit(it) => match &it.lit {
                Lit::Str(text) => Some(text.value()),
                _ => None,
            },
            _ => None,
        },
        _ => None,
    };
    attributes.iter().filter_map(line).collect::<Vec<_>>().join("\n")
}

/// Words of a code block that rustdoc compiles and runs.
const RUN: [&str; 4] = ["", "rust", "should_panic", "standalone_crate"];

/// Whether a doc comment has a code block that rustdoc compiles and runs.
fn runs(doc: &str) -> bool {
    let mut open = false;
    for line in doc.lines() {
        let Some(words) = line.trim().strip_prefix("```") else { continue };
        let rust = words.split(',').all(|word| RUN.contains(&word.trim()));
        if !open && rust {
            return true;
        }
        open = !open;
    }
    false
}

#[cfg(test)]
mod tests {
    use super::super::sources::fixture;
    use super::*;

    #[test]
    fn only_code_that_runs_is_an_example() {
        assert!(runs("Text.\n\n ```\n f();\n ```"));
        assert!(runs("```text\nx\n```\n\n```rust\nf();\n```"));
        assert!(runs("```standalone_crate\nf();\n```"));
        assert!(!runs("```text\n```\n```ignore\nf();\n```\n```no_run\nf();\n```"));
        assert!(!runs("no code"));
    }

    #[test]
    fn an_entry_point_without_example_is_reported() {
        let sources = fixture::sources(&[
            ("lib.rs", "pub mod a;"),
            (
                "a.rs",
                "/// Shown.\n/// ```\n/// f();\n/// ```\npub fn shown() {}\n\npub fn bare() {}\n\
                 pub struct S; impl S { /// ```\n/// S::new();\n/// ```\n pub fn new() -> Self { S } }",
            ),
        ]);
        let mut tree = fixture::tree(&sources);
        tree.package = CORE;
        let check = check(Path::new("/w"), &[tree]);
        assert_eq!(check.offenders, ["src/a.rs:7: a::bare"]);
        assert!((check.value - 2.0 / 3.0).abs() < 1e-12 && !check.ok());
    }
}
