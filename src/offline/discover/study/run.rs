//! The study: trials written as neutral folders, judged by the workflow, held against the answers after.
//!
//! ```text
//! hidden    every effect that simulator or hands carry, at one, two and half its reference size
//! without   the same at reference size, with the truth taken out of the library
//! pairs     two at once
//! clean     nothing hidden; the tested glass is left out of its references and thresholds
//! noise     clean and hidden with the noise misjudged by half
//! asked     hidden at reference size and not named, with the recordings that the workflow asked for
//! ```
//! A trial's answer lies in `answers.json`, which only this file writes and only [`super::tally`] reads.
//! Every judged trial leaves a file in `judged/`; a study that is run again judges only what is missing.

use super::super::calibrate::Group;
use super::super::load::load;
use super::super::problem::Problem;
use super::super::verdict::{Decision, Thresholds};
use super::super::workflow::{Discovery, Settings, discover, split, thresholds};
use super::cases::{HIDDEN, Hidden, PAIRS, SIZES, VISCOSITY_PA_S, clean};
use super::courses::Kind;
use super::trial::Trial;
use crate::effects::{Active, Entry, LIBRARY, find};
use crate::host::files::write_whole;
use crate::offline::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::string::ToString;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// What a trial belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Family {
    /// One effect.
    Hidden,
    /// One effect that the library lacks.
    Without,
    /// Two effects.
    Pair,
    /// None.
    Clean,
    /// None, with the noise misjudged.
    Noise,
    /// One effect, with what was asked for.
    Asked,
}

/// The answer of a trial: what was truly hidden.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Answer {
    /// Family.
    pub family: Family,
    /// Effects and their values.
    pub effects: Vec<(String, f64)>,
    /// Size of the effect in units of its reference size; 0 of none.
    pub size: f64,
    /// Liquid, packing and course, for counting distinct ones.
    pub glass: String,
}

/// What the workflow said of a trial.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Judged {
    /// none, named, tied or unknown.
    pub verdict: String,
    /// Names.
    pub names: Vec<String>,
    /// Class.
    pub class: Option<String>,
    /// Gain in BIC of the best over none.
    pub gain: f64,
    /// Misfit without and with.
    pub misfit: [f64; 2],
    /// Effect, value, least and largest value of the first free parameter.
    pub estimate: Option<(String, f64, f64, f64)>,
    /// Gap: untouched, nuisances fitted again, black box, effect, and with the true value; mm.
    pub gap_mm: Option<[f64; 5]>,
    /// Which motion was asked for.
    pub asked: Option<usize>,
    /// How long the discovery took, s.
    pub seconds: f64,
}

/// One trial to be made.
struct Plan {
    answer: Answer,
    trial: Trial,
    library: Vec<&'static Entry>,
    noise: f64,
    leave_out: Option<usize>,
}

/// References of one kind of course, with the thresholds that they set.
struct Bench {
    groups: Vec<Group>,
    limits: BTreeMap<Option<usize>, Thresholds>,
}

/// Where the study works.
#[derive(Clone, Debug)]
pub struct Places {
    /// Simulated glasses.
    pub cache: PathBuf,
    /// Trials, answers and what was judged.
    pub out: PathBuf,
}

/// Everything that shares its slot with the effect so exactly that no recording here parts them.
#[must_use]
pub fn twins(name: &str) -> &'static [&'static str] {
    match name {
        "camera_latency" | "actuation_delay" => &["camera_latency", "actuation_delay"],
        "camera_slope" | "container_tilt" => &["camera_slope", "container_tilt"],
        _ => &[],
    }
}

/// Makes and judges the trials: at most `cleans` clean ones. `told` gets what is being done, how many are
/// done and how many there are.
///
/// # Errors
/// In words; what was judged stays.
pub fn judge_all(
    places: &Places,
    cleans: usize,
    seed: u64,
    stop: &AtomicBool,
    told: &dyn Fn(&str, usize, usize),
) -> Result<Vec<(Answer, Judged)>, String> {
    let plans = plans(&places.cache, cleans, seed);
    let mut benches: BTreeMap<Kind, Bench> = BTreeMap::new();
    let mut answers: BTreeMap<String, Answer> = BTreeMap::new();
    let mut out = Vec::new();
    for (number, plan) in plans.iter().enumerate() {
        if stop.load(Ordering::Relaxed) {
            break;
        }
        told("judging trials", number, plans.len());
        let name = format!("t{number:03}");
        answers.insert(name.clone(), plan.answer.clone());
        let file = places.out.join("judged").join(format!("{}.json", digest(plan)));
        if let Some(judged) = std::fs::read(&file).ok().and_then(|bytes| serde_json::from_slice(&bytes).ok())
        {
            out.push((plan.answer.clone(), judged));
            continue;
        }
        let kind = plan.trial.truth.kind;
        if let std::collections::btree_map::Entry::Vacant(slot) = benches.entry(kind) {
            slot.insert(bench(places, kind)?);
        }
        let Some(bench) = benches.get_mut(&kind) else { continue };
        let judged = judge(places, plan, bench, &name)?;
        let text = serde_json::to_string_pretty(&judged).map_err(|error| format!("{error}"))?;
        write_whole(&file, text.as_bytes()).map_err(|error| format!("{error}"))?;
        out.push((plan.answer.clone(), judged));
    }
    asked(places, &plans, &mut out, &mut answers, stop, told)?;
    let text = serde_json::to_string_pretty(&answers).map_err(|error| format!("{error}"))?;
    write_whole(&places.out.join("answers.json"), text.as_bytes()).map_err(|error| format!("{error}"))?;
    Ok(out)
}

/// Gives the workflow what it asked for, where an effect at reference size was tied: the recording that it
/// wanted most and the next in the list, with references in the same motions.
fn asked(
    places: &Places,
    plans: &[Plan],
    out: &mut Vec<(Answer, Judged)>,
    answers: &mut BTreeMap<String, Answer>,
    stop: &AtomicBool,
    told: &dyn Fn(&str, usize, usize),
) -> Result<(), String> {
    let open: Vec<(Hidden, usize)> = out
        .iter()
        .filter(|(a, j)| a.family == Family::Hidden && a.size == 1.0 && j.verdict == "tied")
        .filter(|(a, j)| !j.names.iter().all(|name| twins(&a.effects[0].0).contains(&name.as_str())))
        .filter_map(|(a, j)| Some((*HIDDEN.iter().find(|h| h.name == a.effects[0].0)?, j.asked?)))
        .collect();
    let glasses: Vec<_> =
        clean(Kind::Asked).into_iter().filter(|truth| truth.is_there(&places.cache)).collect();
    if open.is_empty() || glasses.len() < 3 {
        return Ok(());
    }
    let mut groups = Vec::new();
    for (index, truth) in glasses.iter().enumerate() {
        let path = places.out.join(format!("references/both-{index}"));
        if !path.join("setup.toml").exists() {
            let stated_viscosity_pa_s = truth.viscosity_pa_s;
            let single = super::truth::Truth { kind: Kind::Single, ..truth.clone() };
            let both = [(single, &[0, 1, 2, 3][..], b'a'), (truth.clone(), &[0, 1, 2][..], b'e')];
            for (truth, wanted, first) in both {
                let seed = 9500 + index as u64;
                Trial { truth, hands: vec![], stated_viscosity_pa_s, seed }.write(
                    &path,
                    &places.cache,
                    wanted,
                    first,
                )?;
            }
        }
        let folder = load(&path)?;
        groups.push(Group::new(folder.known, folder.records, None)?);
    }
    let mut bench = Bench { groups, limits: BTreeMap::new() };
    for (number, (hidden, course)) in open.iter().enumerate() {
        told("answering what was asked", number, open.len());
        let Some(plan) = plans.iter().find(|p| {
            p.answer.family == Family::Hidden && p.answer.size == 1.0 && p.answer.effects[0].0 == hidden.name
        }) else {
            continue;
        };
        let mut plan = copy(plan);
        plan.answer.family = Family::Asked;
        let file = places.out.join("judged").join(format!("{}.json", digest(&plan)));
        let name = format!("a{number:03}");
        answers.insert(name.clone(), plan.answer.clone());
        if let Some(judged) = std::fs::read(&file).ok().and_then(|bytes| serde_json::from_slice(&bytes).ok())
        {
            out.push((plan.answer, judged));
            continue;
        }
        if stop.load(Ordering::Relaxed) {
            return Ok(());
        }
        let truth = hidden.truth(1.0, Kind::Asked);
        truth.make(&places.cache)?;
        let more = Trial { truth, ..plan.trial.clone() };
        let judged =
            judge_with(places, &plan, &mut bench, &name, Some((&more, &[*course, (*course + 1) % 3])))?;
        let text = serde_json::to_string_pretty(&judged).map_err(|error| format!("{error}"))?;
        write_whole(&file, text.as_bytes()).map_err(|error| format!("{error}"))?;
        out.push((plan.answer, judged));
    }
    Ok(())
}

/// A name for a judged trial that changes with everything that went into it.
fn digest(plan: &Plan) -> String {
    let names: Vec<_> = plan.library.iter().map(|entry| entry.name).collect();
    let text = format!(
        "3 {:?} {} {:?} {names:?} {}",
        plan.trial,
        plan.trial.truth.digest(),
        plan.answer,
        plan.noise
    );
    format!("{:016x}", crc::Crc::<u64>::new(&crc::CRC_64_ECMA_182).checksum(text.as_bytes()))
}

/// The trials whose glasses are in the cache, in an order that serves an interrupted study best.
fn plans(cache: &Path, cleans: usize, seed: u64) -> Vec<Plan> {
    let all = || LIBRARY.iter().collect::<Vec<_>>();
    let one = |hidden: &Hidden, size: f64, family: Family, library: Vec<&'static Entry>| {
        let truth = hidden.truth(size, Kind::Single);
        let value = hidden.value(size);
        let hands = if hidden.simulator.is_none() { vec![(hidden.name, value)] } else { vec![] };
        truth.is_there(cache).then(|| Plan {
            answer: Answer {
                family,
                effects: vec![(hidden.name.into(), value)],
                size,
                glass: "hidden".into(),
            },
            trial: Trial { truth, hands, stated_viscosity_pa_s: VISCOSITY_PA_S, seed: seed + 10 },
            library,
            noise: 1.0,
            leave_out: None,
        })
    };
    let mut out: Vec<Plan> = Vec::new();
    out.extend(HIDDEN.iter().filter_map(|h| one(h, 1.0, Family::Hidden, all())));
    let mut clean_plans = Vec::new();
    let kinds = [Kind::Single, Kind::Double, Kind::Slow];
    let glasses: Vec<_> = kinds
        .into_iter()
        .flat_map(|kind| {
            let there: Vec<_> = clean(kind).into_iter().filter(|truth| truth.is_there(cache)).collect();
            there.into_iter().enumerate()
        })
        .collect();
    for number in 0..cleans {
        let Some((index, truth)) = glasses.get(number % glasses.len().max(1)) else { break };
        let glass = format!("{:?} {} {}", truth.kind, truth.viscosity_pa_s, truth.packing);
        let plan = |family: Family, noise: f64| Plan {
            answer: Answer { family, effects: vec![], size: 0.0, glass: glass.clone() },
            trial: Trial {
                truth: truth.clone(),
                hands: vec![],
                stated_viscosity_pa_s: truth.viscosity_pa_s,
                seed: seed + 100 + number as u64,
            },
            library: all(),
            noise,
            leave_out: Some(*index),
        };
        clean_plans.push(plan(Family::Clean, 1.0));
        if number < glasses.len() {
            clean_plans.push(plan(Family::Noise, if number % 2 == 0 { 1.5 } else { 1.0 / 1.5 }));
        }
    }
    let (first, rest) = clean_plans.split_at(clean_plans.len().min(2 * glasses.len()));
    let mut later = Vec::new();
    let without = |h: &Hidden| {
        let library =
            LIBRARY.iter().filter(|e| e.name != h.name && !twins(h.name).contains(&e.name)).collect();
        one(h, 1.0, Family::Without, library)
    };
    later.extend(HIDDEN.iter().filter_map(without));
    for (a, b) in PAIRS {
        let find_hidden = |name: &str| HIDDEN.iter().find(|h| h.name == name);
        if let (Some(a), Some(b)) = (find_hidden(a), find_hidden(b))
            && let Some(mut plan) = one(a, 1.0, Family::Pair, all())
        {
            plan.trial.hands.push((b.name, b.value(1.0)));
            plan.answer.effects.push((b.name.into(), b.value(1.0)));
            later.push(plan);
        }
    }
    for size in SIZES.into_iter().skip(1) {
        later.extend(HIDDEN.iter().filter_map(|h| one(h, size, Family::Hidden, all())));
    }
    out.extend(first.iter().map(copy));
    out.extend(later);
    out.extend(rest.iter().map(copy));
    out
}

fn copy(plan: &Plan) -> Plan {
    Plan {
        answer: plan.answer.clone(),
        trial: plan.trial.clone(),
        library: plan.library.clone(),
        noise: plan.noise,
        leave_out: plan.leave_out,
    }
}

/// The references of `kind` that are in the cache.
fn bench(places: &Places, kind: Kind) -> Result<Bench, String> {
    let mut groups = Vec::new();
    let there = clean(kind).into_iter().filter(|truth| truth.is_there(&places.cache));
    for (index, truth) in there.enumerate() {
        let path = places.out.join(format!("references/{kind:?}-{index}").to_lowercase());
        let stated_viscosity_pa_s = truth.viscosity_pa_s;
        let trial = Trial { truth, hands: vec![], stated_viscosity_pa_s, seed: 9000 + index as u64 };
        let count = super::courses::courses(kind).len();
        if !path.join("setup.toml").exists() {
            trial.write(&path, &places.cache, &(0..count).collect::<Vec<_>>(), b'a')?;
        }
        let folder = load(&path)?;
        groups.push(Group::new(folder.known, folder.records, None)?);
    }
    if groups.len() < 2 {
        return Err(format!(
            "only {} reference glasses of {kind:?} are simulated: run the study to its end",
            groups.len()
        ));
    }
    Ok(Bench { groups, limits: BTreeMap::new() })
}

/// Writes one trial, lets the workflow judge it, and adds what only the answer can add: the oracle's gap.
fn judge(places: &Places, plan: &Plan, bench: &mut Bench, name: &str) -> Result<Judged, String> {
    judge_with(places, plan, bench, name, None)
}

/// The same with the recordings of `more` beside those of the plan.
fn judge_with(
    places: &Places,
    plan: &Plan,
    bench: &mut Bench,
    name: &str,
    more: Option<(&Trial, &[usize])>,
) -> Result<Judged, String> {
    let path = places.out.join("trials").join(name);
    // What another study left under this name is another trial; what this one left is not rendered again.
    let made = format!("{:?} {} {more:?}", plan.trial, plan.trial.truth.digest());
    let made = crc::Crc::<u64>::new(&crc::CRC_64_ECMA_182).checksum(made.as_bytes()).to_string();
    let mark = path.join("made");
    if std::fs::read_to_string(&mark).ok().as_deref() != Some(&made) {
        let _gone = std::fs::remove_dir_all(&path);
        plan.trial.write(&path, &places.cache, &[0, 1, 2, 3], b'a')?;
        if let Some((trial, wanted)) = more {
            trial.write(&path, &places.cache, wanted, b'e')?;
        }
        write_whole(&mark, made.as_bytes()).map_err(|error| format!("{error}"))?;
    }
    let folder = load(&path)?;
    let settings = Settings { library: plan.library.clone(), noise: plan.noise, ..Settings::default() };
    let groups: Vec<&Group> =
        bench.groups.iter().enumerate().filter(|(i, _)| Some(*i) != plan.leave_out).map(|(_, g)| g).collect();
    let limits = match bench.limits.get(&plan.leave_out) {
        Some(limits) => *limits,
        None => {
            let limits = thresholds(&groups, &Settings::default())?;
            bench.limits.insert(plan.leave_out, limits);
            limits
        }
    };
    let begun = Instant::now();
    let found = discover(&folder.records, folder.known, &groups, limits, &settings)?;
    let seconds = begun.elapsed().as_secs_f64();
    let oracle = oracle_mm(plan, &found, &folder.records, folder.known)?;
    Ok(judged(&found, oracle, seconds))
}

fn judged(found: &Discovery, oracle: Option<f64>, seconds: f64) -> Judged {
    let verdict = &found.verdict;
    let said = verdict.decision != Decision::None;
    Judged {
        verdict: verdict.decision.word().into(),
        names: if said { verdict.names.iter().map(|n| String::from(*n)).collect() } else { vec![] },
        class: verdict.class.filter(|_| said).map(|class| class.words().into()),
        gain: verdict.ranking.first().map_or(0.0, |best| best.gain),
        misfit: [verdict.plain.chi2(verdict.count), verdict.chi2],
        estimate: found.estimates.first().map(|e| (e.effect.into(), e.value, e.interval.0, e.interval.1)),
        gap_mm: found.gap.map(|g| {
            [g.untouched, g.refitted, g.black_box, g.effect, oracle.unwrap_or(f64::NAN) * 1e-3]
                .map(|m| 1e3 * m)
        }),
        asked: found.question.as_ref().map(|q| q.course),
        seconds,
    }
}

/// The gap of the oracle, mm: the true effect at its true size in the reduced model, nuisances fitted.
fn oracle_mm(
    plan: &Plan,
    found: &Discovery,
    records: &[super::super::record::Record],
    known: super::super::predict::Known,
) -> Result<Option<f64>, String> {
    if plan.answer.effects.is_empty() {
        return Ok(None);
    }
    let mut active: Vec<Active> = Vec::new();
    for (name, value) in &plan.answer.effects {
        let Some(entry) = find(name) else { return Ok(None) };
        let mut values = entry.neutral();
        values[0] = *value;
        active.push(Active { entry, values });
    }
    let (fitted, sealed) = split(records);
    let Some(sealed) = sealed else { return Ok(None) };
    let problem = Problem::new(&fitted, known, &found.calibration, plan.noise)?;
    let trusting = problem.trusting(&problem.mean, &active)?;
    let fit = super::super::fit::fit(&trusting, &problem.mean, &active, &[]);
    Ok(Some(1e3 * super::super::workflow::gap_of(&sealed, known, &found.calibration, &fit, plan.noise)?))
}
