//! Workflow of a discovery: calibrate, decide, localise, suggest, measure the gap, size by simulation, draw a law, insert.
//!
//! [`Discovery::run`] is the whole of it. [`discover`] judges recordings against references that are fitted already,
//! which the study needs for many trials with the same references.

pub mod clocks;
pub mod error;
pub mod inputs;
pub mod insertion;
pub mod progress;
pub mod references;
pub mod report;

use self::clocks::{RANGE_S, aligned};
use self::error::DiscoverError;
use self::inputs::Inputs;
use self::insertion::insert;
use self::progress::{Progress, Stage};
use self::references::{Found, ReferenceOrigin, references};
pub use self::report::Report;
use crate::baseline::calibrate::Calibration;
use crate::baseline::group::Group;
use crate::decision::decide::decide;
use crate::decision::settings::Settings;
use crate::decision::thresholds::{Thresholds, thresholds};
use crate::decision::verdict::Verdict;
use crate::findings::gap::gap;
use crate::findings::isolability::isolability;
use crate::findings::suggest::suggest;
use crate::findings::{Findings, estimates, rivals};
use crate::fitting::error::ProblemError;
use crate::fitting::fit_cache::FitCounts;
use crate::fitting::problem::Problem;
use crate::law::band::CALIBRATION;
use crate::law::draw::drawn;
use crate::recordings::load::RecordingSet;
use crate::recordings::record::Record;
use crate::recordings::split::Split;
use crate::recordings::stated::Known;
use crate::sizing::error::SizingError;
use crate::sizing::outcome::Sizing;
use crate::sizing::simulations::Simulations;
use crate::sizing::stage::size;
use crate::sizing::store::SimulationStore;

/// Standard deviation of a recording's own clock where the setup says that it has one, s.
const OWN_CLOCK_S: f64 = 0.02;

/// Search for the effect that is missing between simulation and measurement.
#[derive(Clone, Copy, Debug)]
pub struct Discovery;

impl Discovery {
    /// Runs all stages on `inputs` and returns the report.
    ///
    /// # Errors
    /// [`DiscoverError`], when recordings are too few or cannot be fitted, or a model is refused.
    ///
    /// # Example
    /// ```no_run
    /// use meniscus_discover::workflow::inputs::Inputs;
    /// use meniscus_discover::recordings::load::{load, load_references};
    /// use meniscus_discover::workflow::progress::Silent;
    /// use meniscus_discover::workflow::Discovery;
    /// use std::path::Path;
    ///
    /// # fn main() -> Result<(), meniscus_discover::workflow::error::DiscoverError> {
    /// let mut inputs = Inputs::new(load(Path::new("mine"))?);
    /// inputs.references = load_references(Path::new("known"))?;
    /// let report = Discovery::run(&inputs, &Silent)?;
    /// println!("{}", report.findings.assessment.verdict.sentence());
    /// # Ok(())
    /// # }
    /// ```
    pub fn run(inputs: &Inputs, progress: &dyn Progress) -> Result<Report, DiscoverError> {
        inputs.check()?;
        let mut settings = inputs.settings.clone();
        if inputs.recordings.own_clocks {
            settings.own_clocks_s = settings.own_clocks_s.or(Some(OWN_CLOCK_S));
        }
        let mut clocks = Vec::new();
        let mut on_clock = |set: &RecordingSet| {
            if !set.own_clocks {
                return set.records.clone();
            }
            let aligned = aligned(&set.records, &set.known, RANGE_S);
            clocks.extend(aligned.clocks);
            aligned.records
        };
        let recordings = on_clock(&inputs.recordings);
        let given = inputs.references.iter().map(|set| (set.known, on_clock(set)));
        let given = given.filter(|(_, records)| !records.is_empty()).collect();
        let Found { references, origin } = references(inputs, given, &recordings, progress)?;
        progress.begins(Stage::FitReferences);
        let groups = references
            .into_iter()
            .map(|(known, records)| Group::cached(known, records, settings.own_clocks_s, &settings.cache));
        let groups = groups.collect::<Result<Vec<Group>, ProblemError>>()?;
        let references: Vec<&Group> = groups.iter().collect();
        progress.begins(Stage::SetThresholds);
        let limits = thresholds(&references, &settings)?;
        progress.begins(Stage::Decide);
        let findings = discover(&recordings, inputs.recordings.known, &references, &limits, &settings)?;
        let fits = settings.cache.as_ref().map_or(FitCounts::default(), |cache| cache.counts());
        // A simulated reference says nothing of the error of the simulator.
        let measured = if origin == ReferenceOrigin::Simulator { &[][..] } else { &groups };
        let sizing = sized(inputs, &findings, measured, progress)?;
        let sizes = sizing.as_ref().and_then(|sizing| sizing.as_ref().ok());
        let is_unknown = matches!(findings.assessment.verdict, Verdict::Unknown(_))
            || sizes.is_some_and(Sizing::is_unknown);
        let law = is_unknown.then(|| {
            progress.begins(Stage::DrawLaw);
            drawn(&findings, &settings, CALIBRATION)
        });
        let mut insertion = insert(inputs, &findings, sizes, progress)?;
        if let Some(Ok(_)) = &law {
            insertion.refuse_law(inputs);
        }
        let simulator = inputs.simulator.name().into();
        Ok(Report { findings, origin, law, sizing, simulator, insertion, clocks, fits })
    }
}

/// Sizes the effects of `findings` by simulation, where that is requested and there is an effect.
fn sized(
    inputs: &Inputs,
    findings: &Findings,
    groups: &[Group],
    progress: &dyn Progress,
) -> Result<Option<Result<Sizing, SizingError>>, DiscoverError> {
    let has_effect = matches!(findings.assessment.verdict, Verdict::Identified(_) | Verdict::Ambiguous(_));
    let Some(settings) = inputs.sizing.as_ref().filter(|_| has_effect) else { return Ok(None) };
    progress.begins(Stage::Size);
    let references: Vec<(Known, &[Record])> =
        groups.iter().map(|group| (group.known, group.records.as_slice())).collect();
    let store = SimulationStore::new(&settings.store);
    let watch = |state| progress.simulated(state);
    let mut simulations = Simulations::new(&store, &watch);
    simulations.simulator = &*inputs.simulator;
    (simulations.shard, simulations.stop) = (settings.shard, inputs.stop);
    match size(findings, &references, settings, &simulations) {
        Err(error) if error.ends_all() => Err(DiscoverError::Sizing(error)),
        outcome => Ok(Some(outcome)),
    }
}

/// Judges `records` of a liquid with the stated properties `known` against `groups` of references and their `limits`.
///
/// # Errors
/// [`DiscoverError`], when recordings are too few or cannot be fitted.
pub fn discover(
    records: &[Record],
    known: Known,
    groups: &[&Group],
    limits: &Thresholds,
    settings: &Settings,
) -> Result<Findings, DiscoverError> {
    if records.len() < 2 {
        return Err(DiscoverError::TooFewRecordings { count: records.len() });
    }
    let split = Split::of(records);
    let calibration = Calibration::from(groups, &known, &split.fitted, settings.own_clocks_s);
    let problem =
        Problem::new(&split.fitted, known, &calibration, settings.noise)?.with_cache(&settings.cache);
    let assessment = decide(&problem, limits, settings);
    // Made before the model error of a formula was added, as the map is.
    let map = assessment.map.clone();
    let isolability = isolability(&problem, &assessment.search.first, &settings.library);
    let suggestion = match assessment.verdict {
        Verdict::Ambiguous(_) => suggest(&problem, &calibration, &assessment),
        _ => None,
    };
    let gap = match &split.held_out {
        Some(held_out) => Some(gap(held_out, &calibration, &problem, &assessment, settings.noise)?),
        None => None,
    };
    Ok(Findings {
        known,
        estimates: estimates(&assessment, &settings.rules, &known.stated()),
        rivals: rivals(&assessment, &settings.rules, &known.stated()),
        split,
        calibration,
        limits: limits.clone(),
        rules: settings.rules,
        assessment,
        map,
        isolability,
        gap,
        suggestion,
    })
}
