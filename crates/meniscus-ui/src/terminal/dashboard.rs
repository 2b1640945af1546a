//! The live dashboard in a terminal: the liquid inside, its surface, modes, stage times, energy and heat.

use super::curve::Curve;
use super::numbers::{self, Numbers};
use super::scale_end::ScaleEnd;
use super::section::{self, Section};
use super::surface::SurfaceChart;
use meniscus::blob::{KnownGroups, Model};
use meniscus::runtime::Mode;
use meniscus_data::validity::Validity;
use meniscus_service::run::RunState;
use meniscus_service::timed_turn::TimedTurn;
use ratatui::Frame;
use ratatui::crossterm::event::{self, Event, KeyCode, KeyEvent, KeyModifiers};
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Stylize};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Paragraph, Wrap};
use std::collections::VecDeque;
use std::io;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// Time between two pictures of the terminal.
const REFRESH: Duration = Duration::from_millis(66);

/// Values that the running curves show.
const HISTORY: usize = 160;

/// Fewest columns of the chart of the surface.
const CHART_COLUMNS: u16 = 27;

/// Speeds at which the colours may end, m/s.
const FASTEST_M_S: [f64; 8] = [0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 1.0, 2.0];

/// Texts that stay the same during a run.
#[derive(Clone, Debug)]
pub struct Caption {
    /// Liquid, model and source, for the first line.
    pub title: String,
    /// Length of the run.
    pub length: Duration,
    /// Field groups that the model knows, and the sentence about the others.
    pub validity: Validity,
}

/// The dashboard and what it remembers for its curves.
#[derive(Debug)]
pub struct Dashboard<'m> {
    model: &'m Model<'m>,
    caption: Caption,
    chart: SurfaceChart,
    fastest: ScaleEnd,
    section: Option<Section>,
    started: Instant,
    turn_us: VecDeque<u64>,
    slosh_uj: VecDeque<u64>,
    heat_uj: VecDeque<u64>,
    /// Which liquid it is, in a line; empty where nobody asks.
    liquid: String,
    /// Note of the camera that still holds.
    note: Option<String>,
}

impl<'m> Dashboard<'m> {
    /// A dashboard for one run of `model`.
    #[must_use]
    pub fn new(model: &'m Model<'m>, caption: Caption) -> Self {
        let curve = || VecDeque::with_capacity(HISTORY);
        let (turn_us, slosh_uj, heat_uj) = (curve(), curve(), curve());
        Self {
            model,
            caption,
            chart: SurfaceChart::new(model.header.radius_m, model.header.fill_m),
            fastest: ScaleEnd::new(&FASTEST_M_S),
            section: None,
            started: Instant::now(),
            turn_us,
            slosh_uj,
            heat_uj,
            liquid: String::new(),
            note: None,
        }
    }

    /// Shows the run until `finished` says so; `q`, Esc or Ctrl-C set `state.stop`.
    ///
    /// # Errors
    /// What the terminal said. It is put back as it was in every case.
    pub fn run(mut self, state: &RunState, finished: impl Fn() -> bool) -> io::Result<()> {
        let mut terminal = ratatui::try_init()?;
        let shown = self.show(&mut terminal, state, finished);
        ratatui::restore();
        shown
    }

    fn show(
        &mut self,
        terminal: &mut ratatui::DefaultTerminal,
        state: &RunState,
        finished: impl Fn() -> bool,
    ) -> io::Result<()> {
        while !finished() {
            let last = state.latest.get();
            if let Some(logged) = &last {
                self.remember(logged);
            }
            self.note = state.notes.standing().map(|note| note.to_string());
            if let Ok(Some(standing)) = state.standing.lock().as_deref() {
                self.liquid = standing.line();
            }
            terminal.draw(|frame| self.draw(frame, last.as_ref()))?;
            if event::poll(REFRESH)?
                && let Event::Key(key) = event::read()?
                && leaves(key)
            {
                state.stop.store(true, Ordering::Relaxed);
            }
        }
        Ok(())
    }

    pub(super) fn remember(&mut self, logged: &TimedTurn) {
        let estimate = logged.turn.estimate.known_only(self.known());
        let micro = |joules: f64| (joules.max(0.0) * 1e6) as u64;
        push(&mut self.turn_us, logged.turn_us);
        push(&mut self.slosh_uj, micro(estimate.slosh_j));
        push(&mut self.heat_uj, micro(estimate.heat_j));
        self.chart.remember(logged);
        let section = Section::of(self.model, &logged.turn.estimate);
        if let Some(fastest) = section.fastest_m_s() {
            self.fastest.remember(fastest);
        }
        // A halted estimate is none.
        self.section = (logged.turn.estimate.mode != Mode::Halted).then_some(section);
    }

    pub(super) fn draw(&self, frame: &mut Frame<'_>, last: Option<&TimedTurn>) {
        let [head, under, middle, foot] = self.rows().areas(frame.area());
        self.draw_head(frame, head, last);
        frame.render_widget(Paragraph::new(self.sentences()).wrap(Wrap { trim: true }), under);
        self.draw_middle(frame, middle, last);
        let known = self.known();
        let curve = |title, values, colour, known| Curve { title, values, colour, known };
        let curves = [
            curve(" turn, µs ", &self.turn_us, Color::Cyan, true),
            curve(" slosh energy, µJ ", &self.slosh_uj, Color::Yellow, known.slosh_energy()),
            curve(" heat, µJ ", &self.heat_uj, Color::Blue, known.heat()),
        ];
        let thirds = Layout::horizontal([Constraint::Ratio(1, 3); 3]).areas::<3>(foot);
        curves.iter().zip(thirds).for_each(|(curve, area)| curve.draw(frame, area));
    }

    fn known(&self) -> KnownGroups {
        self.caption.validity.known
    }

    /// Heights of the first line, the sentences, the liquid and the running curves.
    fn rows(&self) -> Layout {
        let sentence = self.note.is_some() || self.caption.validity.sentence.is_some();
        let under = if sentence { 3 } else { 0 } + if self.liquid.is_empty() { 0 } else { 1 };
        Layout::vertical([
            Constraint::Length(3),
            Constraint::Length(under),
            Constraint::Min(6),
            Constraint::Length(6),
        ])
    }

    /// Note of the camera, or a sentence about unknown groups; then the liquid.
    fn sentences(&self) -> Vec<Line<'_>> {
        // What happened to the camera goes before what never changes.
        let note = self.note.as_ref().map(|note| format!("camera: {note}"));
        let sentence = note.or_else(|| self.caption.validity.sentence.clone());
        let liquid = (!self.liquid.is_empty()).then(|| format!("liquid: {}", self.liquid));
        sentence.into_iter().chain(liquid).map(Line::from).collect()
    }

    fn draw_head(&self, frame: &mut Frame<'_>, area: Rect, last: Option<&TimedTurn>) {
        let mode = last.map_or(Mode::Filling, |logged| logged.turn.estimate.mode);
        let colour = match mode {
            Mode::Tracking => Color::Green,
            Mode::Filling => Color::Blue,
            Mode::Coasting => Color::Yellow,
            Mode::Halted => Color::Red,
        };
        let (now, end) = (self.started.elapsed().as_secs_f64(), self.caption.length.as_secs_f64());
        let (mode, time) = (format!(" {mode:?} "), format!("  {now:5.1} of {end:.0} s   "));
        let room = usize::from(area.width.saturating_sub(2)).saturating_sub(mode.len() + time.len());
        let mut title = self.caption.title.clone();
        if title.chars().count() > room {
            title = title.chars().take(room.saturating_sub(1)).chain(['…']).collect();
        }
        let mode = Span::from(mode).bold().fg(Color::Black).bg(colour);
        let line = Line::from(vec![mode, Span::from(time), Span::from(title)]);
        let block = Block::bordered().title(" meniscus ").title(Line::from(" q ends ").right_aligned());
        frame.render_widget(Paragraph::new(line).block(block), area);
    }

    /// The liquid inside, its surface, and the figures of the turn.
    fn draw_middle(&self, frame: &mut Frame<'_>, area: Rect, last: Option<&TimedTurn>) {
        let header = &self.model.header;
        let wanted = Section::columns(header.radius_m, header.rim_m, area.height.saturating_sub(2)) + 2;
        let room = area.width.saturating_sub(numbers::COLUMNS + CHART_COLUMNS);
        let columns = [
            Constraint::Length(wanted.min(room)),
            Constraint::Min(CHART_COLUMNS),
            Constraint::Length(numbers::COLUMNS),
        ];
        let [inside, surface, figures] = Layout::horizontal(columns).areas(area);
        self.draw_section(frame, inside);
        self.chart.draw(frame, surface, last);
        let numbers = Numbers { last, known: self.known(), energy_scale_j: header.energy_scale_j };
        numbers.draw(frame, figures);
    }

    fn draw_section(&self, frame: &mut Frame<'_>, area: Rect) {
        let block = Block::bordered().title(" speed inside ");
        let inner = block.inner(area);
        let Some(section) = &self.section else {
            frame.render_widget(Paragraph::new("no estimate").block(block), area);
            return;
        };
        let top = self.fastest.shown();
        let below = section.fastest_m_s().map_or(Line::from(" not known "), |_| section::scale(top));
        frame.render_widget(block.title_bottom(below), area);
        frame.render_widget(section.drawn(top), inner);
    }
}

fn push(curve: &mut VecDeque<u64>, value: u64) {
    if curve.len() == HISTORY {
        curve.pop_front();
    }
    curve.push_back(value);
}

/// Whether a key ends the run. In raw mode Ctrl-C arrives as a key.
fn leaves(key: KeyEvent) -> bool {
    let interrupt = key.code == KeyCode::Char('c') && key.modifiers.contains(KeyModifiers::CONTROL);
    interrupt || matches!(key.code, KeyCode::Char('q') | KeyCode::Esc)
}
