//! Progress of a run on the terminal.

use crate::bars::style;
use indicatif::{ProgressBar, ProgressStyle};
use meniscus_relearn::{Progress, Stage};
use std::sync::{Mutex, PoisonError};

/// Parts of a bar.
const PARTS: u64 = 1000;

/// Bar of the running stage.
#[derive(Default)]
pub(super) struct Bars(Mutex<Option<ProgressBar>>);

impl Bars {
    /// Takes the bar away.
    pub(super) fn clear(&self) {
        if let Some(bar) = self.0.lock().unwrap_or_else(PoisonError::into_inner).take() {
            bar.finish_and_clear();
        }
    }
}

impl Progress for Bars {
    fn begins(&self, stage: Stage, about: &str) {
        self.clear();
        eprintln!("{}: {about}", stage.name());
        // The training shows bars of its own.
        if matches!(stage, Stage::Identify | Stage::Simulate) {
            let bar = ProgressBar::new(PARTS);
            bar.set_style(
                style(&format!("{} {{wide_bar}} {{percent}} %, {{left}}", stage.name()))
                    .unwrap_or_else(|_| ProgressStyle::default_bar()),
            );
            *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(bar);
        }
    }

    fn advances(&self, share: f64) {
        if let Some(bar) = &*self.0.lock().unwrap_or_else(PoisonError::into_inner) {
            bar.set_position((share * PARTS as f64) as u64);
        }
    }

    fn ends(&self, result: &str) {
        self.clear();
        eprintln!("  {result}");
    }

    fn quiet(&self) -> bool {
        false
    }
}
