//! One optimisation from its first step to its last: weights, Adam, the best so far, the curve, and the file
//! from which all of it goes on after a break.
//!
//! The random numbers of a step follow from the seed and the number of the step alone, so that a resumed run is the
//! same run.

use super::progress::{Bar, LookAt, Session};
use super::weights::{Adam, Matrix};
use crate::seed::derive_seed;
use meniscus_platform::files::write_whole;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Time between two checkpoints.
const EVERY: Duration = Duration::from_secs(10);

/// An optimisation.
#[derive(Debug)]
pub struct Descent {
    state: State,
    file: Option<PathBuf>,
    fingerprint: u32,
    saved: Instant,
}

/// Content of a checkpoint.
#[derive(Debug, Serialize, Deserialize)]
struct State {
    done: usize,
    weights: Vec<Matrix>,
    adam: Adam,
    best: Vec<Matrix>,
    least: f64,
    curve: Vec<LookAt>,
}

impl Descent {
    /// From `weights`, whose validation error is `least`; or from where `stage` stood when it was broken off.
    #[must_use]
    pub fn new(stage: &str, weights: Vec<Matrix>, least: f64, session: &Session<'_>) -> Self {
        let file = session.folder().map(|folder| folder.join(format!("{stage}.postcard")));
        let fingerprint = session.fingerprint();
        let broken_off = file.as_ref().filter(|_| session.resumes()).and_then(|file| {
            let bytes = std::fs::read(file).ok()?;
            let (made_for, state): (u32, State) = postcard::from_bytes(&bytes).ok()?;
            let same = |(a, b): (&Matrix, &Matrix)| (a.rows, a.columns) == (b.rows, b.columns);
            let fits = state.weights.len() == weights.len() && state.weights.iter().zip(&weights).all(same);
            (made_for == fingerprint && fits).then_some(state)
        });
        let fresh = || State {
            done: 0,
            adam: Adam::new(&weights, 1.0),
            best: weights.clone(),
            least,
            curve: Vec::new(),
            weights: weights.clone(),
        };
        Self { state: broken_off.unwrap_or_else(fresh), file, fingerprint, saved: Instant::now() }
    }

    /// Steps that have been done.
    #[must_use]
    pub fn done(&self) -> usize {
        self.state.done
    }

    /// The weights as they stand.
    #[must_use]
    pub fn weights(&self) -> &[Matrix] {
        &self.state.weights
    }

    /// Random numbers of step `step`.
    #[must_use]
    pub fn draws(seed: u64, step: usize) -> ChaCha8Rng {
        ChaCha8Rng::seed_from_u64(derive_seed(seed, step as u64))
    }

    /// Weights and Adam, for a step.
    pub fn parts(&mut self) -> (&mut Vec<Matrix>, &mut Adam) {
        (&mut self.state.weights, &mut self.state.adam)
    }

    /// Takes the relative errors on training and validation data after `done` steps: keeps the weights if they are the
    /// best so far, shows and notes the errors, and writes a checkpoint when it is time or the user asks to stop.
    /// Returns whether to stop.
    pub fn look(&mut self, done: usize, errors: (f64, f64), bar: &Bar, session: &Session<'_>) -> bool {
        let ((training, validation), state) = (errors, &mut self.state);
        state.done = done;
        if validation < state.least {
            (state.best, state.least) = (state.weights.clone(), validation);
        }
        state.curve.push((done as u32, training, validation));
        bar.show(done, training, validation);
        if session.stopped() || self.saved.elapsed() > EVERY {
            self.save(session);
        }
        session.stopped()
    }

    /// Writes the checkpoint; a disk that is full costs the checkpoint, not the training.
    fn save(&mut self, session: &Session<'_>) {
        let Some(file) = &self.file else { return };
        self.saved = Instant::now();
        let written = postcard::to_stdvec(&(self.fingerprint, &self.state))
            .map_err(|error| error.to_string())
            .and_then(|bytes| write_whole(file, &bytes).map_err(|error| error.to_string()));
        if let Err(why) = written {
            session.warn(&format!("no checkpoint, {}: {why}", file.display()));
        }
    }

    /// The best weights and their validation error; the curve goes to the session under `stage`.
    #[must_use]
    pub fn end(mut self, stage: &str, session: &Session<'_>) -> (Vec<Matrix>, f64) {
        // A stage that is done stays done when a later one is broken off.
        self.save(session);
        session.note(stage, self.state.curve);
        (self.state.best, self.state.least)
    }
}
