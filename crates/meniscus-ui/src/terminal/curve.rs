//! Running curve of one quantity in a terminal.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Color, Stylize};
use ratatui::text::Line;
use ratatui::widgets::{Block, Paragraph, Sparkline};
use std::collections::VecDeque;

/// Newest values of one quantity.
pub(super) struct Curve<'c> {
    pub(super) title: &'static str,
    pub(super) values: &'c VecDeque<u64>,
    pub(super) colour: Color,
    /// Whether the model knows the quantity for this liquid.
    pub(super) known: bool,
}

impl Curve<'_> {
    /// Draws the curve, or that it is not known.
    pub(super) fn draw(&self, frame: &mut Frame<'_>, area: Rect) {
        if !self.known {
            let block = Block::bordered().title(self.title);
            frame.render_widget(Paragraph::new("not known for this liquid").dim().block(block), area);
            return;
        }
        let title = format!("{}{} ", self.title, self.values.back().copied().unwrap_or(0));
        // As many of the newest values as fit between the borders.
        let room = usize::from(area.width.saturating_sub(2));
        let newest = self.values.iter().skip(self.values.len().saturating_sub(room)).copied();
        let scale = format!(" 0 to {} ", newest.clone().max().unwrap_or(0));
        let block = Block::bordered().title(title).title_bottom(Line::from(scale).right_aligned());
        let line = Sparkline::default().block(block).style(self.colour);
        frame.render_widget(line.data(newest), area);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ratatui::Terminal;
    use ratatui::backend::TestBackend;

    /// Returns the characters of a curve of the value 4321.
    fn drawn(known: bool) -> String {
        let values = VecDeque::from([4321]);
        let curve = Curve { title: " heat, uJ ", values: &values, colour: Color::Red, known };
        let mut terminal = Terminal::new(TestBackend::new(40, 4)).expect("a terminal in memory");
        let drawn = terminal.draw(|frame| curve.draw(frame, frame.area())).expect("drawn");
        drawn.buffer.content().iter().map(|cell| cell.symbol()).collect()
    }

    #[test]
    fn a_quantity_that_is_not_known_has_no_number() {
        assert!(drawn(true).contains("heat, uJ 4321"));
        let unknown = drawn(false);
        assert!(unknown.contains("not known") && !unknown.contains("4321"), "{unknown}");
    }
}
