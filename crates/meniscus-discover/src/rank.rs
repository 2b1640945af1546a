//! Candidates in order: every effect searched for, the best of them fitted.

use super::fit::{Fitted, fit_beside, free_of, search};
use super::problem::Problem;
use meniscus::reduced::effects::{Active, Entry};
use nalgebra::DVector;
use rayon::prelude::*;

/// Candidates that are fitted in full after the coarse search.
const FINALISTS: usize = 6;

/// One line of the ranking.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// Names of its effects.
    pub names: Vec<&'static str>,
    /// Gain in BIC over none.
    pub gain: f64,
    /// By how much the last of its effects lowers the cost beside the others.
    pub fall: f64,
    /// The fit; none where the coarse search was enough to leave it behind.
    pub fitted: Option<Fitted>,
    /// What the coarse search left, whitened.
    pub signature: DVector<f64>,
}

impl Candidate {
    /// Name of its last effect.
    #[must_use]
    pub fn last(&self) -> &'static str {
        self.names.last().copied().unwrap_or("")
    }
}

/// Every effect of `library` beside those of `base`, best first: all by the coarse search, the best of
/// them fitted in full. `plain` is the criterion without any effect.
#[must_use]
pub fn rank(problem: &Problem, base: &Fitted, library: &[&'static Entry], plain: f64) -> Vec<Candidate> {
    let count = problem.count();
    let here: Vec<&'static str> = base.active.iter().map(|active| active.entry.name).collect();
    let mut found: Vec<(Candidate, Active, &'static Entry)> = library
        .par_iter()
        .filter(|entry| !here.contains(&entry.name))
        .map(|entry| {
            let (cost, active, signature) = search(problem, base, entry);
            let parameters = base.free.len() + free_of(problem, entry).len();
            let mut names = here.clone();
            names.push(entry.name);
            let gain = plain - cost - parameters as f64 * (count as f64).ln();
            (Candidate { names, gain, fall: base.cost - cost, fitted: None, signature }, active, *entry)
        })
        .collect();
    found.sort_by(|a, b| b.0.gain.total_cmp(&a.0.gain));
    found.par_iter_mut().take(FINALISTS).for_each(|(candidate, active, entry)| {
        let fitted = fit_beside(problem, base, entry, active);
        candidate.gain = plain - fitted.bic(count);
        candidate.fall = base.cost - fitted.cost;
        candidate.fitted = Some(fitted);
    });
    // What was not fitted in full stays behind what was.
    found.sort_by(|a, b| {
        let fitted = b.0.fitted.is_some().cmp(&a.0.fitted.is_some());
        fitted.then(b.0.gain.total_cmp(&a.0.gain))
    });
    found.into_iter().map(|(candidate, ..)| candidate).collect()
}
