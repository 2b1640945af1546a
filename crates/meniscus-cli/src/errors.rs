//! Errors for a person at a terminal: each cause once, with what to do where the system refuses something.

use std::fmt::Write;

/// Messages of the system, each with its remedy.
const REMEDIES: [(&str, &str); 6] = [
    ("No such file or directory (os error 2)", "there is no such file"),
    ("File exists (os error 17)", "a file has the name of this folder; choose another name"),
    ("Is a directory (os error 21)", "it is a folder; name a file"),
    ("Not a directory (os error 20)", "a part of this path is a file, not a folder"),
    (
        "Permission denied (os error 13)",
        "permission denied: choose another place, or change its rights with chmod",
    ),
    ("No space left on device (os error 28)", "its disk is full: make room, or write elsewhere"),
];

/// Returns an error as one line, cause after cause, none of them twice.
pub(super) fn line(error: &anyhow::Error) -> String {
    let mut text = String::new();
    for cause in error.chain() {
        let cause = cause.to_string();
        if text.contains(&cause) {
            continue;
        }
        let colon = if text.is_empty() { "" } else { ": " };
        // A `String` takes every line.
        let _written = write!(text, "{colon}{cause}");
    }
    for (system, person) in REMEDIES {
        text = text.replace(system, person);
    }
    // Numbers of the system say nothing to a person.
    while let Some((before, behind)) = text.split_once(" (os error ") {
        let rest = behind.split_once(')').map_or("", |(_, rest)| rest);
        text = format!("{before}{rest}");
    }
    if text.contains(REMEDIES[0].1)
        && let Ok(folder) = std::env::current_dir()
    {
        text += &format!(" (names count from {})", folder.display());
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use anyhow::{Context, anyhow};
    use meniscus_platform::files::AlignedBytes;
    use std::path::Path;

    #[test]
    fn a_missing_file_is_reported_once_with_where_names_count_from() {
        let missing = AlignedBytes::read(Path::new("nowhere.blob")).expect_err("it is not there");
        let text = line(&anyhow::Error::from(missing).context("the model nowhere.blob is refused"));
        assert_eq!(text.matches("no such file").count(), 1, "{text}");
        assert!(text.contains("cannot read nowhere.blob") && text.contains("names count from /"), "{text}");
        assert!(!text.contains("os error"), "{text}");
    }

    #[test]
    fn a_cause_that_was_given_is_not_repeated() {
        let inner: anyhow::Result<()> = Err(anyhow!("the disk is slow"));
        let error =
            inner.context("cannot write x: the disk is slow").context("cannot save").expect_err("refused");
        assert_eq!(line(&error), "cannot save: cannot write x: the disk is slow");
    }
}
