//! `cargo xtask book`: `docs/` as a book with search, and a check that every link in it leads somewhere.

use crate::process::{self, Step};
use crate::workspace::{self, shown};
use anyhow::{Context, Result, bail};
use regex::Regex;
use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::LazyLock;

/// Folder of the built book, as `book.toml` has it.
const BUILT: &str = "target/book";

/// Link or source of a page: the path, then the fragment.
static LINK: LazyLock<Regex> =
    LazyLock::new(|| Regex::new(r##"\b(?:href|src)="([^"#]*)(?:#([^"]*))?""##).expect("a regex"));

/// Name to which a fragment leads.
static NAME: LazyLock<Regex> = LazyLock::new(|| Regex::new(r#"\bid="([^"]+)""#).expect("a regex"));

/// Builds the book and returns whether all of its links lead somewhere.
pub(crate) fn run() -> Result<bool> {
    let root = workspace::root()?;
    let asked = Command::new("mdbook").arg("--version").stdout(Stdio::null()).status();
    if asked.is_err() {
        bail!("mdbook is not installed, which makes the book of docs/: `cargo install mdbook --locked`");
    }
    if !process::timed(&root, &Step::new("book", ["mdbook", "build"]))?.passed {
        return Ok(false);
    }
    let built = root.join(BUILT);
    let dead = dead_links(&built)?;
    dead.iter().for_each(|line| println!("{line}"));
    println!("{}: {} dead links", shown(&root, &built.join("index.html")), dead.len());
    Ok(dead.is_empty())
}

/// Links of the built pages to a file or a heading that is not there.
fn dead_links(built: &Path) -> Result<Vec<String>> {
    let mut dead = Vec::new();
    for page in html_below(built)? {
        let text = read(&page)?;
        for link in LINK.captures_iter(&text) {
            let (path, fragment) = (&link[1], link.get(2).map_or("", |part| part.as_str()));
            if let Some(why) = fault(&page, path, fragment)? {
                dead.push(format!("{}: {path}#{fragment}: {why}", shown(built, &page)));
            }
        }
    }
    dead.sort_unstable();
    dead.dedup();
    Ok(dead)
}

/// Reason why a link of `page` leads nowhere, if it does. Links to other sites are not followed.
fn fault(page: &Path, path: &str, fragment: &str) -> Result<Option<&'static str>> {
    let is_elsewhere = path.contains(':') || path.starts_with("//");
    if is_elsewhere {
        return Ok(None);
    }
    let folder = page.parent().context("a page without a folder")?;
    let target = if path.is_empty() { page.to_owned() } else { folder.join(path) };
    if !target.is_file() {
        return Ok(Some("no such file"));
    }
    let has_names = target.extension().is_some_and(|extension| extension == "html");
    if fragment.is_empty() || !has_names {
        return Ok(None);
    }
    let text = read(&target)?;
    let names: HashSet<&str> =
        NAME.captures_iter(&text).filter_map(|name| Some(name.get(1)?.as_str())).collect();
    Ok((!names.contains(fragment)).then_some("no such heading"))
}

/// Pages of the book, without the one page for printers and the one for wrong addresses: their links are relative to
/// other places.
fn html_below(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut pages = Vec::new();
    let entries = std::fs::read_dir(folder).with_context(|| format!("cannot list {}", folder.display()))?;
    for entry in entries {
        let path = entry?.path();
        let is_page = path.extension().is_some_and(|extension| extension == "html");
        if path.is_dir() {
            pages.extend(html_below(&path)?);
        } else if is_page && !path.ends_with("print.html") && !path.ends_with("404.html") {
            pages.push(path);
        }
    }
    pages.sort_unstable();
    Ok(pages)
}

fn read(path: &Path) -> Result<String> {
    std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_to_missing_files_and_headings_are_found() {
        let folder = std::env::temp_dir().join(format!("xtask-book-{}", std::process::id()));
        std::fs::create_dir_all(folder.join("in")).unwrap();
        std::fs::write(folder.join("a.html"), r#"<h1 id="one"></h1><a href="in/b.html#two">x</a>"#).unwrap();
        let b = r##"<h1 id="two"></h1><a href="../a.html#one"><a href="#two"><img src="no.png">
                    <a href="../a.html#gone"><a href="https://x.y/z">"##;
        std::fs::write(folder.join("in/b.html"), b).unwrap();
        let dead = dead_links(&folder);
        std::fs::remove_dir_all(&folder).unwrap();
        let expected = ["in/b.html: ../a.html#gone: no such heading", "in/b.html: no.png#: no such file"];
        assert_eq!(dead.unwrap(), expected);
    }
}
