//! Long work on a thread of its own, while the calling thread watches for Ctrl-C and hands progress to Python.
//!
//! Only the thread that Python called may run its signal handlers. It gives the interpreter lock back while it waits, so that
//! other threads of the program go on.

use pyo3::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::time::Duration;

/// Longest time from Ctrl-C until it is noticed.
const LOOK: Duration = Duration::from_millis(50);

/// Work that ended early because its flag was raised.
#[derive(Debug)]
pub(crate) struct Stopped;

/// A step of the work: its name and the share that is done.
#[derive(Clone, Debug)]
pub(crate) struct Step {
    pub(crate) what: String,
    pub(crate) done: f64,
}

/// The worker's end of a job.
pub(crate) struct Job {
    /// Raised by Ctrl-C or by a progress callback that failed; for ever, as some of the work keeps it so long.
    pub(crate) stop: &'static AtomicBool,
    steps: Sender<Step>,
}

impl Job {
    /// Reports the share `done` of `what`.
    pub(crate) fn tell(&self, what: impl Into<String>, done: f64) {
        // The other end is there until the work has ended.
        let _ = self.steps.send(Step { what: what.into(), done });
    }
}

/// Runs `work` on another thread and returns its result. `progress`, if there is one, is called with the name of the step and
/// the share of it that is done.
///
/// # Errors
/// `KeyboardInterrupt` after Ctrl-C, or the exception that `progress` raised; the work has ended before.
pub(crate) fn attended<T: Send>(
    py: Python<'_>,
    progress: Option<Py<PyAny>>,
    work: impl FnOnce(&Job) -> T + Send,
) -> PyResult<T> {
    // One byte a call that nobody frees: discovery asks for a flag that lives for ever.
    let stop: &'static AtomicBool = Box::leak(Box::new(AtomicBool::new(false)));
    let (steps, received) = channel();
    py.detach(move || {
        std::thread::scope(|scope| {
            let job = Job { stop, steps };
            let worker = scope.spawn(move || {
                let job = job;
                work(&job)
            });
            let mut failed = None;
            loop {
                let step = match received.recv_timeout(LOOK) {
                    Ok(step) => Some(step),
                    Err(RecvTimeoutError::Timeout) => None,
                    Err(RecvTimeoutError::Disconnected) => break,
                };
                if failed.is_none()
                    && let Err(error) = Python::attach(|py| attend(py, progress.as_ref(), step))
                {
                    stop.store(true, Ordering::Relaxed);
                    failed = Some(error);
                }
            }
            let result = worker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
            failed.map_or(Ok(result), Err)
        })
    })
}

/// Runs Python's signal handlers and the progress callback.
fn attend(py: Python<'_>, progress: Option<&Py<PyAny>>, step: Option<Step>) -> PyResult<()> {
    py.check_signals()?;
    if let (Some(progress), Some(step)) = (progress, step) {
        progress.call1(py, (step.what, step.done))?;
    }
    Ok(())
}
