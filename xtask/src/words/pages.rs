//! Pages of the project that a reader opens: those at the root, docs/, the formats and the models.

use super::markdown::{Block, blocks};
use crate::workspace::{self, shown};
use anyhow::{Context, Result};
use std::path::Path;

/// A Markdown page.
pub(super) struct Page {
    /// Path from the root of the repository.
    pub(super) path: String,
    pub(super) blocks: Vec<Block>,
}

impl Page {
    pub(super) fn new(path: &str, text: &str) -> Self {
        Self { path: path.to_owned(), blocks: blocks(text) }
    }

    /// Place of an offset in a block, for a message.
    pub(super) fn place(&self, block: &Block, offset: usize) -> String {
        format!("{}:{}", self.path, block.line(offset))
    }
}

/// Reads the pages. README.md is the first.
pub(super) fn read(root: &Path) -> Result<Vec<Page>> {
    let mut paths: Vec<String> =
        workspace::files(root, ".md")?.iter().map(|path| shown(root, path)).collect();
    paths.retain(|path| is_page(path));
    paths.sort_unstable_by_key(|path| (path != "README.md", path.clone()));
    let page = |path: &String| {
        let text = std::fs::read_to_string(root.join(path)).with_context(|| format!("cannot read {path}"))?;
        Ok(Page::new(path, &text))
    };
    paths.iter().map(page).collect()
}

/// Pages outside docs/.
const OTHERS: [&str; 7] = [
    "README.md",
    "ARCHITECTURE.md",
    "CONTRIBUTING.md",
    "SECURITY.md",
    "RELEASE-CHECKLIST.md",
    "firmware-config/SPEC.md",
    "models/README.md",
];

/// Whether a path is that of a page. Logs of `cargo xtask nightly` and the table of contents of the book are none.
fn is_page(path: &str) -> bool {
    let is_other = path.starts_with("docs/nightly/") || path == "docs/SUMMARY.md";
    OTHERS.contains(&path) || (path.starts_with("docs/") && !is_other)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logs_and_notes_of_crates_are_no_pages() {
        assert!(is_page("README.md") && is_page("ARCHITECTURE.md") && is_page("docs/hil/README.md"));
        assert!(!is_page("docs/nightly/2026-01-01.md") && !is_page("hil/README.md"));
        assert!(is_page("models/README.md") && is_page("firmware-config/SPEC.md"));
        assert!(is_page("SECURITY.md") && !is_page("docs/SUMMARY.md") && !is_page("CHANGELOG.md"));
    }

    #[test]
    fn a_place_is_the_path_and_the_line() {
        let page = Page::new("docs/a.md", "# Title\n\ntext\n");
        assert_eq!(page.place(&page.blocks[1], 0), "docs/a.md:3");
    }
}
