//! Verdicts against references that the simulator makes: clean glasses and hidden effects in other packings and spacings.
//!
//! Truth and references are simulated by the same program. So it is counted here whether packing and spacing get a name, and
//! whether an effect is found against such references; what the simulator gets wrong of a real liquid is not.

use super::error::StudyError;
use super::synthetic::synthetic_record;
use crate::baseline::calibrate::Calibration;
use crate::baseline::group::Group;
use crate::baseline::noise::Noise;
use crate::decision::settings::Settings;
use crate::decision::thresholds::{Thresholds, thresholds};
use crate::insert::simulated::{Resolution, SimulatedGlass};
use crate::recordings::motion_plan::MotionPlan;
use crate::recordings::record::{Quantity, Record};
use crate::recordings::stated::{CALLIPERS_M, Known};
use crate::references::{ReferenceSettings, record, simulated_references};
use crate::sizing::error::SizingError;
use crate::sizing::simulations::{Simulations, Wanted};
use crate::sizing::store::SimulationStore;
use crate::workflow::discover;
use crate::workflow::error::DiscoverError;
use meniscus::reduced::effects::{Active, EffectKind, find};
use meniscus_report::checks::Check;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// Glass and liquid of every trial, as stated. It is half as high as the study's, so that a simulation is half the work.
const KNOWN: Known = Known {
    radius_m: 0.035,
    radius_error_m: CALLIPERS_M,
    fill_m: 0.035,
    density_kg_m3: 1261.0,
    viscosity_pa_s: 0.2,
    motion_share: [1.0; 2],
};

/// Spacing of the references, m, and their first packing.
const REFERENCES_M: f64 = 0.007;
const REFERENCE_SEED: u64 = 301;

/// Spacings of the glasses in question, m: none of a reference.
const SPACINGS_M: [f64; 3] = [0.0058, 0.0062, 0.0067];

/// First packing of the glasses in question, and the number of clean ones.
const FIRST_PACKING: u64 = 500;
const CLEAN: usize = 12;

/// Hidden effects with their coordinate in the reduced model.
const HIDDEN: [(EffectKind, f64); 9] = [
    (EffectKind::Viscosity, 1.35),
    (EffectKind::Viscosity, 0.7),
    (EffectKind::YieldStress, 3.0),
    (EffectKind::WallSlip, 0.003),
    (EffectKind::SurfaceTension, 0.3),
    (EffectKind::VerticalAcceleration, 0.7),
    (EffectKind::ActuationGain, 1.1),
    (EffectKind::CameraLatency, 0.033),
    (EffectKind::CameraPitch, 0.05),
];

/// Noise of the channels, m.
const NOISE: [(Quantity, f64); 4] =
    [(Quantity::Level, 5e-5), (Quantity::Slope, 1.5e-4), (Quantity::Bow, 1e-4), (Quantity::Place, 3e-5)];

/// Outcome of one trial.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AgainstSimulator {
    /// Hidden effect; none in a clean glass.
    pub hidden: Option<String>,
    /// Class of the hidden effect, in words.
    pub hidden_class: Option<String>,
    /// Spacing of its particles, m, and its packing.
    pub spacing_m: f64,
    /// Packing.
    pub packing: u64,
    /// Verdict in one word.
    pub verdict: String,
    /// Names of the verdict.
    pub names: Vec<String>,
    /// Class of the verdict, in words.
    pub class: Option<String>,
}

/// Returns the outcomes of all trials; simulations are kept in `folder`. `progress` gets the trials that are done and their
/// number. `stop` ends the work with what is simulated kept.
///
/// # Errors
/// [`StudyError`], when a glass cannot be simulated or a recording cannot be fitted.
pub fn against_simulator(
    folder: &Path,
    stop: Option<&AtomicBool>,
    progress: &dyn Fn(usize, usize),
) -> Result<Vec<AgainstSimulator>, StudyError> {
    let store = SimulationStore::new(folder);
    let watch = |_| {};
    let mut simulations = Simulations::new(&store, &watch);
    simulations.stop = stop;
    let all = CLEAN + HIDDEN.len();
    let none: [Option<(EffectKind, f64)>; CLEAN] = [None; CLEAN];
    let trials: Vec<_> = none.into_iter().chain(HIDDEN.map(Some)).collect();
    let (mut bench, mut out) = (None, Vec::new());
    for (number, hidden) in trials.into_iter().enumerate() {
        progress(number, all);
        let resolution = Resolution {
            spacing_m: SPACINGS_M[number % SPACINGS_M.len()],
            seed: FIRST_PACKING + number as u64,
        };
        let records = recordings(hidden, resolution, &simulations).map_err(ended)?;
        let bench = match &mut bench {
            Some(bench) => bench,
            none => none.insert(Bench::new(&records, folder, &simulations)?),
        };
        let groups: Vec<&Group> = bench.groups.iter().collect();
        let findings = discover(&records, KNOWN, &groups, &bench.limits, &Settings::default())?;
        let verdict = &findings.assessment.verdict;
        out.push(AgainstSimulator {
            hidden: hidden.map(|(kind, _)| kind.name().into()),
            hidden_class: hidden.map(|(kind, _)| kind.effect().class.words().into()),
            spacing_m: resolution.spacing_m,
            packing: resolution.seed,
            verdict: verdict.word().into(),
            names: verdict.names().iter().map(|name| String::from(*name)).collect(),
            class: verdict.class().map(|class| class.words().into()),
        });
    }
    progress(all, all);
    Ok(out)
}

/// Returns the error of the study for simulations that `ended`.
fn ended(ended: SizingError) -> StudyError {
    StudyError::Discover(DiscoverError::Sizing(ended))
}

/// References with their thresholds.
struct Bench {
    groups: Vec<Group>,
    limits: Thresholds,
}

impl Bench {
    /// Simulates references on the motions of `records`, which are those of all trials.
    fn new(records: &[Record], folder: &Path, simulations: &Simulations<'_>) -> Result<Self, StudyError> {
        let settings =
            ReferenceSettings { spacing_m: REFERENCES_M, seed: REFERENCE_SEED, store: folder.into() };
        let references = simulated_references(records, &KNOWN, &settings, simulations).map_err(ended)?;
        let groups = references.into_iter().map(|(known, records)| Group::new(known, records, None));
        let groups: Vec<Group> = groups.collect::<Result<_, _>>()?;
        let limits = thresholds(&groups.iter().collect::<Vec<_>>(), &Settings::default())?;
        Ok(Self { groups, limits })
    }
}

/// Returns the recordings of a glass with the `hidden` effect.
fn recordings(
    hidden: Option<(EffectKind, f64)>,
    resolution: Resolution,
    simulations: &Simulations<'_>,
) -> Result<Vec<Record>, SizingError> {
    let active: Vec<Active> = hidden
        .iter()
        .map(|(kind, value)| {
            let mut values = kind.effect().neutral();
            values[0] = *value;
            Active { entry: kind.effect(), values }
        })
        .collect();
    let refused = |reason| SizingError::NotSimulated { reason };
    let glass = SimulatedGlass::new(&KNOWN, &active, resolution).map_err(refused)?;
    let theta = Calibration::blind(&[], 0.0).mean;
    let like =
        |a: f64| synthetic_record("jolt", &KNOWN, &MotionPlan::jolt(0.28, a, 2.2), &theta, &[], 1e-4, 1);
    let like: Vec<Record> = [0.6, 1.25, 2.2, 1.7].into_iter().filter_map(like).collect();
    let wanted = |r: &Record| Ok(Wanted { setup: glass.setup.clone(), course: glass.course(r)? });
    let batch = like.iter().map(wanted).collect::<Result<Vec<_>, String>>().map_err(refused)?;
    let noise: BTreeMap<Quantity, Noise> = NOISE
        .into_iter()
        .map(|(quantity, sigma_m)| (quantity, Noise { sigma_m, correlation: 0.3 }))
        .collect();
    let heights = simulations.run(&batch)?;
    let one = |(number, (like, heights)): (usize, (&Record, &Result<Vec<f32>, String>))| {
        let heights = heights.as_ref().map_err(|reason| refused(reason.clone()))?;
        let channels = glass.channels(like, heights, 0.0).map_err(refused)?;
        Ok(record(like, channels, &noise, 1000 * resolution.seed + number as u64))
    };
    like.iter().zip(&heights).enumerate().map(one).collect()
}

/// Returns the checks of `outcomes`.
#[must_use]
pub fn simulator_checks(outcomes: &[AgainstSimulator]) -> Vec<Check> {
    let clean: Vec<_> = outcomes.iter().filter(|o| o.hidden.is_none()).collect();
    let hidden: Vec<_> = outcomes.iter().filter(|o| o.hidden.is_some()).collect();
    let of = |word: &str, all: &[&AgainstSimulator]| all.iter().filter(|o| o.verdict == word).count() as f64;
    let if_any = |all: &[&AgainstSimulator], value: f64| if all.is_empty() { f64::NAN } else { value };
    let class_of = |o: &AgainstSimulator| {
        let single = o.names.first().filter(|_| o.verdict == "named").and_then(|name| find(name));
        o.class.clone().or_else(|| single.map(|entry| entry.class.words().into()))
    };
    let stated: Vec<bool> =
        hidden.iter().filter_map(|o| class_of(o).map(|class| Some(class) == o.hidden_class)).collect();
    let right = stated.iter().filter(|right| **right).count() as f64 / stated.len() as f64;
    vec![
        Check::at_most(
            "simulator_references_false_names",
            if_any(&clean, of("named", &clean)),
            "trials",
            1.0,
        ),
        Check::at_least("simulator_references_clean", clean.len() as f64, "trials", 12.0),
        Check::informational("simulator_references_clean_none", if_any(&clean, of("none", &clean)), "trials"),
        Check::informational("simulator_references_hidden", hidden.len() as f64, "trials"),
        Check::informational(
            "simulator_references_hidden_none",
            if_any(&hidden, of("none", &hidden)),
            "trials",
        ),
        Check::informational("simulator_references_class_stated", stated.len() as f64, "trials"),
        Check::at_least("simulator_references_class_right", right, "share", 0.95),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_false_name_and_a_wrong_class_are_counted() {
        let one = |hidden: Option<EffectKind>, verdict: &str, names: &[&str], class: Option<&str>| {
            AgainstSimulator {
                hidden: hidden.map(|kind| kind.name().into()),
                hidden_class: hidden.map(|kind| kind.effect().class.words().into()),
                spacing_m: 0.006,
                packing: 1,
                verdict: verdict.into(),
                names: names.iter().map(|name| String::from(*name)).collect(),
                class: class.map(String::from),
            }
        };
        let outcomes = [
            one(None, "none", &[], None),
            one(None, "named", &["swirl"], Some("shape")),
            one(Some(EffectKind::Viscosity), "tied", &["viscosity", "surface_film"], Some("linear damping")),
            one(Some(EffectKind::Fill), "named", &["viscosity"], Some("linear damping")),
            one(Some(EffectKind::Fill), "unknown", &[], None),
        ];
        let checks = simulator_checks(&outcomes);
        let value = |name: &str| checks.iter().find(|c| c.name.ends_with(name)).and_then(|c| c.value);
        assert_eq!(value("false_names"), Some(1.0));
        assert_eq!(value("class_right"), Some(0.5));
        assert_eq!(value("class_stated"), Some(2.0));
    }
}
