//! Errors for a person at a terminal: each cause once, with what to do where the system refuses something.

use std::fmt::Write;
use std::io::IsTerminal;

/// Messages of the system, each with its remedy.
const REMEDIES: [(&str, &str); 7] = [
    ("No such file or directory (os error 2)", "there is no such file"),
    ("File exists (os error 17)", "a file has the name of this folder; choose another name"),
    ("Is a directory (os error 21)", "it is a folder; name a file"),
    ("Not a directory (os error 20)", "a part of this path is a file, not a folder"),
    (
        "Permission denied (os error 13)",
        "permission denied: choose another place, or change its rights with chmod",
    ),
    ("No space left on device (os error 28)", "its disk is full: make room, or write elsewhere"),
    ("stream did not contain valid UTF-8", "it is no text file"),
];

/// Messages of parsers, each with what is to be written.
const PARSERS: [(&str, &str); 5] = [
    ("invalid float literal", "write a number, as 2.5"),
    ("invalid digit found in string", "write a whole number, 0 or more"),
    ("number too large to fit in target type", "the number is too large"),
    ("cannot parse integer from empty string", "write a whole number, 0 or more"),
    ("invalid IP address syntax", "write an address in numbers, as 192.168.1.20"),
];

/// Ends the program with clap's message in plain words: help on standard output, a wrong argument with status 2.
pub(super) fn exit(error: &clap::Error) -> ! {
    if !error.use_stderr() {
        error.exit();
    }
    let styled = error.render();
    let text = if std::io::stderr().is_terminal() { styled.ansi().to_string() } else { styled.to_string() };
    eprint!("{}", plain(text));
    std::process::exit(error.exit_code());
}

/// Returns an error as one line, cause after cause, none of them twice.
pub(super) fn line(error: &anyhow::Error) -> String {
    let mut text = String::new();
    for cause in error.chain() {
        let cause = cause.to_string();
        if text.contains(&cause) {
            continue;
        }
        let colon = if text.is_empty() { "" } else { ": " };
        // A name at the end is not repeated at the beginning of its cause.
        let name = text.rsplit(' ').next().unwrap_or_default();
        match cause.strip_prefix(name).filter(|rest| !name.is_empty() && rest.starts_with([',', ':', ' '])) {
            Some(rest) => text += rest,
            // A `String` takes every line.
            None => _ = write!(text, "{colon}{cause}"),
        }
    }
    without_controls(plain(text).trim_end())
}

/// Returns `text` with its control characters spelled out: names of files and liquids may hold sequences that a terminal would
/// carry out. Ends of lines stay.
fn without_controls(text: &str) -> String {
    let spelled = |letter: char| match letter {
        '\n' => String::from(letter),
        _ if letter.is_control() => letter.escape_default().to_string(),
        _ => String::from(letter),
    };
    text.chars().map(spelled).collect()
}

/// Returns a message in plain words: errors of the system and of parsers are replaced.
pub(super) fn plain(mut text: String) -> String {
    for (system, person) in REMEDIES.into_iter().chain(PARSERS) {
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
        text += &format!(" (names count from {}; check the spelling)", folder.display());
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
    fn the_name_of_a_file_is_said_once() {
        let inner: anyhow::Result<()> = Err(anyhow!("a.csv, line 3: '0,nan' is not finite"));
        let error = inner.context("--motion a.csv").expect_err("refused");
        assert_eq!(line(&error), "--motion a.csv, line 3: '0,nan' is not finite");
    }

    #[test]
    fn a_name_reaches_the_terminal_without_its_control_characters() {
        let text = line(&anyhow!("a\u{1b}]0;b\u{7}\u{9b}1m.csv is no table\nline 2"));
        assert_eq!(text, "a\\u{1b}]0;b\\u{7}\\u{9b}1m.csv is no table\nline 2");
    }

    #[test]
    fn parsers_say_what_to_write() {
        let text = plain(String::from("invalid value 'ten' for '--seconds': invalid float literal"));
        assert_eq!(text, "invalid value 'ten' for '--seconds': write a number, as 2.5");
    }

    #[test]
    fn a_cause_that_was_given_is_not_repeated() {
        let inner: anyhow::Result<()> = Err(anyhow!("the disk is slow"));
        let error =
            inner.context("cannot write x: the disk is slow").context("cannot save").expect_err("refused");
        assert_eq!(line(&error), "cannot save: cannot write x: the disk is slow");
    }
}
