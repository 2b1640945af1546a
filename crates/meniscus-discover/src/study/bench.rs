//! Judging one trial: references and their thresholds, the workflow, and the figures that need the answer.

use super::cases::clean;
use super::error::StudyError;
use super::plans::Plan;
use super::trial::Trial;
use super::truth::Truth;
use crate::baseline::group::Group;
use crate::decision::settings::Settings;
use crate::decision::thresholds::{Shown, Thresholds, limits, shown};
use crate::findings::Findings;
use crate::findings::gap::gap_of;
use crate::fitting::fit::fit;
use crate::fitting::problem::Problem;
use crate::recordings::load::load;
use crate::study::motions::{MotionKind, motions};
use crate::workflow::discover;
use meniscus::reduced::effects::{Active, find};
use meniscus_platform::files::write_whole;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::time::Instant;

/// Folders of the study.
#[derive(Clone, Debug)]
pub struct StudyFolders {
    /// Simulated glasses.
    pub cache: PathBuf,
    /// Trials, answers and judged trials.
    pub out: PathBuf,
}

/// Verdict of the workflow on a trial.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Judged {
    /// none, named, tied or unknown.
    pub verdict: String,
    /// Names.
    pub names: Vec<String>,
    /// Class.
    pub class: Option<String>,
    /// Gain in BIC over no effect.
    pub gain: f64,
    /// Decrease of the cost that the first name had to reach; none without a name.
    pub bound: Option<f64>,
    /// Best effect of the ranking and its gain.
    pub best: Option<(String, f64)>,
    /// Misfit without and with.
    pub misfit: [f64; 2],
    /// Effect, value, least and largest value of the first free parameter.
    pub estimate: Option<(String, f64, f64, f64)>,
    /// Gap: untouched, nuisances fitted again, black box, effect; mm.
    pub gap_mm: Option<[f64; 4]>,
    /// Gap with the true value, mm; none where nothing is hidden.
    pub oracle_mm: Option<f64>,
    /// Index of the motion that was suggested.
    #[serde(rename = "asked")]
    pub suggested: Option<usize>,
    /// Duration of the discovery, s.
    pub seconds: f64,
}

/// References of one kind of motion, with the result of each when the others judge it.
///
/// A tested glass that is itself a reference sets no threshold for itself and calibrates nothing that it is
/// judged by; that it was among those that judged the other references makes their bounds, if anything, lower.
pub struct Bench {
    groups: Vec<Group>,
    shown: Vec<Shown>,
}

/// A glass, which of its motions, and the letter that their names start from.
type Part = (Truth, Vec<usize>, u8);

/// Recordings of another kind of motion that a trial gets beside its own: the glass, and which.
pub type More<'a> = Option<(&'a Trial, &'a [usize])>;

impl Bench {
    /// Returns the references of `kind`.
    ///
    /// # Errors
    /// [`StudyError`], when one is not in the cache or cannot be fitted.
    pub fn new(places: &StudyFolders, kind: MotionKind) -> Result<Self, StudyError> {
        let count = motions(kind).len();
        let every: Vec<usize> = (0..count).collect();
        let parts = |truth: &Truth| vec![(truth.clone(), every.clone(), b'a')];
        Self::of(places, &format!("{kind:?}").to_lowercase(), 9000, clean(kind), &parts)
    }

    /// Returns the references of trials with suggested recordings: the single jolts, and all that may be suggested.
    ///
    /// # Errors
    /// [`StudyError`], when one is not in the cache or cannot be fitted.
    pub fn with_asked(places: &StudyFolders) -> Result<Self, StudyError> {
        let parts = |truth: &Truth| {
            let single = Truth { kind: MotionKind::Single, ..truth.clone() };
            vec![(single, vec![0, 1, 2, 3], b'a'), (truth.clone(), vec![0, 1, 2], b'e')]
        };
        Self::of(places, "both", 9500, clean(MotionKind::Asked), &parts)
    }

    fn of(
        places: &StudyFolders,
        word: &str,
        seed: u64,
        glasses: Vec<Truth>,
        parts: &dyn Fn(&Truth) -> Vec<Part>,
    ) -> Result<Self, StudyError> {
        let mut groups = Vec::new();
        for (index, truth) in glasses.iter().enumerate() {
            let path = places.out.join(format!("references/{word}-{index}"));
            let mark = path.join("made");
            if !mark.exists() {
                for (truth, wanted, first) in parts(truth) {
                    let stated_viscosity_pa_s = truth.viscosity_pa_s;
                    let seed = seed + index as u64;
                    let trial = Trial { truth, hands: vec![], stated_viscosity_pa_s, seed };
                    trial.write(&path, &places.cache, &wanted, first).map_err(StudyError::trial)?;
                }
                write_whole(&mark, b"")?;
            }
            let folder = load(&path)?;
            groups.push(Group::new(folder.known, folder.records, None)?);
        }
        let shown = shown(&groups.iter().collect::<Vec<_>>(), &Settings::default())?;
        Ok(Self { groups, shown })
    }

    /// Returns the references.
    pub(super) fn groups(&self) -> &[Group] {
        &self.groups
    }

    /// Returns the references except `leave_out`, and the thresholds that they set.
    fn against(&self, leave_out: Option<usize>) -> (Vec<&Group>, Thresholds) {
        let kept = self.groups.iter().zip(&self.shown).enumerate().filter(|(i, _)| Some(*i) != leave_out);
        let (groups, shown): (Vec<&Group>, Vec<&Shown>) = kept.map(|(_, both)| both).unzip();
        (groups, limits(&shown, &Settings::default()))
    }
}

/// Writes the trial of `plan` under a neutral `name` with the recordings of `more` beside it, lets the
/// workflow judge it, and adds the gap of the oracle, which needs the answer.
///
/// # Errors
/// [`StudyError`], when a recording is not in the cache, a file cannot be written or a fit fails.
pub fn judge(
    places: &StudyFolders,
    plan: &Plan,
    bench: &Bench,
    name: &str,
    more: More<'_>,
) -> Result<Judged, StudyError> {
    let TimedFindings { findings, seconds } = findings(places, plan, bench, name, more)?;
    let oracle = oracle_mm(plan, &findings)?;
    Ok(judged(&findings, oracle, seconds))
}

/// Findings of a trial.
pub(super) struct TimedFindings {
    /// Findings.
    pub(super) findings: Findings,
    /// Duration of the discovery, s.
    seconds: f64,
}

/// Writes the trial of `plan` as [`judge`] does, and returns the findings of the workflow.
///
/// # Errors
/// [`StudyError`], when a recording is not in the cache, a file cannot be written or a fit fails.
pub(super) fn findings(
    places: &StudyFolders,
    plan: &Plan,
    bench: &Bench,
    name: &str,
    more: More<'_>,
) -> Result<TimedFindings, StudyError> {
    let path = places.out.join("trials").join(name);
    // Files of another study under this name belong to another trial; those of this one are not rendered again.
    let made = format!("{:?} {} {more:?}", plan.trial, plan.trial.truth.digest());
    let made = crc::Crc::<u64>::new(&crc::CRC_64_ECMA_182).checksum(made.as_bytes()).to_string();
    let mark = path.join("made");
    if std::fs::read_to_string(&mark).ok().as_deref() != Some(&made) {
        let _gone = std::fs::remove_dir_all(&path);
        plan.trial.write(&path, &places.cache, &[0, 1, 2, 3], b'a').map_err(StudyError::trial)?;
        if let Some((trial, wanted)) = more {
            trial.write(&path, &places.cache, wanted, b'e').map_err(StudyError::trial)?;
        }
        write_whole(&mark, made.as_bytes())?;
    }
    let folder = load(&path)?;
    let settings = Settings { library: plan.library.clone(), noise: plan.noise, ..Settings::default() };
    let (groups, limits) = bench.against(plan.leave_out);
    let begun = Instant::now();
    let findings = discover(&folder.records, folder.known, &groups, &limits, &settings)?;
    Ok(TimedFindings { findings, seconds: begun.elapsed().as_secs_f64() })
}

fn judged(found: &Findings, oracle_mm: Option<f64>, seconds: f64) -> Judged {
    let (verdict, search) = (&found.assessment.verdict, &found.assessment.search);
    let names = verdict.names();
    Judged {
        verdict: verdict.word().into(),
        class: verdict.class().map(|class| class.words().into()),
        gain: verdict.gain(),
        bound: names.first().map(|name| found.limits.of(name)),
        best: search.ranking.first().map(|best| (best.names.join(" + "), best.gain)),
        names: names.iter().map(|name| String::from(*name)).collect(),
        misfit: [search.plain.chi2(search.count), verdict.misfit()],
        estimate: found.estimates.first().map(|e| {
            let (value, (least, largest)) = e.coordinate;
            (e.effect.into(), value, least, largest)
        }),
        gap_mm: found
            .gap
            .as_ref()
            .map(|g| g.gap)
            .map(|g| [g.untouched, g.refitted, g.black_box, g.effect].map(|m| 1e3 * m)),
        oracle_mm,
        suggested: found.suggestion.as_ref().map(|q| q.plan),
        seconds,
    }
}

/// Returns the gap of the oracle, mm: the true effect at its true size in the reduced model, nuisances fitted.
fn oracle_mm(plan: &Plan, found: &Findings) -> Result<Option<f64>, StudyError> {
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
    let Some(held_out) = &found.split.held_out else { return Ok(None) };
    let problem = Problem::new(&found.split.fitted, found.known, &found.calibration, plan.noise)?;
    let inflated = problem.with_formula_error(&problem.mean, &active, found.rules.formula_error(&active))?;
    let fitted = fit(&inflated, &problem.mean, &active, &[]);
    Ok(Some(1e3 * gap_of(held_out, found.known, &found.calibration, &fitted, plan.noise)?))
}
