//! Figures of a turn in a terminal, the most important first.

use crate::wrapped::wrapped;
use meniscus::blob::{FieldGroup, KnownGroups};
use meniscus::latent::generic::StepOutcome;
use meniscus::runtime::DEADLINE_US;
use meniscus_service::timed_turn::TimedTurn;
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Stylize;
use ratatui::text::Line;
use ratatui::widgets::{Block, Paragraph};

/// Columns that the figures need, borders included.
pub(super) const COLUMNS: u16 = 32;

/// Figures of the newest turn.
#[derive(Clone, Copy, Debug)]
pub(super) struct Numbers<'n> {
    pub(super) last: Option<&'n TimedTurn>,
    pub(super) known: KnownGroups,
    /// Joules of a unit of the books of a step.
    pub(super) energy_scale_j: f64,
}

impl Numbers<'_> {
    /// Draws as many lines as there is room for, and says how many are missing.
    pub(super) fn draw(&self, frame: &mut Frame<'_>, area: Rect) {
        let lines =
            self.last.map_or_else(|| vec!["waiting for the first frame".into()], |last| self.lines(last));
        let width = usize::from(area.width.saturating_sub(2));
        let mut lines: Vec<String> = lines.iter().flat_map(|line| broken(line, width)).collect();
        let room = usize::from(area.height.saturating_sub(2));
        if lines.len() > room {
            let missing = lines.len() - room.saturating_sub(1);
            lines.truncate(room.saturating_sub(1));
            lines.push(format!("({missing} more in a higher window)"));
        }
        let text: Vec<Line<'_>> = lines.into_iter().map(Line::from).collect();
        frame.render_widget(Paragraph::new(text).block(Block::bordered().title(" turn ".bold())), area);
    }

    fn lines(&self, logged: &TimedTurn) -> Vec<String> {
        let (turn, estimate) = (&logged.turn, logged.turn.estimate.known_only(self.known));
        let stages = &estimate.stages;
        let widest = estimate.interval.surface_m.iter().copied().fold(0.0, f32::max);
        let seen = match &turn.profile {
            Some(Ok(profile)) => format!("{} of {} points", profile.valid_points(), profile.valid.len()),
            Some(Err(reason)) => format!("not seen: {reason}"),
            None => "no frame".into(),
        };
        let known_or = |value: String, known: bool| if known { value } else { "not known".into() };
        let speed_half = format!("{:.1} mm/s", 1e3 * estimate.interval.field[1]);
        let speed_half = known_or(speed_half, self.known.contains(FieldGroup::Velocity));
        let micro = |scaled: f64| 1e6 * self.energy_scale_j * scaled;
        let heat = known_or(format!("{:.1} µJ", micro(estimate.audit.heat)), self.known.heat());
        let mut lines = vec![
            format!("camera time  {:.3} s", turn.time.0 as f64 * 1e-6),
            format!("surface      {seen}"),
            format!("glass        {:+.2} m/s²", estimate.acceleration_m_s2),
            // Half widths of the 90 % intervals.
            format!("surface ±    {:.2} mm", 1e3 * widest),
            format!("speed ±      {speed_half}"),
            format!("late or lost {} of {}", logged.frames.missed(), logged.frames.taken()),
            format!("latency      {} of {DEADLINE_US} µs", logged.latency_us),
            format!("turn         {} µs", logged.turn_us),
            format!(" surface {:4}  predict {:4}", stages.surface_us, stages.predict_us),
            format!(" encode  {:4}  correct {:4}", stages.encode_us, stages.correct_us),
            format!(" field   {:4}", stages.field_us),
            format!("energy error {:+.0e} µJ", micro(estimate.audit.energy_residual)),
            format!("heat made    {heat}"),
        ];
        if estimate.audit.outcome != StepOutcome::Solved {
            lines.push(format!("step         {:?}", estimate.audit.outcome));
        }
        lines
    }
}

/// Indent of what does not fit into a line.
const INDENT: &str = "  ";

/// Lines of at most `width` characters; what is broken goes on with an indent. A line that fits keeps its spaces.
fn broken(line: &str, width: usize) -> Vec<String> {
    if line.chars().count() <= width {
        return vec![line.to_owned()];
    }
    let mut lines = wrapped(line, width.saturating_sub(INDENT.len()));
    lines.iter_mut().skip(1).for_each(|line| line.insert_str(0, INDENT));
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_reason_is_broken_and_keeps_its_words() {
        let line = "surface      not seen: no body of liquid as wide as the glass was found";
        let lines = broken(line, 30);
        assert!(lines.len() > 1 && lines.iter().all(|line| line.chars().count() <= 30), "{lines:?}");
        let words = |text: &str| text.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
        assert_eq!(words(&lines.join(" ")), words(line));
        assert_eq!(broken(" field     90", 30), [" field     90"]);
    }
}
