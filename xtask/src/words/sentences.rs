//! Sentences of the pages and their length in words.

use super::markdown::Kind;
use super::pages::Page;
use crate::report::{Check, Target};
use regex::Regex;
use std::sync::LazyLock;

/// Largest mean, words.
const MOST_MEAN: f64 = 16.0;

/// Longest sentence, words.
const MOST: usize = 40;

/// End of a sentence: the mark, what closes after it, a blank. A lower-case letter behind it goes on.
static END: LazyLock<Regex> = LazyLock::new(|| Regex::new(r#"[.!?][)\]"'”’]*\s+"#).expect("a regex"));

/// Abbreviations whose point ends no sentence.
const ABBREVIATIONS: [&str; 8] = ["e.g.", "i.e.", "etc.", "cf.", "vs.", "approx.", "Fig.", "Eq."];

/// Sentence of a page.
struct Sentence {
    place: String,
    text: String,
    words: usize,
}

/// Mean and longest sentence of the prose of all pages, tables and headings left out.
pub(super) fn checks(pages: &[Page]) -> [Check; 2] {
    let mut all: Vec<Sentence> = pages.iter().flat_map(of_page).collect();
    all.sort_by_key(|sentence| std::cmp::Reverse(sentence.words));
    let sum: usize = all.iter().map(|sentence| sentence.words).sum();
    let longest = all.first().map_or(0, |sentence| sentence.words);
    let too_long = all.iter().filter(|sentence| sentence.words > MOST).map(|sentence| {
        let begin: String = sentence.text.chars().take(60).collect();
        format!("{}: {} words: {begin} ...", sentence.place, sentence.words)
    });
    let too_long: Vec<String> = too_long.collect();
    [
        Check {
            name: "sentence_words_mean",
            value: sum as f64 / all.len().max(1) as f64,
            unit: "words",
            target: Target::AtMost(MOST_MEAN),
            offenders: Vec::new(),
        },
        Check {
            name: "sentence_words_longest",
            value: longest as f64,
            unit: "words",
            target: Target::AtMost(MOST as f64),
            offenders: too_long,
        },
    ]
}

fn of_page(page: &Page) -> Vec<Sentence> {
    let prose = page.blocks.iter().filter(|block| block.kind == Kind::Prose);
    let sentences = prose.flat_map(|block| {
        split(&block.text).into_iter().map(|(offset, text)| Sentence {
            place: page.place(block, offset),
            text: text.to_owned(),
            words: words(text),
        })
    });
    sentences.filter(|sentence| sentence.words > 0).collect()
}

/// The sentences of a text with their offsets.
fn split(text: &str) -> Vec<(usize, &str)> {
    let (mut begin, mut parts) = (0, Vec::new());
    for end in END.find_iter(text) {
        let before = text[..end.start() + 1].rsplit([' ', '(']).next().unwrap_or("");
        let goes_on = text[end.end()..].starts_with(char::is_lowercase);
        if !goes_on && !ABBREVIATIONS.contains(&before) {
            parts.push((begin, text[begin..end.end()].trim_end()));
            begin = end.end();
        }
    }
    parts.push((begin, text[begin..].trim_end()));
    parts
}

/// Number of words: what stands between blanks and has a letter or a digit.
pub(super) fn words(text: &str) -> usize {
    text.split_whitespace().filter(|word| word.contains(char::is_alphanumeric)).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sentences_end_at_marks_and_not_at_abbreviations() {
        let text = "One (two). Three is 2.5 mm, e.g. here - or (cf. Fig. 3) there! \"Four?\" Five";
        let parts: Vec<&str> = split(text).into_iter().map(|(_, part)| part).collect();
        let three = "Three is 2.5 mm, e.g. here - or (cf. Fig. 3) there!";
        assert_eq!(parts, ["One (two).", three, "\"Four?\"", "Five"]);
        assert_eq!(words(three), 11);
    }

    #[test]
    fn a_long_sentence_is_reported_with_its_line() {
        let text =
            format!("# Title\n\nShort.\nA {}end.\n\n| {} |\n|---|\n", "word ".repeat(39), "cell ".repeat(90));
        let [mean, longest] = checks(&[Page::new("docs/a.md", &text)]);
        assert_eq!((mean.value, longest.value), (21.0, 41.0));
        assert!(!mean.ok() && !longest.ok());
        assert!(longest.offenders[0].starts_with("docs/a.md:4: 41 words"), "{:?}", longest.offenders);
    }
}
