//! The live dashboard in a terminal: surface, modes, stage times, energy and entropy.

use super::curve::Curve;
use meniscus::blob::FieldGroup;
use meniscus::runtime::{DEADLINE_US, Mode};
use meniscus::surface::profile_abscissa;
use meniscus_data::validity::Validity;
use meniscus_service::run::RunState;
use meniscus_service::timed_turn::TimedTurn;
use ratatui::Frame;
use ratatui::crossterm::event::{self, Event, KeyCode, KeyEvent, KeyModifiers};
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Style, Stylize};
use ratatui::symbols::Marker;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Axis, Block, Chart, Dataset, GraphType, Paragraph, Wrap};
use std::collections::VecDeque;
use std::io;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// Time between two pictures of the terminal.
const REFRESH: Duration = Duration::from_millis(66);

/// Values that the running curves show.
const HISTORY: usize = 160;

/// Texts that stay the same during a run.
#[derive(Clone, Debug)]
pub struct Caption {
    /// Liquid, model and source, for the first line.
    pub title: String,
    /// Height of the surface at rest, m.
    pub fill_m: f64,
    /// Inner radius, m.
    pub radius_m: f64,
    /// Length of the run.
    pub length: Duration,
    /// Field groups that the model knows, and the sentence about the others.
    pub validity: Validity,
}

/// The dashboard and what it remembers for its curves.
#[derive(Debug)]
pub struct Dashboard {
    caption: Caption,
    started: Instant,
    turn_us: VecDeque<u64>,
    slosh_uj: VecDeque<u64>,
    heat_uj: VecDeque<u64>,
    /// Which liquid it is, in a line; empty where nobody asks.
    liquid: String,
    /// Note of the camera that still holds.
    note: Option<String>,
}

impl Dashboard {
    /// A dashboard for one run.
    #[must_use]
    pub fn new(caption: Caption) -> Self {
        let curve = || VecDeque::with_capacity(HISTORY);
        let (turn_us, slosh_uj, heat_uj) = (curve(), curve(), curve());
        Self {
            caption,
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

    fn remember(&mut self, logged: &TimedTurn) {
        let estimate = logged.turn.estimate.known_only(self.caption.validity.known);
        let micro = |joules: f64| (joules.max(0.0) * 1e6) as u64;
        push(&mut self.turn_us, logged.turn_us);
        push(&mut self.slosh_uj, micro(estimate.slosh_j));
        push(&mut self.heat_uj, micro(estimate.heat_j));
    }

    fn draw(&self, frame: &mut Frame<'_>, last: Option<&TimedTurn>) {
        // What happened to the camera goes before what never changes.
        let note = self.note.as_ref().map(|note| format!("camera: {note}"));
        let sentence = note.as_deref().or(self.caption.validity.sentence.as_deref());
        let rows = Layout::vertical([
            Constraint::Length(3),
            Constraint::Length(if sentence.is_some() { 3 } else { 0 }),
            Constraint::Min(10),
            Constraint::Length(6),
        ]);
        let [head, under, middle, foot] = rows.areas(frame.area());
        frame.render_widget(self.headline(last), head);
        frame.render_widget(Paragraph::new(sentence.unwrap_or_default()).wrap(Wrap { trim: true }), under);
        let [surface, numbers] =
            Layout::horizontal([Constraint::Min(40), Constraint::Length(38)]).areas(middle);
        self.draw_surface(frame, surface, last);
        frame.render_widget(self.numbers(last), numbers);
        let known = self.caption.validity.known;
        let curve = |title, values, colour, known| Curve { title, values, colour, known };
        let curves = [
            curve(" turn, us ", &self.turn_us, Color::Cyan, true),
            curve(" slosh energy, uJ ", &self.slosh_uj, Color::Yellow, known.slosh_energy()),
            curve(" heat = entropy, uJ ", &self.heat_uj, Color::Red, known.heat()),
        ];
        let thirds = Layout::horizontal([Constraint::Ratio(1, 3); 3]).areas::<3>(foot);
        curves.iter().zip(thirds).for_each(|(curve, area)| curve.draw(frame, area));
    }

    fn headline(&self, last: Option<&TimedTurn>) -> Paragraph<'_> {
        let mode = last.map_or(Mode::Filling, |logged| logged.turn.estimate.mode);
        let colour = match mode {
            Mode::Tracking => Color::Green,
            Mode::Filling => Color::Blue,
            Mode::Coasting => Color::Yellow,
            Mode::Halted => Color::Red,
        };
        let (now, end) = (self.started.elapsed().as_secs_f64(), self.caption.length.as_secs_f64());
        let line = Line::from(vec![
            Span::from(format!(" {mode:?} ")).bold().fg(Color::Black).bg(colour),
            Span::from(format!("  {now:5.1} of {end:.0} s   ")),
            Span::from(self.caption.title.as_str()),
            Span::from("   q ends").dim(),
        ]);
        Paragraph::new(line).block(Block::bordered().title(" meniscus "))
    }

    fn draw_surface(&self, frame: &mut Frame<'_>, area: Rect, last: Option<&TimedTurn>) {
        let (radius_mm, fill_mm) = (1e3 * self.caption.radius_m, 1e3 * self.caption.fill_m);
        let x = |index: usize| radius_mm * profile_abscissa(index);
        let points = |heights: &[f32], keep: &dyn Fn(usize) -> bool| -> Vec<(f64, f64)> {
            let all = heights.iter().enumerate().filter(|(index, _)| keep(*index));
            all.map(|(index, z)| (x(index), 1e3 * f64::from(*z))).collect()
        };
        let estimated = last.map_or(vec![], |logged| points(&logged.turn.estimate.surface_m, &|_| true));
        let measured = match last.and_then(|logged| logged.turn.profile) {
            Some(Ok(profile)) => points(&profile.height_m, &|index| profile.valid[index]),
            _ => vec![],
        };
        let rest = [(-radius_mm, fill_mm), (radius_mm, fill_mm)];
        let set = |name, data, marker, kind, colour: Color| {
            Dataset::default().name(name).data(data).marker(marker).graph_type(kind).style(colour)
        };
        let chart = Chart::new(vec![
            set("rest", &rest, Marker::Dot, GraphType::Line, Color::DarkGray),
            set("estimated", &estimated, Marker::Braille, GraphType::Line, Color::Green),
            set("measured", &measured, Marker::Dot, GraphType::Scatter, Color::Magenta),
        ])
        .block(Block::bordered().title(" surface, mm "))
        .x_axis(axis(-radius_mm, radius_mm))
        .y_axis(axis(fill_mm - 25.0, fill_mm + 25.0));
        frame.render_widget(chart, area);
    }

    fn numbers(&self, last: Option<&TimedTurn>) -> Paragraph<'_> {
        let block = Block::bordered().title(" turn ");
        let Some(logged) = last else {
            return Paragraph::new("waiting for the first frame").block(block);
        };
        let known = self.caption.validity.known;
        let (turn, estimate) = (&logged.turn, logged.turn.estimate.known_only(known));
        let stages = &estimate.stages;
        let widest = estimate.interval.surface_m.iter().copied().fold(0.0, f32::max);
        let seen = match &turn.profile {
            Some(Ok(profile)) => format!("{} of {} points", profile.valid_points(), profile.valid.len()),
            Some(Err(reason)) => format!("not seen: {reason}"),
            None => "no frame".into(),
        };
        let known_or = |value: String, known: bool| if known { value } else { "not known".into() };
        let speed_half = format!("{:.0} mm/s", 1e3 * estimate.interval.field[1]);
        let speed_half = known_or(speed_half, known.contains(FieldGroup::Velocity));
        let produced = known_or(format!("{:+.1e}", estimate.audit.heat), known.heat());
        let lines = [
            format!("camera time   {:.3} s", turn.time.0 as f64 * 1e-6),
            format!("surface       {seen}"),
            format!("glass         {:+.2} m/s2", estimate.acceleration_m_s2),
            format!("may be off by {:.1} mm, {speed_half}", 1e3 * widest),
            String::new(),
            format!("surface    {:6} us", stages.surface_us),
            format!("predict    {:6} us", stages.predict_us),
            format!("encode     {:6} us", stages.encode_us),
            format!("correct    {:6} us", stages.correct_us),
            format!("field      {:6} us", stages.field_us),
            format!("whole turn {:6} us", logged.turn_us),
            format!("latency    {:6} us of {DEADLINE_US}", logged.latency_us),
            format!("deadlines missed {} of {}", logged.frames.missed(), logged.frames.taken()),
            String::new(),
            format!("step       {:?}, {} iterations", estimate.audit.outcome, estimate.audit.iterations),
            format!("dE - work  {:+.1e}", estimate.audit.energy_residual),
            format!("dS         {produced}"),
            self.liquid.clone(),
        ];
        Paragraph::new(lines.map(Line::from).to_vec()).wrap(Wrap { trim: true }).block(block)
    }
}

/// A labelled axis from `low` to `high`.
fn axis<'a>(low: f64, high: f64) -> Axis<'a> {
    let labels = [low, 0.5 * (low + high), high].map(|value| format!("{value:.0}"));
    Axis::default().bounds([low, high]).labels(labels).style(Style::default().dim())
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
