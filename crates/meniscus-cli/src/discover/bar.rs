//! Progress of a discovery on a terminal.

use indicatif::ProgressBar;
use meniscus_discover::sizing::workload::SimulationProgress;
use meniscus_discover::workflow::progress::{Progress, Stage};
use std::time::Duration;

/// Bar that shows the stages of a discovery.
pub(super) struct Bar(ProgressBar);

impl Bar {
    /// Returns a bar of so many `stages`; one that is `hidden` shows nothing.
    pub(super) fn new(stages: u64, hidden: bool) -> anyhow::Result<Self> {
        let bar = if hidden { ProgressBar::hidden() } else { crate::bars::bar(stages) };
        bar.set_style(crate::bars::style("{msg:40} {wide_bar} {pos}/{len}, {left}")?);
        bar.enable_steady_tick(Duration::from_millis(200));
        bar.set_message("reading the recordings");
        Ok(Self(bar))
    }

    /// Prints `text` to standard error above the bar.
    pub(super) fn print(&self, text: &str) {
        self.0.suspend(|| eprintln!("{text}"));
    }

    /// Takes the bar away.
    pub(super) fn end(&self) {
        self.0.finish_and_clear();
    }
}

impl Progress for Bar {
    fn begins(&self, stage: Stage) {
        self.0.inc(1);
        self.0.set_message(stage.words());
    }

    fn referenced(&self, progress: SimulationProgress) {
        let SimulationProgress { done, expected, left_s } = progress;
        if done == 0 {
            let guess = left_s.map_or(String::new(), |left_s| {
                format!(", about {} at a first guess for those that are not kept", minutes(left_s))
            });
            self.print(&format!(
                "no --reference: the simulator makes {expected} recordings of the stated liquid{guess}; --no-references leaves \
                 them out"
            ));
        }
        self.0.set_message(format!("reference {done} of {expected}{}", left(left_s)));
    }

    fn simulated(&self, progress: SimulationProgress) {
        let SimulationProgress { done, expected, left_s } = progress;
        if done == 0 {
            let guess = left_s
                .map_or(String::new(), |left_s| format!(", about {} at a first guess", minutes(left_s)));
            self.print(&format!(
                "sizes by simulation: about {expected} simulations{guess}; --quick leaves them out"
            ));
        }
        self.0.set_message(format!("simulation {done} of about {expected}{}", left(left_s)));
    }
}

/// Returns the time that is left in words, where it is known.
fn left(left_s: Option<f64>) -> String {
    left_s.map_or(String::new(), |left_s| format!(", {} left", minutes(left_s)))
}

/// Returns `seconds` in words.
fn minutes(seconds: f64) -> String {
    if seconds < 90.0 { format!("{seconds:.0} s") } else { format!("{:.0} min", seconds / 60.0) }
}
