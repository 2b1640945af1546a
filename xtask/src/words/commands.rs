//! Commands of the pages: each has its verb and its flags.

use super::markdown::Kind;
use super::pages::Page;
use super::program::Verb;
use crate::report::{Check, Target};

/// Share of the `meniscus` commands in fenced code whose verb and flags exist.
pub(super) fn check(pages: &[Page], program: &Verb) -> Check {
    let (mut all, mut offenders) = (0_usize, Vec::new());
    for page in pages {
        for block in page.blocks.iter().filter(|block| block.kind == Kind::Code("sh".to_owned())) {
            for (offset, command) in commands(&block.text) {
                let Some(words) = words(&command) else { continue };
                all += 1;
                if let Some(fault) = fault(program, &words) {
                    offenders.push(format!("{}: `{}`: {fault}", page.place(block, offset), command.trim()));
                }
            }
        }
    }
    Check {
        name: "docs_commands_that_exist",
        value: all.saturating_sub(offenders.len()) as f64 / all.max(1) as f64,
        unit: "of commands",
        target: Target::AtLeast(1.0),
        offenders,
    }
}

/// Simple commands of a shell text with the offset of their line: continued lines joined, comments left out, split at
/// separators.
fn commands(code: &str) -> Vec<(usize, String)> {
    let (mut all, mut joined, mut begin, mut offset) = (Vec::new(), String::new(), 0, 0);
    for line in code.split_inclusive('\n') {
        let part = line.trim_end();
        if joined.is_empty() {
            begin = offset;
        }
        offset += line.len();
        joined += part.trim_end_matches('\\');
        if !part.ends_with('\\') {
            let whole = std::mem::take(&mut joined);
            let whole = whole.split(" #").next().unwrap_or("");
            let separates = |c| matches!(c, ';' | '|' | '&' | '$' | '(' | ')');
            all.extend(whole.split(separates).map(|part| (begin, part.to_owned())));
        }
    }
    all
}

/// Words behind `meniscus`, behind `cargo run ... --` too. None for another program.
fn words(command: &str) -> Option<Vec<&str>> {
    let is_assignment = |word: &&str| word.contains('=') && !word.starts_with('-');
    let mut words = command.split_whitespace().skip_while(is_assignment);
    let first = words.next()?;
    if first == "meniscus" || first.ends_with("/meniscus") {
        return Some(words.collect());
    }
    let runs = first == "cargo" && words.next() == Some("run") && !command.contains(" --example ");
    runs.then(|| words.skip_while(|word| *word != "--").skip(1).collect())
}

/// Reason why the program does not know a command, if it does not.
fn fault(program: &Verb, words: &[&str]) -> Option<String> {
    let mut verb = program;
    let mut depth = 0;
    for word in words.iter().take_while(|word| !word.starts_with('-')) {
        match verb.below(word) {
            Some(below) => verb = below,
            // A value, where the verb is complete.
            None if depth > 0 => break,
            None => return Some(format!("there is no verb '{word}'")),
        }
        depth += 1;
    }
    let flags = words[depth..].iter().filter(|word| is_flag(word));
    let mut names = flags.map(|word| word.split('=').next().unwrap_or(word));
    let unknown = names.find(|name| !verb.flags.iter().any(|flag| flag == name))?;
    Some(format!("'{}' has no {unknown}", words[..depth].join(" ")))
}

/// A dash and a letter, or two dashes and a letter; not `-`, `--` or a negative number.
fn is_flag(word: &str) -> bool {
    let name = word.strip_prefix("--").or_else(|| word.strip_prefix('-'));
    name.is_some_and(|name| name.starts_with(|c: char| c.is_ascii_alphabetic()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn verb(name: &str, flags: &[&str], verbs: Vec<Verb>) -> Verb {
        let flags = flags.iter().map(|&flag| flag.to_owned()).collect();
        Verb { names: vec![name.to_owned()], flags, verbs, ..Verb::default() }
    }

    fn program() -> Verb {
        let study = verb("study", &["--scenes", "--json"], Vec::new());
        let camera = verb("camera", &[], vec![study]);
        verb("meniscus", &["--version"], vec![camera, verb("run", &["--view", "--seconds"], Vec::new())])
    }

    #[test]
    fn unknown_verbs_and_flags_are_faults() {
        let of = |command: &str| fault(&program(), &words(command).unwrap());
        assert_eq!(of("meniscus run --view --seconds=-3"), None);
        assert_eq!(of("X=1 target/release/meniscus camera study --scenes -4"), None);
        assert_eq!(of("cargo run --release -- run file --view"), None);
        assert_eq!(of("meniscus --version"), None);
        assert_eq!(of("meniscus rnu").unwrap(), "there is no verb 'rnu'");
        assert_eq!(of("meniscus run --vieew").unwrap(), "'run' has no --vieew");
        assert_eq!(of("meniscus camera --json").unwrap(), "'camera' has no --json");
        assert_eq!(words("cargo run --example see -- a"), None);
        assert_eq!(words("hil/run gate"), None);
    }

    #[test]
    fn the_share_of_good_commands_is_measured_and_the_others_are_listed() {
        let text = "# T\n\n```sh\ncd x && meniscus run --view \\\n  --seconds 3   # --no\nmeniscus run | meniscus walk\n```\n\
                    ```text\nmeniscus none\n```\n";
        let check = check(&[Page::new("docs/a.md", text)], &program());
        assert!((check.value - 2.0 / 3.0).abs() < 1e-12 && !check.ok());
        assert_eq!(check.offenders, ["docs/a.md:6: `meniscus walk`: there is no verb 'walk'"]);
    }
}
