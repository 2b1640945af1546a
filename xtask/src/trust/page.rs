//! The page of promises, `docs/trust.md`, made from the tests and their last results.

use super::promises::Promise;
use super::results::{Outcome, passed};
use anyhow::Result;
use std::fmt::Write;
use std::path::Path;
use std::process::Command;

/// The page.
const PAGE: &str = "docs/trust.md";

/// Title of a class, and the words before its table.
const CLASSES: [(&str, &str, &str); 5] = [
    ("bombs", "Files", "Each reader has 256 MiB and 10 s for a file that is made to exhaust them."),
    ("disk", "Surroundings", "Full disks, two runs at once, terminals, names."),
    ("files", "Models and the package", "Keys, releases and links in the folder with the slots of a board."),
    ("motion", "Commanded motion", "Whoever reaches the port of `run --motion udp:`."),
    ("servers", "Servers", "The live page, the Foxglove server and the Unix socket of `run --publish`."),
];

/// Writes the page.
pub(super) fn write(root: &Path, promises: &[Promise], outcomes: &[Outcome]) -> Result<()> {
    let date = Command::new("date").arg("+%F").output()?;
    let date = String::from_utf8_lossy(&date.stdout).trim().to_owned();
    std::fs::write(root.join(PAGE), text(promises, outcomes, &date))?;
    Ok(())
}

/// Returns the promises that the page does not list.
pub(super) fn missing(root: &Path, promises: &[Promise]) -> Result<Vec<String>> {
    let page = std::fs::read_to_string(root.join(PAGE))?;
    let absent = promises.iter().filter(|promise| !page.contains(&row_start(promise)));
    Ok(absent.map(|promise| format!("{PAGE}: {}", promise.test())).collect())
}

/// Begin of the row of a promise.
fn row_start(promise: &Promise) -> String {
    format!("| {} | {} ", promise.promise, promise.attack)
}

/// Returns the page as Markdown.
fn text(promises: &[Promise], outcomes: &[Outcome], date: &str) -> String {
    let kept = promises.iter().filter(|promise| passed(outcomes, &promise.test())).count();
    let all = promises.len();
    let mut page = format!(
        "# Promises and the attacks on them\n\n\
         `cargo xtask trust` attacks each promise and writes this page. A promise without a passed attack is open. Holes\n\
         that are known, and parts without protection, stand in `SECURITY.md`.\n\n\
         Last run: {date}. Kept: {kept} of {all}.\n"
    );
    for (class, title, words) in CLASSES {
        // Writing into a string cannot fail.
        let _ = write!(
            page,
            "\n## {title}\n\n{words}\n\n| promise | attack | test in `tests/attacks/{class}.rs` | last result |\n|---|---|---|---|\n"
        );
        for promise in promises.iter().filter(|promise| promise.class == class) {
            let result = outcomes.iter().find(|outcome| outcome.test == promise.test());
            let result = match result {
                None => "not run",
                Some(Outcome { skipped: true, .. }) => "skipped",
                Some(Outcome { passed: true, .. }) => "kept",
                Some(_) => "**broken**",
            };
            let _ = writeln!(page, "{}| `{}` | {result} |", row_start(promise), promise.name);
        }
    }
    page
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_broken_promise_is_told_as_broken() {
        let promise = |name: &str| Promise {
            class: "files".into(),
            name: name.into(),
            promise: format!("Promise {name}."),
            attack: "By hand.".into(),
        };
        let outcome = |name: &str, passed| Outcome { test: format!("files::{name}"), passed, skipped: false };
        let outcomes = [outcome("good", true), outcome("bad", false)];
        let page = text(&[promise("good"), promise("bad"), promise("new")], &outcomes, "2000-01-01");
        assert!(page.contains("Kept: 1 of 3."), "{page}");
        assert!(page.contains("| Promise good. | By hand. | `good` | kept |"), "{page}");
        assert!(page.contains("| `bad` | **broken** |") && page.contains("| `new` | not run |"), "{page}");
    }

    #[test]
    fn every_class_has_a_title() {
        let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."));
        for promise in super::super::promises::read(root).expect("the tests") {
            assert!(CLASSES.iter().any(|(class, ..)| *class == promise.class), "{}", promise.test());
        }
    }
}
