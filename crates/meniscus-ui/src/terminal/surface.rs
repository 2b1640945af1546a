//! Chart of the surface in a terminal: the measured points, the estimate, and the fill at rest.

use super::scale_end::ScaleEnd;
use meniscus::surface::{POINTS, profile_abscissa};
use meniscus_service::timed_turn::TimedTurn;
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Color, Style, Stylize};
use ratatui::symbols::Marker;
use ratatui::text::Line;
use ratatui::widgets::{Axis, Block, Chart, Dataset, GraphType};

/// Half the heights that the chart may show, mm.
const HALVES_MM: [f64; 7] = [2.0, 4.0, 8.0, 12.0, 20.0, 30.0, 50.0];

const MEASURED: Color = Color::Magenta;
const ESTIMATED: Color = Color::Green;
const REST: Color = Color::DarkGray;

/// The chart, and how far the surface has gone from rest in the last seconds.
#[derive(Clone, Debug)]
pub(super) struct SurfaceChart {
    radius_mm: f64,
    fill_mm: f64,
    half: ScaleEnd,
}

impl SurfaceChart {
    pub(super) fn new(radius_m: f64, fill_m: f64) -> Self {
        Self { radius_mm: 1e3 * radius_m, fill_mm: 1e3 * fill_m, half: ScaleEnd::new(&HALVES_MM) }
    }

    /// Takes a turn into account for the heights that are shown.
    pub(super) fn remember(&mut self, logged: &TimedTurn) {
        let heights = logged.turn.estimate.surface_m.iter().chain(measured(logged).into_iter().flatten());
        let off = heights.map(|height| (1e3 * f64::from(*height) - self.fill_mm).abs()).fold(0.0, f64::max);
        self.half.remember(off);
    }

    pub(super) fn draw(&self, frame: &mut Frame<'_>, area: Rect, last: Option<&TimedTurn>) {
        let at = |(index, height): (usize, f64)| (self.radius_mm * profile_abscissa(index), height);
        let points = |heights: &[f64]| heights.iter().copied().enumerate().map(at).collect::<Vec<_>>();
        let estimated = last.map(|logged| logged.turn.estimate.surface_m.map(|z| 1e3 * f64::from(z)));
        let estimated = estimated.map_or(vec![], |heights| points(&heights));
        let seen = last.and_then(measured_mm).map_or(vec![], |heights| points(&heights));
        // A point that was not seen is not a number.
        let seen: Vec<_> = seen.into_iter().filter(|(_, height)| height.is_finite()).collect();
        let rest = [(-self.radius_mm, self.fill_mm), (self.radius_mm, self.fill_mm)];
        let set = |data, marker, kind, colour: Color| {
            Dataset::default().data(data).marker(marker).graph_type(kind).style(colour)
        };
        let half = self.half.shown();
        // The legend of a chart hides curves, or is hidden where there is little room.
        let legend =
            Line::from(vec!["•measured".fg(MEASURED), " ─estimate".fg(ESTIMATED), " ─rest".fg(REST)]);
        let chart = Chart::new(vec![
            set(&rest, Marker::Braille, GraphType::Line, REST),
            set(&estimated, Marker::Braille, GraphType::Line, ESTIMATED),
            set(&seen, Marker::Dot, GraphType::Scatter, MEASURED),
        ])
        .block(Block::bordered().title(" surface z, mm ").title_bottom(legend))
        .x_axis(axis(-self.radius_mm, self.radius_mm).title("x, mm"))
        .y_axis(axis(self.fill_mm - half, self.fill_mm + half));
        frame.render_widget(chart, area);
    }
}

/// Heights of the points that were seen in the turn's frame.
fn measured(logged: &TimedTurn) -> Option<impl Iterator<Item = &f32>> {
    let profile = logged.turn.profile.as_ref()?.as_ref().ok()?;
    let all = profile.height_m.iter().zip(profile.valid);
    Some(all.filter(|(_, valid)| *valid).map(|(height, _)| height))
}

/// All heights of the turn's frame, mm; a point that was not seen is not a number.
fn measured_mm(logged: &TimedTurn) -> Option<[f64; POINTS]> {
    let profile = logged.turn.profile.as_ref()?.as_ref().ok()?;
    Some(std::array::from_fn(|index| {
        if profile.valid[index] { 1e3 * f64::from(profile.height_m[index]) } else { f64::NAN }
    }))
}

/// A labelled axis from `low` to `high`.
fn axis<'a>(low: f64, high: f64) -> Axis<'a> {
    let labels = [low, 0.5 * (low + high), high].map(|value| format!("{value:.0}"));
    Axis::default().bounds([low, high]).labels(labels).style(Style::default().dim())
}
