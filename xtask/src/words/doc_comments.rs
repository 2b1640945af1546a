//! Doc comments of the Rust files, and first words that they may not have.
//!
//! They are found line by line, so that those inside of macros count, too.

use super::markdown::{Block, Kind, blocks};
use crate::report::Check;
use crate::workspace::{self, shown};
use anyhow::{Context, Result};
use regex::Regex;
use std::path::Path;
use std::sync::LazyLock;

/// First words that say nothing of the thing.
static EMPTY_START: LazyLock<Regex> =
    LazyLock::new(|| Regex::new(r"^(What|How|Who|By how much|That)\b").expect("a regex"));

/// A file with its doc comments.
pub(super) struct Commented {
    /// Path from the root of the repository.
    pub(super) path: String,
    pub(super) comments: Vec<DocComment>,
}

/// Doc comment: neighbouring lines that begin with `///`, or with `//!`.
pub(super) struct DocComment {
    /// Line of its beginning, counted from 1.
    line: usize,
    text: String,
}

impl DocComment {
    /// Blocks of the comment, whose text is Markdown, without its code blocks.
    pub(super) fn blocks(&self) -> Vec<Block> {
        blocks(&self.text).into_iter().filter(|block| !matches!(block.kind, Kind::Code(_))).collect()
    }

    /// Line of the file at an offset in a block.
    pub(super) fn line(&self, block: &Block, offset: usize) -> usize {
        self.line + block.line(offset) - 1
    }
}

/// Reads the doc comments of all Rust files.
pub(super) fn read(root: &Path) -> Result<Vec<Commented>> {
    let file = |path: &std::path::PathBuf| {
        let text =
            std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
        Ok(Commented { path: shown(root, path), comments: comments(&text) })
    };
    workspace::files(root, ".rs")?.iter().map(file).collect()
}

/// The doc comments of a file.
pub(super) fn comments(text: &str) -> Vec<DocComment> {
    let mut all: Vec<DocComment> = Vec::new();
    let mut last = None;
    for (number, line) in (1..).zip(text.lines()) {
        let line = line.trim_start();
        let mark =
            ["///", "//!"].into_iter().find(|mark| line.starts_with(mark) && !line.starts_with("////"));
        if let Some(mark) = mark {
            if last != Some(mark) {
                all.push(DocComment { line: number, text: String::new() });
            }
            if let Some(comment) = all.last_mut() {
                // rustdoc takes one blank away.
                let rest = &line[mark.len()..];
                comment.text += rest.strip_prefix(' ').unwrap_or(rest);
                comment.text.push('\n');
            }
        }
        last = mark;
    }
    all
}

/// Doc comments whose first line begins with What, How, Who, By how much or That.
pub(super) fn check(files: &[Commented]) -> Check {
    let mut offenders = Vec::new();
    for file in files {
        for comment in &file.comments {
            let first = comment.text.lines().next().unwrap_or("");
            if EMPTY_START.is_match(first) {
                offenders.push(format!("{}:{}: {first}", file.path, comment.line));
            }
        }
    }
    Check::count("doc_lines_starting_with_what_or_how", "", 0.0, offenders)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(text: &str) -> Commented {
        Commented { path: "src/a.rs".to_owned(), comments: comments(text) }
    }

    #[test]
    fn empty_first_words_are_reported_and_later_lines_are_not() {
        let text = "//! How it works.\n\n/// What it is.\nfn a() {}\n/// Height\n/// That is measured.\nfn b() {}\n\
                    macro_rules! m { () => {\n    /// By how much.\n    fn c() {}\n}; }\n/// Whatever.\nfn d() {}\n";
        let check = check(&[file(text)]);
        let at: Vec<&str> = check.offenders.iter().filter_map(|line| line.split(": ").next()).collect();
        assert_eq!(at, ["src/a.rs:1", "src/a.rs:3", "src/a.rs:9"]);
        assert!(!check.ok());
    }

    #[test]
    fn a_comment_is_markdown_whose_lines_are_those_of_the_file() {
        let text = "fn x() {}\n\n/// One\n/// two `three`.\n///\n/// ```\n/// four();\n/// ```\nfn y() {}\n//// none\n";
        let file = file(text);
        assert_eq!(file.comments.len(), 1);
        let comment = &file.comments[0];
        let blocks = comment.blocks();
        assert_eq!(blocks.len(), 1);
        assert_eq!(blocks[0].text, "One two `code`.");
        assert_eq!(comment.line(&blocks[0], blocks[0].text.find("two").unwrap()), 4);
    }
}
