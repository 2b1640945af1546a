//! Trials of the drawn law: recordings of the other solver as the workflow gets them, and what is found in each.

use super::laws::{CALIBRATION as CALIBRATION_LAWS, HiddenLaw, JUDGED};
use super::solver::{DENSITY_KG_M3, DEPTH_M, Glass, RADIUS_M};
use crate::baseline::group::Group;
use crate::decision::settings::Settings;
use crate::decision::thresholds::{Thresholds, thresholds};
use crate::law::band::{Bands, CALIBRATION, Calibrated};
use crate::law::draw::{Drawn, draw, drawn};
use crate::recordings::known::{CALLIPERS_M, Known};
use crate::recordings::motion_plan::MotionPlan;
use crate::recordings::record::{Record, channels};
use crate::recordings::tables::drive_of;
use crate::study::error::StudyError;
use crate::study::motions::{MotionKind, motions};
use crate::workflow::discover;
use meniscus::reduced::effects::{Entry, LIBRARY};
use meniscus::surface::{POINTS, SurfaceProfile};
use meniscus::units::{FRAME_INTERVAL_S, Micros};
use meniscus_data::motion::Motion;
use meniscus_numerics::random::normal;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// Noise of one point of a profile, m.
const NOISE_M: f64 = 3e-4;

/// Parts by which a glass differs from the next: frequencies, dampings, second order.
const DIFFERS: [f64; 3] = [0.001, 0.01, 0.05];

/// Viscosity of the liquid in question, Pa s, and of the references.
const VISCOSITY_PA_S: f64 = 0.2;
const REFERENCES_PA_S: [f64; 7] = [0.2, 0.2, 0.17, 0.235, 0.2, 0.17, 0.235];

/// Sizes at which each law is hidden, and the number of clean glasses.
const JUDGED_SIZES: [f64; 2] = [0.9, 0.55];
const CALIBRATION_SIZES: [f64; 2] = [1.0, 0.6];
const CLEAN: u64 = 12;

/// Group of trials with one purpose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Purpose {
    /// Law that is judged.
    Judged,
    /// Law on which bands are calibrated.
    Calibration,
    /// Nothing is hidden.
    Clean,
    /// An effect of the library is hidden.
    Named,
}

/// Library that a trial is judged with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Library {
    /// All effects but those that are the same law as the hidden one.
    Whole,
    /// Only view, clocks and motion of the glass: no formula of a force in the liquid.
    WithoutForces,
}

/// One trial.
#[derive(Clone, Copy, Debug)]
pub struct LawTrial {
    /// Purpose.
    pub purpose: Purpose,
    /// Hidden law.
    pub law: Option<HiddenLaw>,
    /// Library.
    pub library: Library,
    /// Viscosity of the glass, Pa s; stated is the reference's.
    pub viscosity_pa_s: f64,
    /// Factor of the motion of the glass over the stated one.
    pub gain: f64,
    /// Seed of the glass and of the noise.
    pub seed: u64,
}

/// Outcome of one trial.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LawOutcome {
    /// Purpose.
    pub purpose: Purpose,
    /// Name of the hidden law; nothing where none is hidden.
    pub law: String,
    /// Its size.
    pub size: f64,
    /// Library.
    pub library: Library,
    /// Verdict in one word, and its names.
    pub verdict: String,
    /// Names of the verdict.
    pub names: Vec<String>,
    /// Whether the workflow drew a law.
    pub is_drawn: bool,
    /// Reason for which no law is drawn, where the verdict is unknown.
    pub refused: Option<String>,
    /// Law that was found, whatever the verdict is.
    pub found: Option<FoundLaw>,
}

/// A law that was found, beside the hidden one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FoundLaw {
    /// Errors on the held-out recording, mm: untouched, refitted, black box, with the law.
    pub gap_mm: [f64; 4],
    /// Largest distance of the true force and of the true drag from the middle of the bands, in half-widths.
    pub distance: [f64; 2],
    /// Mean half-width of the bands, as a part of the largest force and of the largest drag of the truth.
    pub width: [f64; 2],
    /// Least friction at any rate, N s/m.
    pub least_friction: f64,
    /// Misfit with the law.
    pub misfit: f64,
    /// Nearest formula.
    pub nearest: Option<String>,
    /// Whether the law departs from it by more than a band.
    pub departs: bool,
}

/// Viscosities of the glasses, Pa s, and gains of the motion that hide an effect of the library.
const NAMED: [(f64, f64); 4] = [(0.27, 1.0), (0.15, 1.0), (0.2, 1.1), (0.2, 0.92)];

/// First seeds of the trials by purpose, and of the second size of the calibration. Those of the judged trials were drawn
/// once, after everything was fixed.
const JUDGED_SEED: u64 = 7000;
const CALIBRATION_SEEDS: [u64; 2] = [1024, 1054];
const CLEAN_SEED: u64 = 8000;
const NAMED_SEED: u64 = 9000;

/// Returns all trials.
#[must_use]
pub fn law_trials() -> Vec<LawTrial> {
    let plain = |purpose: Purpose, law: Option<HiddenLaw>, library: Library, seed: u64| LawTrial {
        purpose,
        law,
        library,
        viscosity_pa_s: VISCOSITY_PA_S,
        gain: 1.0,
        seed,
    };
    let mut out = Vec::new();
    for size in JUDGED_SIZES {
        for library in [Library::Whole, Library::WithoutForces] {
            for law in JUDGED {
                let seed = JUDGED_SEED + out.len() as u64;
                out.push(plain(Purpose::Judged, Some(HiddenLaw { size, ..law }), library, seed));
            }
        }
    }
    for (size, first) in CALIBRATION_SIZES.into_iter().zip(CALIBRATION_SEEDS) {
        for (seed, law) in (first..).zip(CALIBRATION_LAWS) {
            let law = Some(HiddenLaw { size, ..law });
            out.push(plain(Purpose::Calibration, law, Library::WithoutForces, seed));
        }
    }
    out.extend((0..CLEAN).map(|i| plain(Purpose::Clean, None, Library::Whole, CLEAN_SEED + i)));
    for (seed, (viscosity_pa_s, gain)) in (NAMED_SEED..).zip(NAMED) {
        let plain = plain(Purpose::Named, None, Library::Whole, seed);
        out.push(LawTrial { viscosity_pa_s, gain, ..plain });
    }
    out
}

/// References of the other solver with the thresholds that they set.
pub struct LawBench {
    groups: Vec<Group>,
    limits: Thresholds,
}

impl LawBench {
    /// Fits all references.
    ///
    /// # Errors
    /// [`StudyError`], when one cannot be fitted.
    pub fn new() -> Result<Self, StudyError> {
        Self::with(REFERENCES_PA_S.len())
    }

    /// Fits the first `count` references.
    ///
    /// # Errors
    /// [`StudyError`], when one cannot be fitted.
    pub fn with(count: usize) -> Result<Self, StudyError> {
        let one = |(number, viscosity_pa_s): (usize, &f64)| {
            let seed = 1 + number as u64;
            Ok(Group::new(
                known(*viscosity_pa_s),
                records(&glass(*viscosity_pa_s, seed), None, 1.0, seed),
                None,
            )?)
        };
        let groups: Vec<Group> =
            REFERENCES_PA_S.iter().take(count).enumerate().map(one).collect::<Result<_, StudyError>>()?;
        let limits = thresholds(&groups.iter().collect::<Vec<_>>(), &Settings::default())?;
        Ok(Self { groups, limits })
    }

    /// Judges `trial`.
    ///
    /// # Errors
    /// [`StudyError`], when the recordings cannot be fitted.
    pub fn judge(&self, trial: &LawTrial) -> Result<LawOutcome, StudyError> {
        let same = trial.law.map_or(&[][..], |law| law.same);
        let wanted = |entry: &&'static Entry| {
            !same.contains(&entry.name) && (trial.library == Library::Whole || !entry.class.in_liquid())
        };
        let library = LIBRARY.iter().filter(wanted).collect();
        let settings = Settings { library, ..Settings::default() };
        let groups: Vec<&Group> = self.groups.iter().collect();
        let mine = glass(trial.viscosity_pa_s, trial.seed);
        let recordings = records(&mine, trial.law.as_ref(), trial.gain, trial.seed);
        let findings = discover(&recordings, known(VISCOSITY_PA_S), &groups, &self.limits, &settings)?;
        let by_workflow = draw(&findings, &settings);
        // Bands are measured without a factor where the factor is to be found.
        let factors = match trial.purpose {
            Purpose::Calibration => Calibrated { force: 1.0, drag: 1.0 },
            Purpose::Judged | Purpose::Clean | Purpose::Named => CALIBRATION,
        };
        let any = if trial.law.is_some() { drawn(&findings, &settings, factors).ok() } else { None };
        let gap = findings.gap.as_ref().map(|measured| measured.gap);
        let found = any.as_ref().zip(gap).zip(trial.law).map(|((law, gap), hidden)| {
            let law_m = law.gap.as_ref().map_or(f64::NAN, |gap| gap.law_m);
            let gap_mm = [gap.untouched, gap.refitted, gap.black_box, law_m].map(|m| 1e3 * m);
            found(law, gap_mm, &hidden, &mine)
        });
        let verdict = &findings.assessment.verdict;
        Ok(LawOutcome {
            purpose: trial.purpose,
            law: trial.law.map_or_else(String::new, |law| law.name.into()),
            size: trial.law.map_or(0.0, |law| law.size),
            library: trial.library,
            verdict: verdict.word().into(),
            names: verdict.names().iter().map(|name| String::from(*name)).collect(),
            is_drawn: matches!(by_workflow, Some(Ok(_))),
            refused: by_workflow.and_then(Result::err).map(|why| why.to_string()),
            found,
        })
    }
}

/// Compares the law `drawn` with the one that is `hidden` in `glass`.
fn found(drawn: &Drawn, gap_mm: [f64; 4], hidden: &HiddenLaw, glass: &Glass) -> FoundLaw {
    let mode = glass.first_mode();
    let Bands { force, drag } = &drawn.bands;
    let true_force: Vec<f64> = force.at.iter().map(|a| hidden.force_n(&mode, *a)).collect();
    let true_drag: Vec<f64> = drag.at.iter().map(|u| hidden.drag_n(&mode, *u)).collect();
    let unit = mode.mass_kg * mode.frequency.powi(2) * drawn.fit.extent.reach_m;
    let width = |half: &[f64]| half.iter().sum::<f64>() / half.len() as f64 / unit;
    let rates = (0..=400).map(|i| drawn.fit.extent.fastest_m_s * f64::from(i) / 300.0);
    FoundLaw {
        gap_mm,
        distance: [force.largest_distance(&true_force), drag.largest_distance(&true_drag)],
        width: [width(&force.half), width(&drag.half)],
        least_friction: rates.map(|u| drawn.fit.law.friction(u)).fold(f64::INFINITY, f64::min),
        misfit: drawn.misfit,
        nearest: drawn.nearest.as_ref().map(|near| near.name.into()),
        departs: drawn
            .nearest
            .as_ref()
            .is_some_and(|near| !near.heights.is_empty() || !near.rates.is_empty()),
    }
}

/// Returns glass and liquid as they are stated.
fn known(viscosity_pa_s: f64) -> Known {
    Known {
        radius_m: RADIUS_M,
        radius_error_m: CALLIPERS_M,
        fill_m: DEPTH_M,
        density_kg_m3: DENSITY_KG_M3,
        viscosity_pa_s,
        motion_share: [1.0; 2],
    }
}

/// Returns the glass of `seed`.
fn glass(viscosity_pa_s: f64, seed: u64) -> Glass {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    Glass { viscosity_pa_s, differs: DIFFERS.map(|part| part * normal(&mut random)) }
}

/// Returns the recordings of the four motions of the study in `glass`, which moves `gain` times as far as is stated.
fn records(glass: &Glass, law: Option<&HiddenLaw>, gain: f64, seed: u64) -> Vec<Record> {
    let plans = motions(MotionKind::Single);
    plans
        .iter()
        .enumerate()
        .filter_map(|(i, plan)| record(glass, plan, law, gain, 100 * seed + i as u64))
        .collect()
}

/// Returns the profiles of `glass` on the path `plan` with the noise of `seed`.
#[must_use]
pub fn profiles(glass: &Glass, plan: &MotionPlan, law: Option<&HiddenLaw>, seed: u64) -> Vec<SurfaceProfile> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let frame = |(number, (heights, place)): (usize, ([f64; POINTS], f64))| {
        let mut noise = || NOISE_M * normal(&mut random);
        SurfaceProfile {
            height_m: heights.map(|z| (DEPTH_M + z + noise()) as f32),
            variance_m2: [(NOISE_M * NOISE_M) as f32; POINTS],
            valid: [true; POINTS],
            glass_x_m: Some((place + 0.3 * noise()) as f32),
            sequence: number as u32,
            captured: Micros((number as f64 * FRAME_INTERVAL_S * 1e6) as u64),
        }
    };
    glass.run(plan, law).into_iter().enumerate().map(frame).collect()
}

/// Returns one recording with the noise of `seed`, in `glass`, which moves `gain` times as far as `plan` states.
fn record(glass: &Glass, plan: &MotionPlan, law: Option<&HiddenLaw>, gain: f64, seed: u64) -> Option<Record> {
    let profiles: Vec<Option<SurfaceProfile>> =
        profiles(glass, &stronger(plan, gain), law, seed).into_iter().map(Some).collect();
    Some(Record {
        name: format!("jolt of {:.2} m/s2", plan.jolts[0].strength_m_s2),
        interval_s: FRAME_INTERVAL_S,
        channels: channels(&profiles, DEPTH_M),
        drive: drive_of(&Motion::sampled(&plan.samples())?, plan.seconds),
        rest_frames: (plan.jolts[0].start_s / FRAME_INTERVAL_S) as usize,
    })
}

/// Returns `plan` with all jolts `gain` times as strong.
fn stronger(plan: &MotionPlan, gain: f64) -> MotionPlan {
    let mut out = plan.clone();
    out.jolts.iter_mut().for_each(|jolt| jolt.strength_m_s2 *= gain);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_law_of_no_library_is_drawn_and_closes_most_of_the_gap_and_a_clean_glass_gets_none() {
        let bench = LawBench::with(4).expect("references");
        let trials = law_trials();
        let hidden = |name: &str| {
            let mine =
                |t: &&LawTrial| t.library == Library::WithoutForces && t.law.is_some_and(|l| l.name == name);
            bench.judge(trials.iter().find(mine).expect("there")).expect("judged")
        };
        for name in ["quadratic drag", "attraction near rest"] {
            let outcome = hidden(name);
            let found = outcome.found.clone().expect("a law");
            assert!(outcome.verdict == "unknown" && outcome.is_drawn, "{outcome:?}");
            assert!(found.gap_mm[3] < 0.4 * found.gap_mm[0], "{outcome:?}");
            assert!(found.least_friction >= 0.0 && found.distance.iter().all(|d| *d < 2.0), "{outcome:?}");
        }
        let clean = trials.iter().find(|t| t.purpose == Purpose::Clean).expect("there");
        let outcome = bench.judge(clean).expect("judged");
        assert!(outcome.verdict == "none" && !outcome.is_drawn && outcome.refused.is_none(), "{outcome:?}");
        let named = trials.iter().find(|t| t.purpose == Purpose::Named).expect("there");
        let outcome = bench.judge(named).expect("judged");
        assert!(outcome.verdict != "unknown" && outcome.names.contains(&"viscosity".into()), "{outcome:?}");
        assert!(!outcome.is_drawn);
    }
}
