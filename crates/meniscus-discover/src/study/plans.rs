//! The trials of the study, in an order that serves an interrupted one best.
//!
//! ```text
//! clean     nothing hidden; the tested glass is left out of its references and thresholds
//! hidden    every effect that the simulator or the study applies, at one, two and half its reference size
//! fresh     the same at reference size in a packing that was held out while rules were made
//! without   the same at reference size, with the truth taken out of the library
//! noise     clean with the noise misjudged by half
//! pairs     two at once
//! asked     hidden at reference size and tied, with the recordings that the workflow suggested
//! ```

use super::cases::{HIDDEN_PACKINGS, Hidden, PAIRS, SIZES, VISCOSITY_PA_S, clean, clean_tested, hidden};
use super::trial::{Hand, Trial};
use super::truth::Truth;
use crate::study::motions::MotionKind;
use meniscus::reduced::effects::{Entry, LIBRARY, find};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Raised when a trial comes out otherwise than it did.
const VERSION: u32 = 10;

/// Clean glasses of each kind before anything else is tried, and of the rest.
const KINDS: [MotionKind; 3] = [MotionKind::Single, MotionKind::Double, MotionKind::Slow];

/// Group of trials with one purpose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Family {
    /// None.
    Clean,
    /// One effect.
    Hidden,
    /// One effect, in a glass that was held out while rules were made.
    Fresh,
    /// One effect that the library lacks.
    Without,
    /// None, with the noise misjudged.
    Noise,
    /// Two effects.
    Pair,
    /// One effect, with the suggested recordings; the name stands in digests and files.
    Asked,
}

/// Truth of a trial: the hidden effects.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Answer {
    /// Family.
    pub family: Family,
    /// Effects and their values.
    pub effects: Vec<(String, f64)>,
    /// Size of the effect in units of its reference size; 0 of none.
    pub size: f64,
    /// Liquid, packing and motions, for counting distinct ones.
    pub glass: String,
}

/// One trial to be made.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Truth of the trial.
    pub answer: Answer,
    /// Input of the workflow.
    pub trial: Trial,
    /// Effects that may be named.
    pub library: Vec<&'static Entry>,
    /// Factor on the noise.
    pub noise: f64,
    /// Index of the clean glass that is no reference here, because it is the tested one.
    pub leave_out: Option<usize>,
}

impl Plan {
    /// Returns the name of the judged trial, a digest of everything that goes into it.
    #[must_use]
    pub fn digest(&self) -> String {
        let names: Vec<_> = self.library.iter().map(|entry| entry.name).collect();
        let text = format!(
            "{VERSION} {:?} {} {:?} {names:?} {} {}",
            self.trial,
            self.trial.truth.digest(),
            self.answer,
            self.noise,
            clean(self.trial.truth.kind).len()
        );
        format!("{:016x}", crc::Crc::<u64>::new(&crc::CRC_64_ECMA_182).checksum(text.as_bytes()))
    }

    /// Returns whether its glass is in the cache.
    #[must_use]
    pub fn is_there(&self, cache: &Path) -> bool {
        self.trial.truth.is_there(cache)
    }
}

/// Returns the effect called `name` and the one that no recording here distinguishes from it; nothing where there is
/// none.
#[must_use]
pub fn twins(name: &str) -> Vec<&'static str> {
    let effect = find(name);
    let twin = effect.and_then(|effect| effect.twin).map(|twin| twin.name());
    effect.map(|effect| effect.name).zip(twin).map_or_else(Vec::new, |(one, other)| vec![one, other])
}

/// Returns the trials except those with suggested recordings; `cleans` of them are clean.
#[must_use]
pub fn plans(cleans: usize, seed: u64) -> Vec<Plan> {
    let [known, fresh] = HIDDEN_PACKINGS;
    let all = || LIBRARY.iter().collect::<Vec<_>>();
    let reference =
        |family: Family, packing: u64| hidden().map(move |h| one(&h, 1.0, packing, family, all(), seed));
    let glasses: Vec<(Option<usize>, Truth)> = KINDS.into_iter().flat_map(tested).collect();
    let blank = |number: usize, family: Family, noise: f64| {
        let (leave_out, truth) = &glasses[number % glasses.len()];
        let glass = format!("{:?} {} {}", truth.kind, truth.viscosity_pa_s, truth.packing);
        Plan {
            answer: Answer { family, effects: vec![], size: 0.0, glass },
            trial: Trial {
                truth: truth.clone(),
                hands: vec![],
                stated_viscosity_pa_s: truth.viscosity_pa_s,
                seed: seed + 100 + number as u64,
            },
            library: all(),
            noise,
            leave_out: *leave_out,
        }
    };
    let once = cleans.min(glasses.len());
    let mut out: Vec<Plan> = (0..once).map(|n| blank(n, Family::Clean, 1.0)).collect();
    out.extend(reference(Family::Hidden, known));
    out.extend((once..cleans.min(60)).map(|n| blank(n, Family::Clean, 1.0)));
    out.extend(reference(Family::Fresh, fresh));
    let without = |packing: u64| {
        hidden().map(move |h| {
            let lacks = |e: &&'static Entry| e.kind != h.effect.kind && h.effect.twin != Some(e.kind);
            one(&h, 1.0, packing, Family::Without, LIBRARY.iter().filter(lacks).collect(), seed)
        })
    };
    out.extend(without(known));
    out.extend((0..once).map(|n| blank(n, Family::Noise, if n % 2 == 0 { 1.5 } else { 1.0 / 1.5 })));
    for (a, b) in PAIRS {
        if let (Some(a), Some(b)) = (Hidden::of(a), Hidden::of(b)) {
            let mut plan = one(&a, 1.0, known, Family::Pair, all(), seed);
            plan.trial.hands.push(Hand { effect: b.effect, value: b.value(1.0) });
            plan.answer.effects.push((b.effect.name.into(), b.value(1.0)));
            out.push(plan);
        }
    }
    out.extend((cleans.min(60).max(once)..cleans).map(|n| blank(n, Family::Clean, 1.0)));
    for size in SIZES.into_iter().skip(1) {
        out.extend(hidden().map(|h| one(&h, size, known, Family::Hidden, all(), seed)));
    }
    out.extend(without(fresh));
    out
}

/// Returns the clean glasses of `kind` that are tested, with their place among the references: all of these, and of
/// the single jolts the glasses to which the study applies effects itself and those that are no references.
fn tested(kind: MotionKind) -> Vec<(Option<usize>, Truth)> {
    let mut out: Vec<_> = clean(kind).into_iter().enumerate().map(|(i, truth)| (Some(i), truth)).collect();
    if kind == MotionKind::Single {
        let by_hand = hidden().find(|h| !h.is_simulated());
        out.extend(HIDDEN_PACKINGS.into_iter().filter_map(|p| Some((None, by_hand?.truth(1.0, p, kind)))));
        out.extend(clean_tested().into_iter().map(|truth| (None, truth)));
    }
    out
}

/// Returns the trial of `hidden` at `size` in the glass of this `packing`.
fn one(
    hidden: &Hidden,
    size: f64,
    packing: u64,
    family: Family,
    library: Vec<&'static Entry>,
    seed: u64,
) -> Plan {
    let value = hidden.value(size);
    let hand = Hand { effect: hidden.effect, value };
    let hands = if hidden.is_simulated() { vec![] } else { vec![hand] };
    let truth = hidden.truth(size, packing, MotionKind::Single);
    Plan {
        answer: Answer {
            family,
            effects: vec![(hidden.effect.name.into(), value)],
            size,
            glass: format!("packing {packing}"),
        },
        trial: Trial { truth, hands, stated_viscosity_pa_s: VISCOSITY_PA_S, seed: seed + 10 },
        library,
        noise: 1.0,
        leave_out: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_trial_has_a_name_of_its_own_and_clean_ones_are_of_many_glasses() {
        let plans = plans(118, 1);
        let mut names: Vec<String> = plans.iter().map(Plan::digest).collect();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), plans.len());
        let of = |family: Family| plans.iter().filter(move |p| p.answer.family == family);
        assert_eq!(of(Family::Clean).count(), 118);
        let glasses: std::collections::BTreeSet<_> = of(Family::Clean).map(|p| &p.answer.glass).collect();
        assert!(glasses.len() >= 12, "{glasses:?}");
        assert!(of(Family::Without).all(|p| p.library.iter().all(|e| e.name != p.answer.effects[0].0)));
        // A tested glass is never its own reference.
        for plan in of(Family::Clean) {
            let references = clean(plan.trial.truth.kind);
            let mine = references.iter().position(|truth| *truth == plan.trial.truth);
            assert_eq!(mine, plan.leave_out);
        }
    }

    /// Judged trials and simulated glasses lie under these names on disk.
    #[test]
    fn trials_and_glasses_keep_their_digests() {
        let of = |names: Vec<String>| {
            crc::Crc::<u64>::new(&crc::CRC_64_ECMA_182).checksum(names.concat().as_bytes())
        };
        let trials = of(plans(118, 1).iter().map(Plan::digest).collect());
        let glasses = of(crate::study::cases::truths().iter().map(Truth::digest).collect());
        assert_eq!((trials, glasses), (7_548_278_562_296_396_976, 1_775_601_043_155_280_355));
    }
}
