//! Answers of the program as text files: a command behind `$ `, then everything that it says, then its exit status.

use std::fs;
use std::path::{Path, PathBuf};

/// A file of answers.
pub(crate) struct Snapshots {
    path: PathBuf,
    /// Lines before the first command.
    preface: String,
    cases: Vec<Case>,
}

/// A command with its answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Case {
    /// Arguments of `meniscus`, apart by spaces.
    pub(crate) arguments: String,
    pub(crate) answer: String,
}

impl Snapshots {
    /// Reads the file at `path`.
    pub(crate) fn read(path: &Path) -> Self {
        let text = fs::read_to_string(path).unwrap_or_else(|why| panic!("{}: {why}", path.display()));
        let (preface, cases) = parse(&text);
        Self { path: path.into(), preface, cases }
    }

    /// Arguments of the commands, in their order.
    pub(crate) fn arguments(&self) -> impl Iterator<Item = &str> {
        self.cases.iter().map(|case| case.arguments.as_str())
    }

    /// Compares the answers with the file's. `MENISCUS_BLESS=1` writes the file anew instead.
    pub(crate) fn compare(&self, cases: &[Case]) -> Vec<String> {
        if std::env::var_os("MENISCUS_BLESS").is_some() {
            fs::write(&self.path, text(&self.preface, cases)).expect("written");
            return Vec::new();
        }
        differences(&self.cases, cases)
    }
}

/// The preface and the cases of a file.
pub(crate) fn parse(text: &str) -> (String, Vec<Case>) {
    let mut preface = String::new();
    let mut cases: Vec<Case> = Vec::new();
    for line in text.lines() {
        if let Some(arguments) = line.strip_prefix("$ meniscus") {
            cases.push(Case { arguments: arguments.trim().into(), answer: String::new() });
        } else {
            let into = cases.last_mut().map_or(&mut preface, |case| &mut case.answer);
            into.push_str(line);
            into.push('\n');
        }
    }
    for case in &mut cases {
        case.answer = case.answer.trim_end().into();
    }
    (preface, cases)
}

/// The file of these cases.
pub(crate) fn text(preface: &str, cases: &[Case]) -> String {
    let one =
        |case: &Case| format!("{}\n{}\n", format!("$ meniscus {}", case.arguments).trim_end(), case.answer);
    let all: Vec<String> = cases.iter().map(one).collect();
    format!("{}\n\n{}", preface.trim_end(), all.join("\n"))
}

/// Answers that are not the expected ones.
pub(crate) fn differences(expected: &[Case], found: &[Case]) -> Vec<String> {
    let pairs = expected.iter().zip(found).filter(|(expected, found)| expected != found);
    let line = |(expected, found): (&Case, &Case)| {
        format!("`{}`\n  expected: {}\n  answered: {}", found.arguments, expected.answer, found.answer)
    };
    pairs.map(line).collect()
}
