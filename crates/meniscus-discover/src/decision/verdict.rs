//! Verdict of a discovery: none, identified, ambiguous or unknown, each with its evidence.

use super::evidence::HeldOutScore;
use crate::fitting::fit::Fitted;
use crate::fitting::localise::Cell;
use crate::fitting::rest_offset::RestOffset;
use meniscus::reduced::effects::{Class, find};

/// Effects that explain the discrepancy best, with the evidence for them.
#[derive(Clone, Debug)]
pub struct Claim {
    /// Names of the effects; of an ambiguous verdict also those of the rivals that are not distinguished.
    pub names: Vec<&'static str>,
    /// Class of the effect, where all rivals that are not distinguished are of that class.
    pub class: Option<Class>,
    /// Fit with the effects.
    pub fitted: Fitted,
    /// Gain in BIC over no effect.
    pub gain: f64,
    /// Misfit per number of the fit.
    pub misfit: f64,
    /// Share of bootstrap draws in which the effects stay ahead of their rivals.
    pub inclusion: f64,
    /// Score on recordings that the fit did not see.
    pub held_out: HeldOutScore,
    /// Parameters at the end of their range, in words.
    pub range_ends: Vec<String>,
}

/// Outcome of a discovery.
#[derive(Clone, Debug)]
pub enum Verdict {
    /// Nothing is missing.
    None {
        /// References that it was compared with.
        references: usize,
        /// Misfit per number without an effect.
        misfit: f64,
        /// Largest gain in BIC of an effect that is not significant.
        best_gain: f64,
    },
    /// One effect, or two, are missing, and these are their names.
    Identified(Box<Claim>),
    /// Something is missing, and several effects explain it equally well, or one without sufficient support.
    Ambiguous(Box<Claim>),
    /// Something is missing that the library does not explain.
    Unknown(Unknown),
}

/// Cell of the map of the discrepancy, and its misfit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellMisfit {
    /// Channel.
    pub channel: &'static str,
    /// Window of time.
    pub window: &'static str,
    /// Misfit per number.
    pub misfit: f64,
}

impl CellMisfit {
    /// Returns the misfit of `cell`.
    #[must_use]
    pub fn of(cell: &Cell) -> Self {
        Self { channel: cell.channel, window: cell.window, misfit: cell.chi2 }
    }
}

/// Reason of an `unknown` verdict.
#[derive(Clone, Debug)]
pub enum Unknown {
    /// No effect is significant, and the model without one leaves more than clean glasses show.
    NoSignificantEffect {
        /// Misfit per number without an effect.
        misfit: f64,
        /// Largest gain in BIC of an effect that is not significant.
        best_gain: f64,
        /// Offset at rest beyond that of clean glasses.
        rest_offset: Option<RestOffset>,
        /// Cell of the map with a larger misfit than clean glasses show.
        cell: Option<CellMisfit>,
    },
    /// The best explanation leaves more than clean glasses show.
    Unexplained {
        /// Best explanation.
        nearest: Box<Claim>,
        /// Offset at rest beyond that of clean glasses.
        rest_offset: Option<RestOffset>,
    },
    /// Two effects explain it together, but may stand for one that the library lacks.
    PossiblyConfounded(Box<Claim>),
}

impl Verdict {
    /// Returns the verdict in one word, as the JSON report spells it.
    #[must_use]
    pub fn word(&self) -> &'static str {
        match self {
            Self::None { .. } => "none",
            Self::Identified(_) => "named",
            Self::Ambiguous(_) => "tied",
            Self::Unknown(_) => "unknown",
        }
    }

    /// Returns the effects that explain the discrepancy best, where any is significant.
    #[must_use]
    pub fn claim(&self) -> Option<&Claim> {
        match self {
            Self::Identified(claim)
            | Self::Ambiguous(claim)
            | Self::Unknown(
                Unknown::Unexplained { nearest: claim, .. } | Unknown::PossiblyConfounded(claim),
            ) => Some(claim.as_ref()),
            Self::None { .. } | Self::Unknown(Unknown::NoSignificantEffect { .. }) => None,
        }
    }

    /// Returns the names of the claim; empty without one.
    #[must_use]
    pub fn names(&self) -> &[&'static str] {
        self.claim().map_or(&[], |claim| &claim.names)
    }

    /// Returns the class of the claim, where one is certain.
    #[must_use]
    pub fn class(&self) -> Option<Class> {
        self.claim().and_then(|claim| claim.class)
    }

    /// Returns the gain in BIC over no effect of the claim, or of the best effect where none is significant.
    #[must_use]
    pub fn gain(&self) -> f64 {
        match self {
            Self::None { best_gain, .. } | Self::Unknown(Unknown::NoSignificantEffect { best_gain, .. }) => {
                *best_gain
            }
            _ => self.claim().map_or(0.0, |claim| claim.gain),
        }
    }

    /// Returns the misfit per number of the claim, or of the model without an effect where there is no claim.
    #[must_use]
    pub fn misfit(&self) -> f64 {
        match self {
            Self::None { misfit, .. } | Self::Unknown(Unknown::NoSignificantEffect { misfit, .. }) => *misfit,
            _ => self.claim().map_or(f64::NAN, |claim| claim.misfit),
        }
    }

    /// Returns the offset at rest beyond that of clean glasses.
    #[must_use]
    pub fn rest_offset(&self) -> Option<RestOffset> {
        match self {
            Self::Unknown(
                Unknown::NoSignificantEffect { rest_offset, .. } | Unknown::Unexplained { rest_offset, .. },
            ) => *rest_offset,
            _ => None,
        }
    }

    /// Returns the cell of the map with a larger misfit than clean glasses show, where no effect is significant.
    #[must_use]
    pub fn cell(&self) -> Option<CellMisfit> {
        match self {
            Self::Unknown(Unknown::NoSignificantEffect { cell, .. }) => *cell,
            _ => None,
        }
    }

    /// Returns the verdict in a sentence.
    #[must_use]
    pub fn sentence(&self) -> String {
        let names = self.names();
        let gain = self.gain();
        match self {
            Self::None { references: 0, .. } => String::from(
                "Nothing is missing as far as can be said without references: the plain model is within the error of 5 % \
                 of the signal that it is allowed, and effects of that size do not show.",
            ),
            Self::None { references, .. } => format!(
                "Nothing is missing: the model explains these recordings as well as it explains {}.",
                if *references == 1 {
                    "its one reference".into()
                } else {
                    format!("its {references} references")
                }
            ),
            Self::Identified(_) => {
                let about = |name: &str| find(name).map_or("", |entry| entry.about);
                let each: Vec<String> =
                    names.iter().map(|name| format!("{name}, that is, {}", about(name))).collect();
                format!("Missing is {} (BIC {gain:.0} lower than without an effect).", each.join("; and "))
            }
            Self::Ambiguous(claim) => {
                let class = claim.class.map_or(String::new(), |class| format!(" (class: {})", class.words()));
                let open = match names {
                    [one] => format!("confirm that it is {one}"),
                    names => format!("distinguish {}", names.join(", ")),
                };
                let ends = self.caution();
                format!(
                    "Something is missing{class}, and these recordings do not {open} (BIC {gain:.0} lower than without an effect).{ends}"
                )
            }
            Self::Unknown(Unknown::PossiblyConfounded(_)) => format!(
                "Something is missing that no single effect of the library explains: {} do it together (BIC \
                 {gain:.0} lower than without an effect), but so may one that the library lacks.{}",
                names.join(" and "),
                self.caution()
            ),
            Self::Unknown(_) => format!(
                "Something is missing that the library does not explain: the best of it leaves a misfit of {:.2}; \
                 nearest is {}.{}{}{}",
                self.misfit(),
                if names.is_empty() { "nothing".into() } else { names.join(" + ") },
                self.rest_offset().map_or(String::new(), |offset| format!(
                    " At rest the {} is offset by {:.2} mm.",
                    offset.quantity.words(),
                    1e3 * offset.m
                )),
                self.cell().map_or(String::new(), |cell| format!(
                    " The {} during {} has a misfit of {:.1}.",
                    cell.channel, cell.window, cell.misfit
                )),
                self.caution()
            ),
        }
    }

    /// Returns a sentence about parameters at the end of their range; empty where there is none.
    fn caution(&self) -> String {
        let ends = self.claim().map_or(&[][..], |claim| &claim.range_ends);
        if ends.is_empty() { String::new() } else { format!(" Not to be trusted: {}.", ends.join("; ")) }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::recordings::record::Quantity;
    use nalgebra::{DMatrix, DVector};

    /// Returns a claim of `names` with made-up evidence and an empty fit.
    pub(crate) fn claim(names: &[&'static str], range_ends: &[&str]) -> Box<Claim> {
        let fitted = Fitted {
            theta: Vec::new(),
            active: Vec::new(),
            free: Vec::new(),
            cost: 0.0,
            residual: DVector::zeros(0),
            jacobian: DMatrix::zeros(0, 0),
        };
        Box::new(Claim {
            names: names.to_vec(),
            class: Some(Class::Timing),
            fitted,
            gain: 120.0,
            misfit: 1.5,
            inclusion: 0.7,
            held_out: HeldOutScore { better: 2, recordings: 3, improvement: 4.0 },
            range_ends: range_ends.iter().map(|end| String::from(*end)).collect(),
        })
    }

    #[test]
    fn each_verdict_has_the_word_of_the_file_format_and_its_evidence() {
        let none = Verdict::None { references: 3, misfit: 1.1, best_gain: 6.0 };
        assert_eq!((none.word(), none.names().len(), none.gain(), none.misfit()), ("none", 0, 6.0, 1.1));
        let identified = Verdict::Identified(claim(&["foam"], &[]));
        assert_eq!((identified.word(), identified.names()), ("named", &["foam"][..]));
        assert_eq!((identified.gain(), identified.misfit()), (120.0, 1.5));
        let ambiguous = Verdict::Ambiguous(claim(&["camera_latency", "actuation_delay"], &[]));
        assert_eq!((ambiguous.word(), ambiguous.class()), ("tied", Some(Class::Timing)));
        let confounded = Verdict::Unknown(Unknown::PossiblyConfounded(claim(&["foam", "fill"], &[])));
        assert_eq!((confounded.word(), confounded.rest_offset()), ("unknown", None));
    }

    #[test]
    fn nothing_missing_names_the_references_that_it_was_compared_with() {
        let sentence =
            |references: usize| Verdict::None { references, misfit: 1.1, best_gain: 6.0 }.sentence();
        assert!(sentence(0).contains("without references"), "{}", sentence(0));
        assert!(!sentence(0).contains("its references"), "{}", sentence(0));
        assert!(sentence(7).ends_with("as well as it explains its 7 references."), "{}", sentence(7));
    }

    #[test]
    fn the_sentence_holds_what_is_open() {
        let ambiguous = Verdict::Ambiguous(claim(&["camera_latency", "actuation_delay"], &[]));
        let sentence = ambiguous.sentence();
        assert!(sentence.contains("(class: timing)"), "{sentence}");
        assert!(
            sentence.contains("distinguish camera_latency, actuation_delay (BIC 120 lower"),
            "{sentence}"
        );
        let rest_offset = Some(RestOffset { quantity: Quantity::Bow, m: 5e-4 });
        let nearest = claim(&["foam"], &["the depth of foam stands at the end of its range"]);
        let unknown = Verdict::Unknown(Unknown::Unexplained { nearest, rest_offset });
        let sentence = unknown.sentence();
        assert!(sentence.contains("a misfit of 1.50; nearest is foam."), "{sentence}");
        assert!(sentence.contains("At rest the bow is offset by 0.50 mm."), "{sentence}");
        assert!(sentence.ends_with("Not to be trusted: the depth of foam stands at the end of its range."));
        let empty = Unknown::NoSignificantEffect { misfit: 1.4, best_gain: 3.0, rest_offset, cell: None };
        assert!(Verdict::Unknown(empty).sentence().contains("nearest is nothing."));
    }
}
