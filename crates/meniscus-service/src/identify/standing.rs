//! Present result of the identification: the most probable liquid, and every probability.

use super::MOST;
use meniscus::identify::{Recogniser, Trail};
use serde::Serialize;

/// Probabilities after some profiles.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Standing {
    /// The most probable liquid; nothing where `none` is more probable than each, or nothing has been seen move.
    pub liquid: Option<String>,
    /// Each liquid and its probability, in the order of the notes.
    pub probabilities: Vec<(String, f64)>,
    /// Probability that it is none of them.
    pub none: f64,
    /// Profiles that counted.
    pub profiles: u32,
    /// Turns that the thread had no time for.
    pub left_out: u64,
}

impl Standing {
    /// Returns the probabilities of `recogniser` after `trail`.
    #[must_use]
    pub fn of(names: &[String], recogniser: &Recogniser<'_>, trail: &Trail<MOST>, left_out: u64) -> Self {
        let mut probabilities = vec![0.0; names.len()];
        let verdict = recogniser.verdict(trail, &mut probabilities);
        let best = verdict.best.filter(|_| verdict.profiles > 0).and_then(|index| names.get(index));
        Self {
            liquid: best.cloned(),
            probabilities: names.iter().cloned().zip(probabilities).collect(),
            none: verdict.none,
            profiles: verdict.profiles,
            left_out,
        }
    }

    /// One line for a person, the probable ones first.
    #[must_use]
    pub fn line(&self) -> String {
        if self.profiles == 0 {
            return "nothing has moved yet that could tell".into();
        }
        let mut all: Vec<(&str, f64)> =
            self.probabilities.iter().map(|(name, p)| (name.as_str(), *p)).collect();
        all.push(("none of these", self.none));
        all.sort_by(|a, b| b.1.total_cmp(&a.1));
        let shown = all.iter().enumerate().filter(|(place, (_, p))| *place == 0 || *p >= 0.005);
        let words: Vec<String> = shown.map(|(_, (name, p))| format!("{name} {:.0} %", 100.0 * p)).collect();
        words.join(", ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_begins_with_the_most_probable_and_leaves_out_the_rest() {
        let mut standing = Standing {
            liquid: None,
            probabilities: vec![("water".into(), 0.0001), ("honey".into(), 0.3)],
            none: 0.6999,
            profiles: 4,
            left_out: 0,
        };
        assert_eq!(standing.line(), "none of these 70 %, honey 30 %");
        standing.profiles = 0;
        assert_eq!(standing.line(), "nothing has moved yet that could tell");
    }
}
