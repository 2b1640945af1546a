//! The setup in a terminal: four steps beside the camera's picture.
//!
//! The wizard knows nothing of cameras: it is given what was seen, takes keys, and says what it wishes.

use super::glass::{GlassPicture, Layer};
use meniscus::surface::{Config, POINTS, profile_abscissa};
use meniscus_service::setup::{Finding, Inspection, MeasuredGlass, Portrait, RANGES};
use ratatui::Frame;
use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers};
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Stylize};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Paragraph, Wrap};

/// Most characters of a measure.
const DIGITS: usize = 6;
/// Words of the measures, in the order of [`MeasuredGlass::values`].
const ASKED: [&str; 3] = ["inner radius", "fill", "rim"];

/// The steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// Link and permissions.
    Camera,
    /// Is the glass seen, and where.
    Glass,
    /// The measures by hand.
    Measure,
    /// The surface at rest.
    Rest,
}

impl Step {
    const ALL: [(Self, &'static str); 4] =
        [(Self::Camera, "camera"), (Self::Glass, "glass"), (Self::Measure, "measures"), (Self::Rest, "rest")];
}

/// Request of the person at the wizard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wish {
    /// Nothing that concerns others.
    None,
    /// Another look at the surface at rest.
    Look,
    /// The settings file, and the end.
    Save,
    /// The end without a file.
    Leave,
}

/// The wizard's memory.
#[derive(Clone, Debug)]
pub struct Wizard {
    title: String,
    camera: Vec<Finding>,
    step: Step,
    layer: Layer,
    entries: [String; 3],
    selected: usize,
    seen: Option<(Portrait, Inspection, Option<Config>)>,
    waiting: bool,
    /// The next digit replaces the selected entry, as in a form.
    replaces: bool,
    /// Enter was pressed where it leads nowhere yet.
    refused: bool,
}

impl Wizard {
    /// A wizard for the camera that `title` names and `camera` judges; `said` is offered for the measures.
    #[must_use]
    pub fn new(title: String, camera: Vec<Finding>, said: MeasuredGlass) -> Self {
        let entries = said.values().map(|value| format!("{value}"));
        let (step, layer) = (Step::Camera, Layer::Infrared);
        let (seen, waiting, replaces, refused) = (None, true, true, false);
        Self { title, camera, step, layer, entries, selected: 0, seen, waiting, replaces, refused }
    }

    /// The present step.
    #[must_use]
    pub fn step(&self) -> Step {
        self.step
    }

    /// Returns the measures of the glass in the entries.
    ///
    /// # Errors
    /// In words, when an entry is no number or out of its range.
    pub fn said(&self) -> Result<MeasuredGlass, String> {
        let mut values = [0.0; 3];
        for ((value, entry), (name, ..)) in values.iter_mut().zip(&self.entries).zip(RANGES) {
            *value = entry.parse().map_err(|_| format!("{name}: '{entry}' is no number"))?;
        }
        let said = MeasuredGlass::of(values);
        said.check().map(|()| said)
    }

    /// Takes what was seen; `config` is that of the inspection's setup, and places points in the picture.
    ///
    /// A measure that the camera contradicts leads from the last step back to the measures.
    pub fn see(&mut self, portrait: Portrait, inspection: Inspection, config: Option<Config>) {
        let is_wrong = |finding: &Finding| {
            step_of(finding) == Step::Measure && finding.check.missed() && finding.check.value.is_some()
        };
        if self.step == Step::Rest && inspection.findings.iter().any(is_wrong) {
            (self.step, self.replaces, self.refused) = (Step::Measure, true, true);
        }
        self.seen = Some((portrait, inspection, config));
        self.waiting = false;
    }

    /// Shows that a look is under way.
    pub fn wait(&mut self) {
        self.waiting = true;
    }

    /// The last inspection.
    #[must_use]
    pub fn inspection(&self) -> Option<&Inspection> {
        self.seen.as_ref().map(|(_, inspection, _)| inspection)
    }

    /// Takes a key.
    pub fn key(&mut self, key: KeyEvent) -> Wish {
        let control = key.modifiers.contains(KeyModifiers::CONTROL);
        self.refused = false;
        match key.code {
            KeyCode::Esc | KeyCode::Char('q') => return Wish::Leave,
            KeyCode::Char('c') if control => return Wish::Leave,
            KeyCode::Char('d') => {
                let depth = self.layer == Layer::Depth;
                self.layer = if depth { Layer::Infrared } else { Layer::Depth };
            }
            KeyCode::Enter => return self.next(),
            KeyCode::Left => self.step = before(self.step),
            KeyCode::Char('r') if self.step == Step::Rest => {
                self.waiting = true;
                return Wish::Look;
            }
            _ if self.step == Step::Measure => self.edit(key.code),
            _ => {}
        }
        Wish::None
    }

    fn edit(&mut self, code: KeyCode) {
        let count = self.entries.len();
        match code {
            KeyCode::Down | KeyCode::Tab => {
                (self.selected, self.replaces) = ((self.selected + 1) % count, true);
            }
            KeyCode::Up | KeyCode::BackTab => {
                (self.selected, self.replaces) = ((self.selected + count - 1) % count, true);
            }
            code => {
                let Some(entry) = self.entries.get_mut(self.selected) else { return };
                match code {
                    KeyCode::Backspace => {
                        entry.pop();
                        self.replaces = false;
                    }
                    KeyCode::Char(sign) if sign.is_ascii_digit() || sign == '.' => {
                        if std::mem::take(&mut self.replaces) {
                            entry.clear();
                        }
                        entry.push(sign);
                        entry.truncate(DIGITS);
                    }
                    _ => {}
                }
            }
        }
    }

    fn next(&mut self) -> Wish {
        match self.step {
            Step::Camera => self.step = Step::Glass,
            Step::Glass => (self.step, self.replaces) = (Step::Measure, true),
            Step::Measure if self.said().is_ok() => {
                self.step = Step::Rest;
                self.waiting = true;
                return Wish::Look;
            }
            Step::Rest if !self.waiting && self.inspection().is_some_and(Inspection::ok) => {
                return Wish::Save;
            }
            Step::Measure | Step::Rest => self.refused = true,
        }
        Wish::None
    }

    /// Draws everything.
    pub fn draw(&self, frame: &mut Frame<'_>) {
        let rows = Layout::vertical([Constraint::Length(3), Constraint::Min(12), Constraint::Length(3)]);
        let [head, middle, foot] = rows.areas(frame.area());
        let mut steps = vec![Span::from(" ")];
        for (k, (step, name)) in Step::ALL.into_iter().enumerate() {
            let text = Span::from(format!(" {} {name} ", k + 1));
            steps.push(if step == self.step {
                text.bold().fg(Color::Black).bg(Color::Green)
            } else {
                text.dim()
            });
        }
        steps.push(Span::from(format!("   {}", self.title)));
        frame.render_widget(
            Paragraph::new(Line::from(steps)).block(Block::bordered().title(" meniscus setup ")),
            head,
        );
        let [picture, panel] =
            Layout::horizontal([Constraint::Min(40), Constraint::Length(52)]).areas(middle);
        self.draw_picture(frame, picture);
        let text = Paragraph::new(self.panel()).wrap(Wrap { trim: false });
        frame.render_widget(text.block(Block::bordered().title(" what is seen ")), panel);
        frame.render_widget(Paragraph::new(self.keys()).block(Block::bordered()), foot);
    }

    fn draw_picture(&self, frame: &mut Frame<'_>, area: Rect) {
        let name = if self.layer == Layer::Infrared { "infrared" } else { "depth" };
        let block = Block::bordered().title(format!(" {name}: sides, edge, surface points, rest line "));
        let inner = block.inner(area);
        frame.render_widget(block, area);
        let Some((portrait, inspection, config)) = &self.seen else {
            frame.render_widget(Paragraph::new(" waiting for the first images"), inner);
            return;
        };
        let points = config.as_ref().map(|config| points(config, inspection)).unwrap_or_default();
        let rest = config.as_ref().map(|config| rest_line(config, inspection)).unwrap_or_default();
        let body = inspection.body.as_ref();
        frame.render_widget(
            GlassPicture { portrait, layer: self.layer, body, points: &points, rest: &rest },
            inner,
        );
    }

    fn panel(&self) -> Vec<Line<'_>> {
        let inspection = self.inspection();
        let all = inspection.map_or(&[] as &[Finding], |inspection| &inspection.findings);
        let shown: Vec<&Finding> = match self.step {
            Step::Camera => self.camera.iter().collect(),
            step => all.iter().filter(|finding| step_of(finding) == step).collect(),
        };
        let mut lines = if self.step == Step::Measure { self.measures() } else { Vec::new() };
        lines.extend(shown.iter().map(|finding| told(finding)));
        if self.waiting && self.step != Step::Camera {
            lines.push(Line::from("looking ...").dim());
        } else if self.step == Step::Rest && inspection.is_some_and(Inspection::ok) {
            lines.push(Line::from("all is well: Enter writes the settings").green().bold());
        } else {
            // What was measured and missed; or what all the rest could not be measured for.
            let missed = || shown.iter().copied().filter(|finding| finding.check.missed());
            let measured = missed().find(|finding| finding.check.value.is_some());
            let first = measured.or_else(|| missed().next());
            let elsewhere = inspection.filter(|_| self.step == Step::Rest);
            let first = first.or_else(|| elsewhere.and_then(|all| all.remedies().first().copied()));
            lines.extend(first.map(|finding| Line::from(finding.remedy.as_str()).yellow()));
        }
        if self.refused {
            let what = match self.step {
                Step::Rest if self.waiting => "Enter waits for the look that is under way",
                Step::Rest => "Enter writes nothing until this is mended; r looks again",
                _ => "Enter goes on when this is mended",
            };
            lines.push(Line::from(what).red().bold());
        }
        lines
    }

    /// The measures, to be edited.
    fn measures(&self) -> Vec<Line<'_>> {
        let mut lines = vec![Line::from("from the inner bottom, in mm:")];
        let asked = ASKED.into_iter().zip(&self.entries).zip(RANGES);
        for (k, ((name, entry), (_, least, most))) in asked.enumerate() {
            let text = format!("{name:13} {entry:>6} mm   {least} to {most}");
            let line = Line::from(text);
            lines.push(if k == self.selected { line.bold().reversed() } else { line });
        }
        if let Err(what) = self.said() {
            lines.push(Line::from(what).red());
        }
        lines.extend([Line::from(""), Line::from("the camera sees:")]);
        lines
    }

    fn keys(&self) -> Line<'_> {
        Line::from(match self.step {
            Step::Camera | Step::Glass => " Enter next   Left back   d infrared or depth   q leaves",
            Step::Measure => " digits and Backspace   Up, Down   Enter next   Left back   d depth   q leaves",
            Step::Rest => " Enter writes the file   r looks again   Left back   d depth   q leaves",
        })
    }
}

fn before(step: Step) -> Step {
    match step {
        Step::Camera | Step::Glass => Step::Camera,
        Step::Measure => Step::Glass,
        Step::Rest => Step::Measure,
    }
}

/// Returns the step at which a finding of the inspection is shown: at `Measure` if it depends on an entered measure.
fn step_of(finding: &Finding) -> Step {
    match finding.check.name.as_str() {
        "radius_seen_mm" | "fill_seen_mm" | "camera_height_mm" => Step::Measure,
        name if name.starts_with("rest_") => Step::Rest,
        _ => Step::Glass,
    }
}

/// A finding in one line.
fn told(finding: &Finding) -> Line<'_> {
    let check = &finding.check;
    let value = check.value.map_or("-".into(), |value| format!("{value:.2}"));
    let mark = match check.ok {
        Some(true) => Span::from(" ok ").green(),
        Some(false) => Span::from(" -- ").red(),
        None => Span::from("    "),
    };
    let text = format!("{:17}{value:>8} {:<5}{}", check.name, check.unit, check.target_text());
    Line::from(vec![mark, Span::from(text)])
}

/// Where the mean surface points are in the picture.
fn points(config: &Config, inspection: &Inspection) -> Vec<(f32, f32)> {
    let (Some(rest), Some(survey), Some(setup)) = (&inspection.rest, &inspection.survey, &inspection.setup)
    else {
        return Vec::new();
    };
    let x_m = (1e-3 * setup.view.distance_mm * survey.bearing) as f32;
    let place = |(index, height_m): (usize, &Option<f32>)| {
        let [x, y, z] = config.wall_point(profile_abscissa(index) as f32, (*height_m)?);
        Some(config.pixel_of([x + x_m, y, z]))
    };
    rest.height_m.iter().enumerate().filter_map(place).collect()
}

/// Where the said fill is in the picture: on the facing wall, and a little beyond on either side.
fn rest_line(config: &Config, inspection: &Inspection) -> Vec<(f32, f32)> {
    let (Some(survey), Some(setup)) = (&inspection.survey, &inspection.setup) else { return Vec::new() };
    let x_m = (1e-3 * setup.view.distance_mm * survey.bearing) as f32;
    let fill_m = (1e-3 * setup.glass.fill_mm) as f32;
    let place = |index: usize| {
        let [x, y, z] = config.wall_point(profile_abscissa(index) as f32, fill_m);
        config.pixel_of([x + x_m, y, z])
    };
    let (left, right) = (place(0), place(POINTS - 1));
    let beyond = (2..8).flat_map(|k| {
        let away = 5.0 * k as f32;
        [(left.0 - away, left.1), (right.0 + away, right.1)]
    });
    (0..POINTS).map(place).chain(beyond).collect()
}
