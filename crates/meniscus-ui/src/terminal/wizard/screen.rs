//! The wizard's screen: steps, picture, findings, keys.

use super::{ASKED, REQUIRED, Step, Wizard, step_of};
use crate::terminal::glass::{GlassPicture, Layer};
use meniscus::surface::{Config, POINTS, profile_abscissa};
use meniscus_service::setup::{Finding, Inspection, RANGES};
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Stylize};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Paragraph, Wrap};

impl Wizard {
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
        lines.extend(shown.iter().map(|finding| finding_line(finding)));
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
            let known = if k < REQUIRED { "" } else { ", or empty: thin" };
            let text = format!("{name:13} {entry:>6} mm   {least} to {most}{known}");
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

/// A finding in one line.
fn finding_line(finding: &Finding) -> Line<'_> {
    let check = &finding.check;
    let value = check.value.map_or("-".into(), |value| format!("{value:.2}"));
    let mark = match check.ok {
        Some(true) => Span::from(" ok ").green(),
        Some(false) => Span::from(" -- ").red(),
        None => Span::from("    "),
    };
    let text = format!("{:17}{value:>8} {:<5}{}", check.name, check.unit, check.target);
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
