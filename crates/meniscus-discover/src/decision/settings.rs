//! Settings of a discovery.

use super::rules::DecisionRules;
use crate::fitting::fit_cache::FitCache;
use meniscus::reduced::effects::{Entry, LIBRARY};
use std::sync::Arc;

/// Choices that hold for all stages of one discovery.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Effects that may be named.
    pub library: Vec<&'static Entry>,
    /// Constants of the decision.
    pub rules: DecisionRules,
    /// Seed of the bootstrap.
    pub seed: u64,
    /// Factor on the noise of the rest frames; 1 unless the noise is misjudged on purpose.
    pub noise: f64,
    /// Standard deviation of each recording's own clock, s, where it has one.
    pub own_clocks_s: Option<f64>,
    /// Cache of fits, with which an interrupted discovery goes on.
    pub cache: Option<Arc<FitCache>>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            library: LIBRARY.iter().collect(),
            rules: DecisionRules::default(),
            seed: 1,
            noise: 1.0,
            own_clocks_s: None,
            cache: None,
        }
    }
}
