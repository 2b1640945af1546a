//! The book of `docs/`: its table of contents has every page once, and no page needs a file outside.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Component, Path, PathBuf};

fn docs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs")
}

/// Pages below `folder`, relative to docs/. Logs of the nightly run are none, nor is the table of contents.
fn pages(folder: &Path) -> Vec<PathBuf> {
    let mut pages = Vec::new();
    for path in fs::read_dir(folder).expect("a folder").flatten().map(|entry| entry.path()) {
        if path.is_dir() {
            pages.extend(pages_of(&path));
        } else if path.extension().is_some_and(|ending| ending == "md") && !path.ends_with("SUMMARY.md") {
            pages.push(path.strip_prefix(docs()).expect("below docs/").to_path_buf());
        }
    }
    pages.sort();
    pages
}

fn pages_of(folder: &Path) -> Vec<PathBuf> {
    if folder.ends_with("nightly") { Vec::new() } else { pages(folder) }
}

/// Targets of the links of a text, outside of code, without fragments.
fn links(text: &str) -> Vec<&str> {
    let mut fenced = false;
    let mut targets = Vec::new();
    for line in text.lines() {
        fenced ^= line.trim_start().starts_with("```");
        let ends = line.match_indices("](").map(|(at, _)| &line[at + 2..]);
        let named = ends.filter_map(|rest| rest.split([')', '#']).next()).filter(|target| !target.is_empty());
        targets.extend(named.filter(|_| !fenced));
    }
    targets
}

/// Number of entries of each page in the table of contents `summary`.
fn counts<'a>(summary: &'a str, pages: &'a [PathBuf]) -> BTreeMap<PathBuf, usize> {
    let mut counts: BTreeMap<PathBuf, usize> = pages.iter().map(|page| (page.clone(), 0)).collect();
    for link in links(summary) {
        *counts.entry(PathBuf::from(link)).or_default() += 1;
    }
    counts
}

#[test]
fn the_table_of_contents_has_every_page_once() {
    let summary = fs::read_to_string(docs().join("SUMMARY.md")).expect("docs/SUMMARY.md");
    let pages = pages(&docs());
    assert!(pages.len() > 15, "{pages:?}");
    for (page, count) in counts(&summary, &pages) {
        assert!(docs().join(&page).is_file(), "docs/SUMMARY.md names {}, which is not there", page.display());
        assert_eq!(count, 1, "{} stands {count} times in docs/SUMMARY.md", page.display());
    }
}

#[test]
fn no_page_links_to_a_file_outside_of_docs() {
    for page in pages(&docs()) {
        let text = fs::read_to_string(docs().join(&page)).expect("a page");
        let folder = page.parent().expect("a folder");
        for link in links(&text).into_iter().filter(|link| !link.contains("://")) {
            assert!(
                !leaves(&folder.join(link)),
                "{}: {link} is not in the book: name the file as code",
                page.display()
            );
        }
    }
}

/// Whether a relative path leads above its beginning.
fn leaves(path: &Path) -> bool {
    let mut depth = 0_i32;
    path.components().any(|component| {
        depth += if component == Component::ParentDir { -1 } else { 1 };
        depth < 0
    })
}

#[test]
fn missing_and_double_entries_and_links_outside_are_found() {
    let pages = ["a.md", "b/README.md"].map(PathBuf::from);
    let counts = counts("- [A](a.md)\n- [A](a.md#x)\n```\n[C](c.md)\n```\n- [D](d.md)\n", &pages);
    let of = |page: &str| counts.get(Path::new(page)).copied();
    assert_eq!([of("a.md"), of("b/README.md"), of("c.md"), of("d.md")], [Some(2), Some(0), None, Some(1)]);
    assert!(leaves(Path::new("hil/../../SECURITY.md")) && !leaves(Path::new("hil/../limits.md")));
}
