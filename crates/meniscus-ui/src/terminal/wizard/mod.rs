//! The setup in a terminal: four steps beside the camera's picture.
//!
//! The wizard knows nothing of cameras: it is given what was seen, takes keys, and says what it wishes.

mod screen;

use super::glass::Layer;
use meniscus::surface::Config;
use meniscus_service::setup::{Finding, Inspection, MeasuredGlass, Portrait, RANGES};
use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers};

/// Most characters of a measure.
const DIGITS: usize = 6;
/// Words of the measures, in the order of [`MeasuredGlass::values`].
const ASKED: [&str; MEASURES] = ["inner radius", "fill", "rim", "wall", "base"];
/// Measures; the last two may be left empty.
const MEASURES: usize = RANGES.len();
const REQUIRED: usize = 3;

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
    entries: [String; MEASURES],
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
        let entries = said.values().map(|value| value.map(|value| format!("{value}")).unwrap_or_default());
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
        let mut values = [None; MEASURES];
        for (k, ((value, entry), (name, ..))) in values.iter_mut().zip(&self.entries).zip(RANGES).enumerate()
        {
            if k < REQUIRED || !entry.is_empty() {
                *value = Some(entry.parse().map_err(|_| format!("{name}: '{entry}' is no number"))?);
            }
        }
        let [radius_mm, fill_mm, rim_mm, wall_mm, base_mm] = values;
        let required = [radius_mm, fill_mm, rim_mm].map(|value| value.unwrap_or(f64::NAN));
        let said = MeasuredGlass { wall_mm, base_mm, ..MeasuredGlass::of(required) };
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
