//! MotionPlan of the study: trials are written as neutral folders, judged by the workflow, and compared with the answers
//! afterwards.
//!
//! A trial's answer lies in `answers.json`, which only this file writes and only [`super::tally`] reads.
//! Every judged trial leaves a file in `judged/`; a study that is run again judges only what is missing.

use super::bench::{Bench, Judged, StudyFolders, judge};
use super::cases::{HIDDEN_PACKINGS, Hidden, clean, hidden};
use super::error::StudyError;
use super::plans::{Answer, Family, Plan, plans, twins};
use super::trial::Trial;
use crate::sizing::simulations::Shard;
use crate::study::motions::MotionKind;
use meniscus_platform::files::write_whole;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};

/// A trial with its answer.
pub type JudgedTrial = (Answer, Judged);

/// Choices of one run of the study.
#[derive(Clone, Copy, Debug)]
pub struct RunOptions {
    /// Clean trials.
    pub cleans: usize,
    /// Seed.
    pub seed: u64,
    /// Whether anything is judged that was not judged yet.
    pub judges: bool,
    /// Part of the trials that this machine judges; none judges all.
    pub part: Option<Shard>,
    /// Spacing of the particles at which sizes end, m.
    pub spacing_m: f64,
}

impl RunOptions {
    /// Returns whether the trial with this `number` is judged here.
    pub(super) fn judges(&self, number: usize) -> bool {
        self.judges && self.part.is_none_or(|part| part.holds(number as u64))
    }
}

/// Judged trials, and the number of trials that each family is planned to have.
pub type JudgedTrials = (Vec<JudgedTrial>, BTreeMap<Family, usize>);

/// Makes and judges the trials whose glasses are there.
///
/// Where `stop` is set or `options` judge nothing, only earlier results are gathered. `progress` gets the work, how much
/// of it is done and how much there is.
///
/// # Errors
/// [`StudyError`]; what was judged stays.
pub fn judge_all(
    places: &StudyFolders,
    options: RunOptions,
    stop: &AtomicBool,
    progress: &dyn Fn(&str, usize, usize),
) -> Result<JudgedTrials, StudyError> {
    let plans = plans(options.cleans, options.seed);
    let mut planned: BTreeMap<Family, usize> = BTreeMap::new();
    let mut benches: BTreeMap<MotionKind, Bench> = BTreeMap::new();
    let mut answers: BTreeMap<String, Answer> = BTreeMap::new();
    let mut out = Vec::new();
    for (number, plan) in plans.iter().enumerate() {
        *planned.entry(plan.answer.family).or_default() += 1;
        progress("judging trials", number, plans.len());
        let name = format!("t{number:03}");
        answers.insert(name.clone(), plan.answer.clone());
        if let Some(judged) = judged_before(places, plan) {
            out.push((plan.answer.clone(), judged));
            continue;
        }
        let kind = plan.trial.truth.kind;
        let ready = plan.is_there(&places.cache) && clean(kind).iter().all(|t| t.is_there(&places.cache));
        if !options.judges(number) || !ready || stop.load(Ordering::Relaxed) {
            continue;
        }
        if let std::collections::btree_map::Entry::Vacant(slot) = benches.entry(kind) {
            slot.insert(Bench::new(places, kind)?);
        }
        let Some(bench) = benches.get(&kind) else { continue };
        let judged = judge(places, plan, bench, &name, None)?;
        keep(places, plan, &judged)?;
        out.push((plan.answer.clone(), judged));
    }
    // What was suggested is known when all are judged.
    let judges = options.judges && options.part.is_none() && !stop.load(Ordering::Relaxed);
    let followed = Suggested { places, plans: &plans, judges, stop, progress };
    let (lines, open) = followed.judge(&out, &mut answers)?;
    planned.insert(Family::Asked, open);
    out.extend(lines);
    let text = serde_json::to_string_pretty(&answers).map_err(StudyError::Json)?;
    write_whole(&places.out.join("answers.json"), text.as_bytes())?;
    Ok((out, planned))
}

fn file(places: &StudyFolders, plan: &Plan) -> PathBuf {
    places.out.join("judged").join(format!("{}.json", plan.digest()))
}

/// Returns the verdict on `plan` of an earlier run.
pub(super) fn judged_before(places: &StudyFolders, plan: &Plan) -> Option<Judged> {
    serde_json::from_slice(&std::fs::read(file(places, plan)).ok()?).ok()
}

fn keep(places: &StudyFolders, plan: &Plan, judged: &Judged) -> Result<(), StudyError> {
    let text = serde_json::to_string_pretty(judged).map_err(StudyError::Json)?;
    Ok(write_whole(&file(places, plan), text.as_bytes())?)
}

/// Trials with the recordings that the workflow suggested.
struct Suggested<'a> {
    places: &'a StudyFolders,
    plans: &'a [Plan],
    /// Whether anything is judged that was not judged yet.
    judges: bool,
    stop: &'a AtomicBool,
    progress: &'a dyn Fn(&str, usize, usize),
}

impl Suggested<'_> {
    /// Judges each effect at reference size that was ambiguous again, with the suggested recording and the next in the
    /// list, and with references in the same motions. Returns the judged trials and how many there should be.
    fn judge(
        &self,
        lines: &[JudgedTrial],
        answers: &mut BTreeMap<String, Answer>,
    ) -> Result<(Vec<JudgedTrial>, usize), StudyError> {
        let Self { places, plans, .. } = *self;
        let open = ambiguous(lines);
        let mut bench = None;
        let mut out = Vec::new();
        for (number, (hidden, motion)) in open.iter().enumerate() {
            (self.progress)("judging with suggestions", number, open.len());
            let mine = |p: &&Plan| {
                p.answer.family == Family::Hidden
                    && p.answer.size == 1.0
                    && p.answer.effects[0].0 == hidden.effect.name
            };
            let Some(mut plan) = plans.iter().find(mine).cloned() else { continue };
            plan.answer.family = Family::Asked;
            let name = format!("a{number:03}");
            answers.insert(name.clone(), plan.answer.clone());
            if let Some(judged) = judged_before(places, &plan) {
                out.push((plan.answer, judged));
                continue;
            }
            let ready = clean(MotionKind::Asked).iter().all(|truth| truth.is_there(&places.cache));
            if !self.judges || !ready || self.stop.load(Ordering::Relaxed) {
                continue;
            }
            let truth = hidden.truth(1.0, HIDDEN_PACKINGS[0], MotionKind::Asked);
            truth.make(&places.cache).map_err(StudyError::trial)?;
            let more = Trial { truth, ..plan.trial.clone() };
            let bench = match &mut bench {
                Some(bench) => bench,
                none => none.insert(Bench::with_asked(places)?),
            };
            let judged = judge(places, &plan, bench, &name, Some((&more, &[*motion, (*motion + 1) % 3])))?;
            keep(places, &plan, &judged)?;
            out.push((plan.answer, judged));
        }
        Ok((out, open.len()))
    }
}

/// Returns the hidden effects at reference size whose verdict was ambiguous beyond exact twins, each with the index of
/// the suggested motion.
fn ambiguous(lines: &[JudgedTrial]) -> Vec<(Hidden, usize)> {
    lines
        .iter()
        .filter(|(a, j)| a.family == Family::Hidden && a.size == 1.0 && j.verdict == "tied")
        .filter(|(a, j)| !j.names.iter().all(|name| twins(&a.effects[0].0).contains(&name.as_str())))
        .filter_map(|(a, j)| Some((hidden().find(|h| h.effect.name == a.effects[0].0)?, j.suggested?)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_trial_is_of_one_part() {
        let options = |index| RunOptions {
            cleans: 1,
            seed: 1,
            judges: true,
            part: Some(Shard { index, count: 3 }),
            spacing_m: 0.005,
        };
        for number in 0..20 {
            assert_eq!((1..=3).filter(|index| options(*index).judges(number)).count(), 1, "{number}");
        }
        assert!(!RunOptions { judges: false, ..options(1) }.judges(0), "nothing is judged");
        assert!(RunOptions { part: None, ..options(1) }.judges(7), "without parts all are");
    }
}
