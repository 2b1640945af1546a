//! Help texts on a terminal of 80 columns: no line is wider, and no wrapped line holds one short word.

use super::program::Verb;
use crate::report::Check;

const COLUMNS: usize = 80;

/// Longest word that may not stand alone on a line, characters.
const ORPHAN: usize = 12;

/// Lines over 80 columns and orphan lines of the program and all its verbs.
pub(super) fn checks(program: &Verb) -> [Check; 2] {
    let (mut wide, mut orphans) = (Vec::new(), Vec::new());
    visit(program, "", &mut |name, help| {
        let lines: Vec<&str> = help.lines().collect();
        let place = |index: usize| format!("{name} --help:{}: {}", index + 1, lines[index].trim());
        wide.extend((0..lines.len()).filter(|&index| lines[index].chars().count() > COLUMNS).map(place));
        orphans.extend((0..lines.len()).filter(|&index| is_orphan(&lines, index)).map(place));
    });
    [Check::count("help_orphan_lines", "", 0.0, orphans), Check::count("help_lines_over_80", "", 0.0, wide)]
}

fn visit(verb: &Verb, above: &str, see: &mut impl FnMut(&str, &str)) {
    let name = format!("{above}{}", verb.names.first().map_or("", String::as_str));
    see(&name, &verb.help);
    verb.verbs.iter().for_each(|below| visit(below, &format!("{name} "), see));
}

/// Whether a line is one short word that did not fit on the line before, and nothing follows that could fill it.
fn is_orphan(lines: &[&str], index: usize) -> bool {
    let word = lines[index].trim();
    let is_short_word = !word.is_empty() && !word.contains(' ') && word.chars().count() <= ORPHAN;
    let Some(before) = index.checked_sub(1).map(|before| lines[before]) else { return false };
    let wrapped = !before.trim().is_empty() && before.chars().count() + 1 + word.chars().count() > COLUMNS;
    // The next line would have begun here, if it went on with the paragraph.
    let next = lines.get(index + 1).map_or("", |next| next.trim());
    let first = next.split(' ').next().unwrap_or("");
    let ends = next.is_empty() || lines[index].chars().count() + 1 + first.chars().count() <= COLUMNS;
    is_short_word && wrapped && ends
}

#[cfg(test)]
mod tests {
    use super::*;

    fn program(help: &str) -> Verb {
        let run = Verb { names: vec!["run".to_owned()], help: help.to_owned(), ..Verb::default() };
        Verb { names: vec!["meniscus".to_owned()], verbs: vec![run], ..Verb::default() }
    }

    #[test]
    fn a_word_alone_behind_a_full_line_is_an_orphan() {
        let full = "x".repeat(75);
        let help = format!("  {full}\n  liquid\n\n  --flag  {full}\nliquid\n  --next  short\n");
        let [orphans, wide] = checks(&program(&help));
        assert_eq!(orphans.offenders, ["meniscus run --help:2: liquid", "meniscus run --help:5: liquid"]);
        assert_eq!(wide.offenders.len(), 1, "{:?}", wide.offenders);
        assert!(!orphans.ok() && !wide.ok());
    }

    #[test]
    fn short_items_and_long_words_are_none() {
        let full = "x".repeat(75);
        let help = format!("Examples:\n  run\n\n  {full}\n  thirteen-long\n\n  {full}\n  two words\n");
        let [orphans, wide] = checks(&program(&help));
        assert!(orphans.ok() && wide.ok(), "{:?} {:?}", orphans.offenders, wide.offenders);
    }
}
