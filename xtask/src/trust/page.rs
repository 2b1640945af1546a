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
const CLASSES: [(&str, &str, &str); 18] = [
    ("bombs", "Container bombs", "Each reader has 256 MiB and 10 s for a file that is made to exhaust them."),
    ("camera", "Camera", "A device that says it is a D435: its descriptors, its answers, its payloads."),
    (
        "databases",
        "SQLite files",
        "A ROS 2 bag is a database with a schema of its own; the same limits as of other containers.",
    ),
    ("datagrams", "Datagrams", "Bytes that are no motion and no plan, where a run listens for either."),
    ("devices", "Devices and pipes", "Files without an end in the place of files, within the same limits."),
    (
        "encryption",
        "Encrypted page",
        "Whoever stands between a browser and `run --view --tls`. Clients: curl, openssl.",
    ),
    ("held_page", "Held page", "Whoever takes the connections and places of the live page, and holds them."),
    ("interrupted", "Interrupted writes", "Full disks, `kill -9`, and writes that end at a chosen byte."),
    ("links", "Links", "Links that somebody has put into a folder that the program writes to."),
    ("models", "Resealed models", "Models whose checksum is right, and what they hold is not."),
    ("motion", "Commanded motion", "Whoever reaches the port of `run --motion udp:`."),
    ("names", "Names", "Names of files that are no text."),
    ("origins", "Browser origins", "Pages of other web sites in the browser of somebody who may watch."),
    ("rivals", "Two at once", "A second program that does the same at the same moment."),
    ("signatures", "Signatures", "Models without the right signature or release, on a board with a key."),
    ("sockets", "Unix socket", "Readers of `run --publish`, and files in the place of its socket."),
    (
        "terminals",
        "Terminals",
        "Sequences that a terminal would carry out, and terminals that carry out none.",
    ),
    ("unit", "Installed service", "The package's script, and the drop-in that opens the unit's sandbox."),
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
    fn a_broken_promise_is_reported_as_broken() {
        let promise = |name: &str| Promise {
            class: "datagrams".into(),
            name: name.into(),
            promise: format!("Promise {name}."),
            attack: "By hand.".into(),
        };
        let outcome =
            |name: &str, passed| Outcome { test: format!("datagrams::{name}"), passed, skipped: false };
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
