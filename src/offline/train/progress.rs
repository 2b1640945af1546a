//! What the user sees while training runs, and how it is asked to stop.

use crate::offline::prelude::*;
use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::sync::atomic::{AtomicBool, Ordering};

/// One run of the trainer: its bars and the flag that Ctrl-C raises.
#[derive(Debug)]
pub(super) struct Session<'a> {
    bars: MultiProgress,
    stop: &'a AtomicBool,
}

/// The bar of one stage.
#[derive(Debug)]
pub(super) struct Bar(ProgressBar);

impl<'a> Session<'a> {
    /// Bars on the terminal unless `quiet`; `stop` ends a stage at its next look.
    #[must_use]
    pub(super) fn new(quiet: bool, stop: &'a AtomicBool) -> Self {
        let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        Self { bars: MultiProgress::with_draw_target(target), stop }
    }

    /// Whether someone asked to stop.
    #[must_use]
    pub(super) fn stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// The bar of a stage of `length` steps.
    #[must_use]
    pub(super) fn bar(&self, stage: &str, length: usize) -> Bar {
        let bar = self.bars.add(ProgressBar::new(length as u64));
        let style = ProgressStyle::with_template("{prefix:14} [{bar:32}] {pos}/{len} {msg} {eta} left");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()).progress_chars("=> "));
        bar.set_prefix(String::from(stage));
        Bar(bar)
    }
}

impl Bar {
    /// Shows `done` steps with the relative errors on training and validation data.
    pub(super) fn show(&self, done: usize, training: f64, validation: f64) {
        self.0.set_message(format!(
            "training {:.2} %, validation {:.2} %",
            100.0 * training,
            100.0 * validation
        ));
        self.0.set_position(done as u64);
    }

    /// Leaves the last line standing.
    pub(super) fn finish(&self) {
        self.0.abandon();
    }
}

/// Learning rate that falls from `first` to a fiftieth of it along half a cosine.
#[must_use]
pub(super) fn annealed(first: f64, step: usize, steps: usize) -> f64 {
    let way = step as f64 / steps.max(1) as f64;
    first * (0.02 + 0.98 * 0.5 * (1.0 + (std::f64::consts::PI * way).cos()))
}
