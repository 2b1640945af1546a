//! Length of the README, its numbers, and how soon a reader meets the first command and the status.

use super::markdown::{Block, Kind};
use super::pages::Page;
use super::sentences::words;
use crate::report::{Check, Target};

const MOST_WORDS: f64 = 900.0;
const MOST_NUMBERS_PER_100: f64 = 2.0;
const COMMAND_WITHIN: f64 = 120.0;
const STATUS_WITHIN: f64 = 80.0;

/// The measures of the README. Words of tables, code and pictures do not count.
pub(super) fn checks(readme: &Page) -> [Check; 4] {
    let all = counted(&readme.blocks);
    let numbers: usize = prose(&readme.blocks).map(|block| numbers(&block.text)).sum();
    let at = |found: Option<usize>| found.map_or(all, |block| counted(&readme.blocks[..block]) + 1) as f64;
    let command = readme.blocks.iter().position(|block| matches!(block.kind, Kind::Code(_)));
    let status = readme.blocks.iter().position(|block| is_prose(block) && block.text.starts_with("Status"));
    let missing = |what: &str, found: Option<usize>| match found {
        Some(block) => vec![readme.place(&readme.blocks[block], 0)],
        None => vec![format!("{}: no {what}", readme.path)],
    };
    let check = |name, value, unit, most, offenders| Check {
        name,
        value,
        unit,
        target: Target::AtMost(most),
        offenders,
    };
    let per_100 = numbers as f64 * 100.0 / all.max(1) as f64;
    [
        check("readme_words", all as f64, "words", MOST_WORDS, Vec::new()),
        check("readme_numbers_per_100_words", per_100, "", MOST_NUMBERS_PER_100, Vec::new()),
        check("first_command_word", at(command), "", COMMAND_WITHIN, missing("command", command)),
        check(
            "readme_status_word",
            at(status),
            "",
            STATUS_WITHIN,
            missing("line that begins with Status", status),
        ),
    ]
}

fn is_prose(block: &Block) -> bool {
    matches!(block.kind, Kind::Prose | Kind::Heading)
}

fn prose(blocks: &[Block]) -> impl Iterator<Item = &Block> {
    blocks.iter().filter(|block| is_prose(block))
}

fn counted(blocks: &[Block]) -> usize {
    prose(blocks).map(|block| words(&block.text)).sum()
}

/// Words that begin with a digit, a sign or a bracket before it left out: `2.4`, `(10`, `640x480`, not `D435`.
fn numbers(text: &str) -> usize {
    let number = |word: &&str| {
        word.trim_start_matches(|c: char| !c.is_alphanumeric()).starts_with(|c: char| c.is_ascii_digit())
    };
    text.split_whitespace().filter(number).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> [Check; 4] {
        checks(&Page::new("README.md", text))
    }

    #[test]
    fn a_short_page_meets_all_targets() {
        let page = "# Name\n\nOne thing.\n\n**Status**: early.\n\n```sh\ncargo view\n```\n\nIt has `3` parts and 1 more.\n";
        let [words, numbers, command, status] = of(page);
        assert_eq!((words.value, command.value, status.value), (12.0, 6.0, 4.0));
        assert!((numbers.value - 100.0 / 12.0).abs() < 1e-9, "{}", numbers.value);
        assert!(words.ok() && !numbers.ok() && command.ok() && status.ok());
    }

    #[test]
    fn a_long_page_misses_them() {
        let page = format!("# Name\n\n{}\n\nStatus: early.\n\n```sh\ncargo view\n```\n", "word ".repeat(900));
        let [words, numbers, command, status] = of(&page);
        assert!(!words.ok() && numbers.ok() && !command.ok() && !status.ok());
        assert_eq!(status.offenders, ["README.md:5"]);
    }

    #[test]
    fn a_page_without_status_and_command_misses_them() {
        let [.., command, status] = of(&"word ".repeat(130));
        assert!(!command.ok() && !status.ok());
        assert_eq!(status.offenders, ["README.md: no line that begins with Status"]);
    }

    #[test]
    fn names_with_digits_are_no_numbers() {
        assert_eq!(numbers("a D435 on x86-64 at 60 Hz, (2.5 mm), ~3, 640x480, f32"), 4);
    }
}
