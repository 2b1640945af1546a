//! Prose of a Markdown text, block by block, without code, pictures and link targets.

use pulldown_cmark::{CodeBlockKind, Event, Options, Parser, Tag, TagEnd};

/// Word that stands in the prose for a piece of inline code.
const CODE: &str = "`code`";

/// Kind of a block.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Kind {
    /// Paragraph or list item.
    Prose,
    Heading,
    /// Cell of a table.
    Cell,
    /// Code block with its language; its text is the code.
    Code(String),
}

/// Block of a Markdown text.
#[derive(Clone, Debug)]
pub(super) struct Block {
    pub(super) kind: Kind,
    /// Text on one line; inline code is replaced by [`CODE`]. A code block keeps its lines.
    pub(super) text: String,
    /// Offset in `text` and line of the source, for each piece.
    pieces: Vec<(usize, usize)>,
}

impl Block {
    fn new(kind: Kind) -> Self {
        Self { kind, text: String::new(), pieces: Vec::new() }
    }

    fn push(&mut self, text: &str, line: usize) {
        self.pieces.push((self.text.len(), line));
        self.text.push_str(text);
    }

    /// Line of the source, counted from 1, at an offset in the text.
    pub(super) fn line(&self, offset: usize) -> usize {
        let before = self.pieces.iter().take_while(|(begin, _)| *begin <= offset);
        // Only pieces of code have several lines.
        before.last().map_or(1, |(begin, line)| line + self.text[*begin..offset].matches('\n').count())
    }
}

/// Returns the blocks of a Markdown text in their order.
pub(super) fn blocks(text: &str) -> Vec<Block> {
    let line_starts: Vec<usize> = text.match_indices('\n').map(|(at, _)| at + 1).collect();
    let line = |offset: usize| 1 + line_starts.partition_point(|start| *start <= offset);
    let mut reader = Reader { done: Vec::new(), open: Block::new(Kind::Prose), pictures: 0 };
    for (event, range) in Parser::new_ext(text, Options::ENABLE_TABLES).into_offset_iter() {
        reader.event(event, line(range.start));
    }
    reader.begin(Kind::Prose);
    reader.done
}

struct Reader {
    done: Vec<Block>,
    open: Block,
    /// Depth of pictures, whose alternative texts are left out.
    pictures: usize,
}

impl Reader {
    /// Ends the open block and begins another.
    fn begin(&mut self, kind: Kind) {
        let ended = std::mem::replace(&mut self.open, Block::new(kind));
        if !ended.text.trim().is_empty() {
            self.done.push(ended);
        }
    }

    fn event(&mut self, event: Event<'_>, line: usize) {
        match event {
            Event::Start(Tag::Image { .. }) => self.pictures += 1,
            Event::End(TagEnd::Image) => self.pictures -= 1,
            _ if self.pictures > 0 => {}
            Event::Start(tag) => match tag {
                Tag::Heading { .. } => self.begin(Kind::Heading),
                Tag::TableCell => self.begin(Kind::Cell),
                Tag::CodeBlock(CodeBlockKind::Fenced(language)) => {
                    self.begin(Kind::Code(language.to_string()));
                }
                Tag::CodeBlock(CodeBlockKind::Indented) => self.begin(Kind::Code(String::new())),
                Tag::Paragraph | Tag::Item | Tag::List(_) | Tag::BlockQuote(_) => self.begin(Kind::Prose),
                _ => {}
            },
            Event::End(
                TagEnd::Heading(_) | TagEnd::TableCell | TagEnd::CodeBlock | TagEnd::Paragraph | TagEnd::Item,
            ) => self.begin(Kind::Prose),
            Event::Text(text) => self.open.push(&text, line),
            Event::Code(_) => self.open.push(CODE, line),
            Event::SoftBreak | Event::HardBreak => self.open.push(" ", line),
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn code_pictures_and_link_targets_are_no_prose() {
        let text = "# Title\n\n[![badge](a.svg)](b) Some *bold\ntext* and `f(x) = 3`, [a link](target.md).\n\n\
                    - an item\n\n  ```sh\n  meniscus run\n  ```\n\n| a | 7 |\n|---|---|\n| b | 8 |\n";
        let all = blocks(text);
        let of =
            |kind: Kind| all.iter().filter(|b| b.kind == kind).map(|b| b.text.trim()).collect::<Vec<_>>();
        assert_eq!(of(Kind::Heading), ["Title"]);
        assert_eq!(of(Kind::Prose), ["Some bold text and `code`, a link.", "an item"]);
        assert_eq!(of(Kind::Code("sh".to_owned())), ["meniscus run"]);
        assert_eq!(of(Kind::Cell), ["a", "7", "b", "8"]);
    }

    #[test]
    fn an_offset_has_its_line() {
        let all = blocks("# One\n\ntwo\nthree four\n\n- five\n");
        assert_eq!(all[0].line(0), 1);
        assert_eq!((all[1].line(0), all[1].line(all[1].text.find("four").unwrap())), (3, 4));
        assert_eq!(all[2].line(2), 6);
    }
}
