//! The wizard before a camera that is running: its loop.

use super::Job;
use super::camera::{Scene, Sitting};
use meniscus::surface::Config;
use meniscus_service::setup::{Finding, Inspection, MeasuredGlass, Portrait};
use meniscus_ui::terminal::{Step, Wish, Wizard};
use ratatui::crossterm::event::{self, Event, KeyEventKind};
use std::time::{Duration, Instant};

/// Time between two pictures of the terminal, and between two looks at the glass while nothing is measured.
const REFRESH: Duration = Duration::from_millis(50);
const GLANCE: Duration = Duration::from_millis(400);
/// Pairs of a glance.
const GLANCED: usize = 8;

/// Asks until the person is done: the inspection to be written, or none.
pub(super) fn ask(
    job: &Job<'_>,
    scene: &Scene,
    sitting: &dyn Sitting,
    camera: Vec<Finding>,
) -> anyhow::Result<Option<Inspection>> {
    let mut terminal = ratatui::try_init()?;
    let mut wizard = Wizard::new(scene.name.clone(), camera, job.said);
    let done = dialogue(job, scene, sitting, &mut wizard, &mut terminal);
    ratatui::restore();
    done
}

fn dialogue(
    job: &Job<'_>,
    scene: &Scene,
    sitting: &dyn Sitting,
    wizard: &mut Wizard,
    terminal: &mut ratatui::DefaultTerminal,
) -> anyhow::Result<Option<Inspection>> {
    let mut said = job.said;
    let mut glanced: Option<Instant> = None;
    // The number of pairs at which the look at the surface at rest is due; none while it is not wanted.
    let mut due: Option<u64> = None;
    loop {
        said = wizard.said().unwrap_or(said);
        if wizard.step() == Step::Rest {
            if due.is_some_and(|due| scene.total() >= due || !sitting.lives()) {
                due = None;
                look(job, scene, wizard, job.pairs, said);
            }
        } else if glanced.is_none_or(|at| at.elapsed() >= GLANCE) && scene.total() > 0 {
            look(job, scene, wizard, GLANCED, said);
            glanced = Some(Instant::now());
        }
        terminal.draw(|frame| wizard.draw(frame))?;
        if !event::poll(REFRESH)? {
            continue;
        }
        let Event::Key(key) = event::read()? else { continue };
        if key.kind != KeyEventKind::Press {
            continue;
        }
        match wizard.key(key) {
            Wish::None => {}
            Wish::Look => due = Some(scene.total() + if sitting.lives() { job.pairs as u64 } else { 0 }),
            Wish::Save => return Ok(wizard.inspection().cloned()),
            Wish::Leave => return Ok(None),
        }
    }
}

/// Shows the wizard the newest pairs.
fn look(job: &Job<'_>, scene: &Scene, wizard: &mut Wizard, pairs: usize, said: MeasuredGlass) {
    let inspection = job.inspect(scene, pairs, said);
    let Some(portrait) = Portrait::of(&scene.newest(pairs.min(GLANCED)), &scene.optics) else { return };
    let settings = inspection.setup.as_ref().map(|setup| setup.settings(scene.optics));
    let config = settings.and_then(|settings| Config::new(settings).ok());
    wizard.see(portrait, inspection, config);
}
