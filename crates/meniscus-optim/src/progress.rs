//! Session of a training: bars and curves, the stop flag, the folder of the checkpoints.

use indicatif::{
    HumanDuration, MultiProgress, ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle,
};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

/// One look at a stage: the step, and the relative errors on training and validation data.
pub type LookAt = (u32, f64, f64);

/// Errors of a stage over its steps.
#[derive(Clone, Debug)]
pub struct Curve {
    /// The stage.
    pub stage: String,
    /// Its looks.
    pub looks: Vec<LookAt>,
}

/// Where a training keeps its checkpoints.
#[derive(Clone, Debug)]
pub struct Checkpoints {
    /// The folder; it is there.
    pub folder: PathBuf,
    /// Whether what lies there is gone on from.
    pub resume: bool,
}

/// One run of the trainer: its bars, the flag that Ctrl-C raises, its checkpoints and curves.
#[derive(Debug)]
pub struct Session<'a> {
    bars: MultiProgress,
    stop: &'a AtomicBool,
    checkpoints: Option<Checkpoints>,
    fingerprint: u32,
    curves: Mutex<Vec<Curve>>,
}

/// Writes the time left, or that it is not known yet.
fn left(state: &ProgressState, out: &mut dyn Write) {
    // A terminal that is gone is no reason to stop.
    let _shown = if state.pos() == 0 {
        write!(out, "starting")
    } else {
        write!(out, "{} left", HumanDuration(state.eta()))
    };
}

/// The bar of one stage.
#[derive(Debug)]
pub struct Bar(ProgressBar);

impl<'a> Session<'a> {
    /// Bars on the terminal unless `quiet`; `stop` ends a stage at its next look.
    #[must_use]
    pub fn new(quiet: bool, stop: &'a AtomicBool) -> Self {
        let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        let bars = MultiProgress::with_draw_target(target);
        Self { bars, stop, checkpoints: None, fingerprint: 0, curves: Mutex::new(Vec::new()) }
    }

    /// The same with checkpoints, which only a training of the same `fingerprint` goes on from.
    #[must_use]
    pub fn kept(mut self, checkpoints: Option<Checkpoints>, fingerprint: u32) -> Self {
        (self.checkpoints, self.fingerprint) = (checkpoints, fingerprint);
        self
    }

    /// Folder of the checkpoints.
    pub(super) fn folder(&self) -> Option<&Path> {
        self.checkpoints.as_ref().map(|kept| kept.folder.as_path())
    }

    /// Whether to go on from what lies there.
    pub(super) fn resumes(&self) -> bool {
        self.checkpoints.as_ref().is_some_and(|kept| kept.resume)
    }

    /// Digest that distinguishes this training from another.
    pub(super) fn fingerprint(&self) -> u32 {
        self.fingerprint
    }

    /// Whether someone asked to stop.
    #[must_use]
    pub fn stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// Says `what` above the bars.
    pub(super) fn warn(&self, what: &str) {
        // A terminal that is gone is no reason to stop.
        let _ = self.bars.println(what);
    }

    /// Keeps the curve of `stage`.
    pub(super) fn note(&self, stage: &str, looks: Vec<LookAt>) {
        // A stage that panicked has ended the training already.
        let mut curves = self.curves.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        curves.push(Curve { stage: String::from(stage), looks });
    }

    /// All curves, by stage.
    pub fn curves(self) -> Vec<Curve> {
        let mut curves = self.curves.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
        curves.sort_by(|a, b| a.stage.cmp(&b.stage));
        curves
    }

    /// The bar of a stage of `length` steps.
    #[must_use]
    pub fn bar(&self, stage: &str, length: usize) -> Bar {
        let bar = self.bars.add(ProgressBar::new(length as u64));
        let style = ProgressStyle::with_template("{prefix:14} [{bar:32}] {pos}/{len} {msg} {left}");
        let style = style.unwrap_or_else(|_| ProgressStyle::default_bar()).with_key("left", left);
        bar.set_style(style.progress_chars("=> "));
        bar.set_prefix(String::from(stage));
        Bar(bar)
    }
}

impl Bar {
    /// Shows `done` steps with the relative errors on training and validation data.
    pub fn show(&self, done: usize, training: f64, validation: f64) {
        self.0.set_message(format!(
            "training {:.2} %, validation {:.2} %",
            100.0 * training,
            100.0 * validation
        ));
        self.0.set_position(done as u64);
    }

    /// Leaves the last line standing.
    pub fn finish(&self) {
        self.0.abandon();
    }
}

/// Whether the weights are validated after `step` of `steps`: every `every` steps, and after the last.
#[must_use]
pub fn looks_at(step: usize, every: usize, steps: usize) -> bool {
    step % every == every - 1 || step + 1 == steps
}

/// Learning rate that falls from `first` to a fiftieth of it along half a cosine.
#[must_use]
pub fn annealed(first: f64, step: usize, steps: usize) -> f64 {
    let way = step as f64 / steps.max(1) as f64;
    first * (0.02 + 0.98 * 0.5 * (1.0 + (std::f64::consts::PI * way).cos()))
}
