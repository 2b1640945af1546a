//! Ranking of the candidates: a coarse search for every effect, a full fit of the best.

use crate::fitting::fit::{Fitted, fit_beside, free_of};
use crate::fitting::problem::Problem;
use crate::fitting::search::search;
use meniscus::reduced::effects::{Active, Entry};
use nalgebra::DVector;
use rayon::prelude::*;

/// Candidates that are fitted in full after the coarse search.
const FINALISTS: usize = 6;

/// Candidate of the ranking.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// Names of its effects.
    pub names: Vec<&'static str>,
    /// Gain in BIC over none.
    pub gain: f64,
    /// Decrease of the cost by the last of its effects beside the others.
    pub fall: f64,
    /// Full fit; none where the coarse search left it behind.
    pub fitted: Option<Fitted>,
    /// Whitened residual of the coarse search.
    pub signature: DVector<f64>,
}

impl Candidate {
    /// Returns the name of its last effect.
    #[must_use]
    pub fn last(&self) -> &'static str {
        self.names.last().copied().unwrap_or("")
    }
}

/// Returns every effect of `library` beside those of `base`, best first; `plain` is the criterion without any effect.
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
    // Gains of the coarse search are less exact, so candidates without a full fit stay behind.
    found.sort_by(|a, b| {
        let fitted = b.0.fitted.is_some().cmp(&a.0.fitted.is_some());
        fitted.then(b.0.gain.total_cmp(&a.0.gain))
    });
    found.into_iter().map(|(candidate, ..)| candidate).collect()
}
