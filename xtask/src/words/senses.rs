//! Words of our own that have a term in the field: one regular expression for each sense.

use regex::{Regex, RegexBuilder};
use std::sync::LazyLock;

/// A sense, and the term to write instead.
pub(super) struct Sense {
    pub(super) pattern: Regex,
    pub(super) instead: &'static str,
}

/// Patterns and terms. Case does not matter, and inline code is not searched.
///
/// A word alone is in the list only where its common sense is not needed: "line" and "memory" have uses that are right.
const SENSES: &[(&str, &str)] = &[
    (
        r"\btold (motion|acceleration|position|place)s?\b|\b(motion|what) is told\b",
        "commanded or measured motion",
    ),
    (r"\b(is|are|only|miss|not) told[.;,)]", "reported, or informational (a check)"),
    (r"\bforetold\b|\bforetell(s|ing)?\b", "predicted, predicts"),
    (r"\basked for\b", "target, or requested"),
    (r"\bmiss(es)? by\b|\bmissed by [0-9]", "has an error of"),
    (
        r"(^|%|,|[0-9]|half|third|tenth) of the slosh\b|\bsurface,? of the slosh\b",
        "relative to the slosh amplitude",
    ),
    (r"\bway of the glass\b|\b(tenth|fifth|quarter|third|half|[0-9]) of the way\b", "travel, path"),
    (r"\bplaces? of the glass\b|\bglass's place\b", "position"),
    (r"\b(a|the|each|every|small|steady|last|of|over latents,) push(es)?\b", "acceleration input"),
    (r"\bbeliefs?\b|\bbelieved\b|\bdisbelie(f|ved)\b", "covariance, weight, accepted, significant"),
    (r"\bdoubts?\b|\bsurprises?\b", "noise scale, normalised innovation"),
    (r"\bthe strays?\b|\bstray of\b", "noise scale"),
    (r"\b(intervals?|heights?|bands?) (that should )?(holds?|held)\b|\bheld intervals?\b", "coverage"),
    (r"\bsealed\b", "held-out"),
    (r"\badopt(s|ed|ing|ion)?\b", "insert an effect"),
    (r"\ba tie\b|\b(be|is|are|was|were|can only be) tied\b|\btied with\b", "ambiguous"),
    (r"\bthin(ner|nest)? liquids?\b", "low-viscosity liquid"),
    (r"\bthick(er|est)? liquids?\b", "high-viscosity liquid"),
    (r"\bmemory of (a|the|its) (liquid|fluid)\b|\bliquid'?s? memory\b", "viscoelastic relaxation"),
    (
        r"\bone memory of the\b|\ba memory (relaxes|much|shorter)\b|\btied with a memory\b|\bfoam and memory\b",
        "viscoelastic relaxation",
    ),
    (r"\bstoreys?\b", "layer"),
    (r"\btold apart\b|\b(tell|tells|telling)( \S+){0,3} apart\b", "distinguished, distinguish"),
    (r"\b(it|this|that) costs\b|\bof the way costs\b", "the name of the figure that gets worse"),
];

/// The senses with their patterns compiled.
pub(super) static FORBIDDEN: LazyLock<Vec<Sense>> = LazyLock::new(|| {
    let compiled = |&(pattern, instead): &(&str, &'static str)| {
        let pattern = RegexBuilder::new(pattern).case_insensitive(true).build().expect("a regex");
        Sense { pattern, instead }
    };
    SENSES.iter().map(compiled).collect()
});

#[cfg(test)]
mod tests {
    use super::*;

    fn found(text: &str) -> Vec<&'static str> {
        FORBIDDEN.iter().filter(|sense| sense.pattern.is_match(text)).map(|sense| sense.instead).collect()
    }

    #[test]
    fn every_sense_is_found_once() {
        let bad = [
            "sigma under a told motion",
            "faster rates are told.",
            "the surface that was foretold",
            "180 s are asked for",
            "the surface misses by 3 %",
            "3.0 % of the slosh",
            "a tenth of the way out of line",
            "the place of the glass",
            "an IMU reports a push",
            "an effect is believed when it lowers the cost",
            "a height and its doubt",
            "the stray of a reading",
            "the interval holds 81 %",
            "three recordings and one sealed",
            "an effect is adopted",
            "only a tie needs a recording",
            "thin liquids come to rest late",
            "in a thicker liquid",
            "Memory of the liquid: a Maxwell branch",
            "a memory relaxes",
            "a crate of a lower storey",
            "what tells liquids apart",
            "what it costs",
        ];
        assert_eq!(bad.len(), SENSES.len());
        for (text, sense) in bad.iter().zip(FORBIDDEN.iter()) {
            assert!(sense.pattern.is_match(text), "`{text}` is not found as a word for {}", sense.instead);
        }
    }

    #[test]
    fn common_uses_are_left_alone() {
        let good = [
            "the contact line and a line of text",
            "resident memory of this process",
            "two images, three frame intervals apart",
            "modes of the slosh",
            "the camera pushes a status packet",
            "a thin film",
            "stray light",
            "the buffer that holds a frame",
        ];
        for text in good {
            assert_eq!(found(text), [""; 0], "{text}");
        }
    }
}
