//! A page with an AprilTag of a stated width, to be printed: SVG in millimetres, with a bar that shows the scale of the print.
//!
//! ```text
//! +--------------------+
//! |    '          '    |   marks to cut along, outside of the white margin
//! |      ##########    |
//! |      ##  ##  ##    |   the tag of the stated width
//! |      ##########    |
//! |    '          '    |
//! |   |-+-+-+-+-+-|    |   100 mm
//! |   text             |
//! +--------------------+
//! ```

use crate::render::{SQUARES, TagPattern};
use std::fmt::Write;

/// Edge of the paper on which printers put no ink, mm.
const UNPRINTED_MM: f64 = 10.0;
/// Length of the bar and of its parts, its height, and the width of its frame, mm.
const BAR_MM: f64 = 100.0;
const PART_MM: f64 = 10.0;
const BAR_HEIGHT_MM: f64 = 3.0;
const FRAME_MM: f64 = 0.3;
/// Length of the marks to cut along, and their distance from the margin, mm.
const MARK_MM: f64 = 3.0;
const MARK_GAP_MM: f64 = 1.0;
/// Height of a line of text, mm.
const LINE_MM: f64 = 5.0;
/// Height of the bar with the text below it and the room above, mm.
const FOOT_MM: f64 = 40.0;
/// Squares on a side without the white margin.
const BLACK_SQUARES: f64 = SQUARES as f64 - 2.0;

/// Size of the paper, upright.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Paper {
    /// 210 mm by 297 mm.
    A4,
    /// 297 mm by 420 mm.
    A3,
    /// 8.5 in by 11 in.
    Letter,
}

impl Paper {
    /// Returns width and height, mm.
    #[must_use]
    pub const fn size_mm(self) -> [f64; 2] {
        match self {
            Self::A4 => [210.0, 297.0],
            Self::A3 => [297.0, 420.0],
            Self::Letter => [215.9, 279.4],
        }
    }

    /// Returns the largest width of a tag's black square that fits with its margin and the bar, mm.
    #[must_use]
    pub fn largest_tag_mm(self) -> f64 {
        let [width, height] = self.size_mm();
        let marks = 2.0 * (UNPRINTED_MM + MARK_MM + MARK_GAP_MM);
        ((width - marks).min(height - marks - FOOT_MM) * BLACK_SQUARES / SQUARES as f64).floor()
    }
}

/// A page with a tag.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TagPage<'t> {
    /// The tag.
    pub pattern: TagPattern,
    /// Width of its black square, mm; at most [`Paper::largest_tag_mm`].
    pub size_mm: f64,
    /// The paper.
    pub paper: Paper,
    /// Lines below the bar, without characters that XML reserves.
    pub text: &'t [&'t str],
}

impl TagPage<'_> {
    /// Returns the page as SVG, one user unit a millimetre.
    #[must_use]
    pub fn svg(&self) -> String {
        let [width, height] = self.paper.size_mm();
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}mm\" height=\"{height}mm\" viewBox=\"0 0 {width} {height}\">\n"
        );
        rectangle(&mut svg, [0.0, 0.0, width, height], "white");
        self.tag(&mut svg);
        self.foot(&mut svg);
        svg + "</svg>\n"
    }

    /// Left and top edge of the white margin, and its width, mm.
    fn outer_mm(&self) -> [f64; 3] {
        let outer = self.size_mm * SQUARES as f64 / BLACK_SQUARES;
        let [width, _] = self.paper.size_mm();
        [0.5 * (width - outer), UNPRINTED_MM + MARK_MM + MARK_GAP_MM, outer]
    }

    /// Draws the black square, the white squares in it, and the marks.
    fn tag(&self, svg: &mut String) {
        let [left, top, outer] = self.outer_mm();
        let square = self.size_mm / BLACK_SQUARES;
        // Without smoothing: seams between white squares would be grey.
        svg.push_str("<g shape-rendering=\"crispEdges\">\n");
        rectangle(svg, [left + square, top + square, self.size_mm, self.size_mm], "black");
        for (row, line) in self.pattern.squares().iter().enumerate().take(SQUARES - 1).skip(1) {
            let mut column = 1;
            while column < SQUARES - 1 {
                let run = line[column..SQUARES - 1].iter().take_while(|white| **white).count();
                if run > 0 {
                    let [x, y] = [column, row].map(|place| square * place as f64);
                    rectangle(svg, [left + x, top + y, square * run as f64, square], "white");
                }
                column += run + 1;
            }
        }
        svg.push_str("</g>\n");
        for x in [left, left + outer] {
            rectangle(svg, [x - 0.05, top - MARK_GAP_MM - MARK_MM, 0.1, MARK_MM], "black");
            rectangle(svg, [x - 0.05, top + outer + MARK_GAP_MM, 0.1, MARK_MM], "black");
        }
        for y in [top, top + outer] {
            rectangle(svg, [left - MARK_GAP_MM - MARK_MM, y - 0.05, MARK_MM, 0.1], "black");
            rectangle(svg, [left + outer + MARK_GAP_MM, y - 0.05, MARK_MM, 0.1], "black");
        }
    }

    /// Draws the bar, whose parts are black and white by turns, and the text.
    fn foot(&self, svg: &mut String) {
        let [width, height] = self.paper.size_mm();
        let (left, top) = (0.5 * (width - BAR_MM), height - UNPRINTED_MM - FOOT_MM + 10.0);
        svg.push_str("<g shape-rendering=\"crispEdges\">\n");
        rectangle(svg, [left, top, BAR_MM, BAR_HEIGHT_MM], "black");
        for part in (1..10).step_by(2) {
            // The black frame closes the last part.
            let width = if part == 9 { PART_MM - FRAME_MM } else { PART_MM };
            let [x, height] = [left + PART_MM * f64::from(part), BAR_HEIGHT_MM - 2.0 * FRAME_MM];
            rectangle(svg, [x, top + FRAME_MM, width, height], "white");
        }
        svg.push_str("</g>\n<g font-family=\"sans-serif\" font-size=\"3.5\" text-anchor=\"middle\">\n");
        for (line, text) in self.text.iter().enumerate() {
            let y = top + BAR_HEIGHT_MM + LINE_MM * (line + 1) as f64;
            // A `String` takes every line.
            let _written = writeln!(svg, "<text x=\"{:.4}\" y=\"{y:.4}\">{text}</text>", 0.5 * width);
        }
        svg.push_str("</g>\n");
    }
}

/// Appends a rectangle: left, top, width, height.
fn rectangle(svg: &mut String, [x, y, width, height]: [f64; 4], fill: &str) {
    let _written = writeln!(
        svg,
        "<rect x=\"{x:.4}\" y=\"{y:.4}\" width=\"{width:.4}\" height=\"{height:.4}\" fill=\"{fill}\"/>"
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_tag_of_each_paper_stays_clear_of_its_edges_and_the_bar() {
        for (paper, largest_mm) in [(Paper::A4, 145.0), (Paper::A3, 215.0), (Paper::Letter, 150.0)] {
            assert_eq!(paper.largest_tag_mm(), largest_mm, "{paper:?}");
            let pattern = TagPattern::of(0).expect("a pattern");
            let [width, height] = paper.size_mm();
            let page = TagPage { pattern, size_mm: largest_mm, paper, text: &[] };
            let [left, top, outer] = page.outer_mm();
            let marks = MARK_GAP_MM + MARK_MM;
            assert!(left - marks >= UNPRINTED_MM && left + outer + marks <= width - UNPRINTED_MM);
            assert!(top + outer + marks <= height - UNPRINTED_MM - FOOT_MM);
        }
    }
}
