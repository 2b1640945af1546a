//! Insertion of the effects of a verdict into the flashed model and the simulator, and the gap that each closes.

use super::error::{DiscoverError, InsertionError};
use super::inputs::Inputs;
use super::progress::{Progress, Stage};
use crate::decision::verdict::Verdict;
use crate::findings::Findings;
use crate::findings::gap::gap_to;
use crate::insert::latent::roll_out;
use crate::insert::simulated::{Resolution, SimulatedCase, simulate};
use crate::insert::simulator::SimulatorFault;
use crate::insert::{self, TrainedLiquid};
use crate::recordings::record::Record;
use crate::recordings::stated::Known;
use crate::sizing::outcome::{HeldOutError, Sizing};
use meniscus::blob::Model;
use meniscus::reduced::Rheology;
use meniscus::reduced::effects::Active;
use meniscus_platform::files::AlignedBytes;

/// Largest relative difference of radius and fill between a model's glass and the recordings'.
const SAME_GLASS: f64 = 0.01;

/// Name of the flashed model in reports.
pub const FLASHED: &str = "the flashed model";

/// Name of the simulator in reports.
pub const SIMULATOR: &str = "the simulator";

/// Error of one model on the held-out recording, m, noise subtracted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosedGap {
    /// Name of the model.
    pub model: &'static str,
    /// Error without the effects.
    pub untouched_m: f64,
    /// Error with the effects.
    pub effect_m: f64,
}

/// Model that did not get the effects.
#[derive(Clone, Debug, PartialEq)]
pub struct Skipped {
    /// Name of the model.
    pub model: &'static str,
    /// Reason.
    pub reason: InsertionError,
}

/// Outcome of the insertion.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Insertion {
    /// Whether a model or a simulation was requested and the verdict has no effect to insert.
    pub nothing_to_insert: bool,
    /// The flashed model with the effects.
    pub blob: Option<Vec<u8>>,
    /// Gaps that were closed.
    pub closed: Vec<ClosedGap>,
    /// Models that did not get the effects.
    pub skipped: Vec<Skipped>,
}

impl Insertion {
    /// Notes that a drawn law goes into none of the models that `inputs` ask for.
    pub(super) fn refuse_law(&mut self, inputs: &Inputs) {
        self.nothing_to_insert = false;
        if inputs.model.is_some() {
            self.skipped.push(Skipped { model: FLASHED, reason: InsertionError::LawInModel });
        }
        if inputs.simulation.is_some() {
            self.skipped.push(Skipped { model: SIMULATOR, reason: InsertionError::LawInSimulator });
        }
    }
}

/// Inserts the effects of `findings` into the models that `inputs` ask for, as `sizing` sized them.
///
/// # Errors
/// [`DiscoverError`], when the flashed model is refused or belongs to another glass.
pub fn insert(
    inputs: &Inputs,
    findings: &Findings,
    sizing: Option<&Sizing>,
    progress: &dyn Progress,
) -> Result<Insertion, DiscoverError> {
    let mut out = Insertion::default();
    let has_effect = matches!(findings.assessment.verdict, Verdict::Identified(_) | Verdict::Ambiguous(_));
    if !has_effect || sizing.is_some_and(Sizing::is_unknown) {
        out.nothing_to_insert = inputs.model.is_some() || inputs.simulation.is_some();
        return Ok(out);
    }
    let sized = sizing.and_then(Sizing::chosen);
    let active = sized.map_or(&findings.assessment.chosen().active, |sized| &sized.active);
    if let Some(bytes) = &inputs.model {
        progress.begins(Stage::InsertIntoModel);
        let model = Model::load(bytes).map_err(DiscoverError::Model)?;
        same_glass(&model, &findings.known)?;
        match flashed(bytes, findings, active) {
            Ok(flashed) => {
                out.blob = Some(flashed.blob);
                out.closed.extend(flashed.closed);
            }
            Err(reason) => out.skipped.push(Skipped { model: FLASHED, reason }),
        }
    }
    if let Some(HeldOutError { untouched_m, effect_m }) = sizing.and_then(|sizing| sizing.held_out) {
        out.closed.push(ClosedGap { model: SIMULATOR, untouched_m, effect_m });
    } else if let (Some(resolution), Some(record)) = (inputs.simulation, &findings.split.held_out) {
        progress.begins(Stage::Simulate);
        match simulated(inputs, findings, record, resolution) {
            Ok(closed) => out.closed.push(closed),
            Err(SimulatorFault::Here(reason)) => {
                out.skipped.push(Skipped { model: SIMULATOR, reason: prediction(reason) });
            }
            Err(fault) => return Err(DiscoverError::Sizing(fault.into())),
        }
    }
    Ok(out)
}

/// Refuses a model of another glass than the recordings'.
fn same_glass(model: &Model<'_>, known: &Known) -> Result<(), DiscoverError> {
    let header = &model.header;
    for (dimension, ours_m, theirs_m) in
        [("radius", header.radius_m, known.radius_m), ("fill", header.fill_m, known.fill_m)]
    {
        if (ours_m / theirs_m - 1.0).abs() > SAME_GLASS {
            return Err(DiscoverError::OtherGlass {
                dimension,
                model_mm: 1e3 * ours_m,
                recordings_mm: 1e3 * theirs_m,
            });
        }
    }
    Ok(())
}

/// Flashed model with the effects.
struct Flashed {
    blob: Vec<u8>,
    /// Gap that it closes, where a recording is held out.
    closed: Option<ClosedGap>,
}

/// Inserts the effects into the flashed model in `bytes`.
fn flashed(bytes: &[u8], findings: &Findings, active: &[Active]) -> Result<Flashed, InsertionError> {
    let known = &findings.known;
    let liquid = TrainedLiquid {
        density_kg_m3: known.density_kg_m3,
        rheology: Rheology::newtonian(known.viscosity_pa_s),
    };
    let blob = insert::insert(bytes, liquid, active)?.blob;
    let (Some(record), Some(gap)) = (&findings.split.held_out, &findings.gap) else {
        return Ok(Flashed { blob, closed: None });
    };
    let error_m = |bytes: &[u8]| -> Result<f64, InsertionError> {
        let model = Model::load(bytes).map_err(InsertionError::Model)?;
        let expected = roll_out(&model, record, findings.calibration.lag_s).map_err(prediction)?;
        Ok(gap_to(record, &expected, gap.gap.noise))
    };
    let closed = ClosedGap {
        model: FLASHED,
        untouched_m: error_m(bytes)?,
        effect_m: error_m(&AlignedBytes::copy(&blob))?,
    };
    Ok(Flashed { blob, closed: Some(closed) })
}

/// Simulates `record` without and with the effects.
fn simulated(
    inputs: &Inputs,
    findings: &Findings,
    record: &Record,
    resolution: Resolution,
) -> Result<ClosedGap, SimulatorFault> {
    let noise_m = findings.gap.as_ref().map_or(0.0, |gap| gap.gap.noise);
    let error_m = |effects: &[Active]| -> Result<f64, SimulatorFault> {
        let case = SimulatedCase { known: &findings.known, effects, resolution };
        let expected = simulate(&*inputs.simulator, &case, record, findings.calibration.lag_s, inputs.stop)?;
        Ok(gap_to(record, &expected, noise_m))
    };
    let untouched_m = error_m(&[])?;
    let effect_m = error_m(&findings.assessment.chosen().active)?;
    Ok(ClosedGap { model: SIMULATOR, untouched_m, effect_m })
}

/// Returns the error of a prediction that failed for `reason`.
fn prediction(reason: impl std::fmt::Display) -> InsertionError {
    InsertionError::Prediction { reason: reason.to_string() }
}
