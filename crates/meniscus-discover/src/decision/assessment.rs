//! Verdict together with the fits that led to it.

use super::rank::Candidate;
use super::verdict::Verdict;
use crate::fitting::fit::Fitted;
use crate::fitting::localise::Cell;

/// Fits that were made on the way to a verdict.
#[derive(Clone, Debug)]
pub struct Search {
    /// Fit without any effect, before the model error of an effect's formula was added.
    pub first: Fitted,
    /// Fit without any effect.
    pub plain: Fitted,
    /// Single effects, best first.
    pub ranking: Vec<Candidate>,
    /// Pairs with the best single effect, best first.
    pub pairs: Vec<Candidate>,
    /// Numbers that were measured.
    pub count: usize,
}

/// Verdict with the fits that led to it.
#[derive(Clone, Debug)]
pub struct Assessment {
    /// Fits.
    pub search: Search,
    /// Verdict.
    pub verdict: Verdict,
    /// Discrepancy of the model without an effect, before the model error of a formula was added.
    pub map: Vec<Cell>,
}

impl Assessment {
    /// Returns the fit of the claim, or the one without an effect where there is no claim.
    #[must_use]
    pub fn chosen(&self) -> &Fitted {
        self.verdict.claim().map_or(&self.search.plain, |claim| &claim.fitted)
    }
}
