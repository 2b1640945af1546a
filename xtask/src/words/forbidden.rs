//! Words of our own (`senses`) in pages, doc comments and the texts of clap attributes.

use super::doc_comments::Commented;
use super::literals::Literal;
use super::markdown::Kind;
use super::pages::Page;
use super::senses::FORBIDDEN;
use crate::report::Check;

/// The hidden alias of `meniscus insert` may be named at this many places.
const ALIAS_PLACES: usize = 1;

/// Finds the words; `literals` are the strings of clap attributes.
pub(super) fn check(pages: &[Page], files: &[Commented], literals: &[Literal]) -> Check {
    let mut found = Found::default();
    for page in pages {
        for block in page.blocks.iter().filter(|block| !matches!(block.kind, Kind::Code(_))) {
            found.search(&block.text, |offset| page.place(block, offset));
        }
    }
    for file in files {
        for comment in &file.comments {
            for block in comment.blocks() {
                found.search(&block.text, |offset| format!("{}:{}", file.path, comment.line(&block, offset)));
            }
        }
    }
    for literal in literals {
        found.search(&literal.text, |_| literal.place.clone());
    }
    Check::count("forbidden_words", "", 0.0, found.offenders)
}

#[derive(Default)]
struct Found {
    offenders: Vec<String>,
    aliases: usize,
}

impl Found {
    fn search(&mut self, text: &str, place: impl Fn(usize) -> String) {
        for sense in FORBIDDEN.iter() {
            for hit in sense.pattern.find_iter(text) {
                let is_alias = hit.as_str() == "adopt" && (text == "adopt" || text.contains("alias"));
                self.aliases += usize::from(is_alias);
                if !is_alias || self.aliases > ALIAS_PLACES {
                    self.offenders.push(format!(
                        "{}: `{}`: {}",
                        place(hit.start()),
                        hit.as_str(),
                        sense.instead
                    ));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::doc_comments::comments;
    use super::*;

    #[test]
    fn words_are_found_in_pages_comments_and_literals() {
        let page = Page::new(
            "docs/a.md",
            "# Sealed\n\nIt was `sealed`,\nand 3 % of the\nslosh.\n\n```sh\nsealed\n```\n",
        );
        let code = "/// What was\n/// foretold.\nfn sealed() {}\n// sealed\n";
        let file = Commented { path: "src/a.rs".to_owned(), comments: comments(code) };
        let literal = Literal { place: "src/b.rs:7".to_owned(), text: "thick liquids".to_owned() };
        let check = check(&[page], &[file], &[literal]);
        let starts = [
            "docs/a.md:1: `Sealed`",
            "docs/a.md:4: `% of the slosh`",
            "src/a.rs:2: `foretold`",
            "src/b.rs:7: `thick",
        ];
        assert_eq!(check.offenders.len(), starts.len(), "{:?}", check.offenders);
        for (offender, start) in check.offenders.iter().zip(starts) {
            assert!(offender.starts_with(start), "{offender}");
        }
        assert!(!check.ok());
    }

    #[test]
    fn the_alias_is_named_once() {
        let text = |n: usize| "The alias adopt is kept.\n\n".repeat(n);
        assert!(check(&[Page::new("a.md", &text(1))], &[], &[]).ok());
        assert!(!check(&[Page::new("a.md", &text(2))], &[], &[]).ok());
        assert!(!check(&[Page::new("a.md", "To adopt an effect.")], &[], &[]).ok());
    }
}
