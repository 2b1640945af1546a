//! Duration of one discovery on recordings of 10 s.

use super::cases::VISCOSITY_PA_S;
use super::error::StudyError;
use super::synthetic::synthetic_record;
use super::truth::DENSITY_KG_M3;
use crate::baseline::calibrate::Calibration;
use crate::baseline::group::Group;
use crate::decision::settings::Settings;
use crate::decision::thresholds::Thresholds;
use crate::recordings::motion_plan::MotionPlan;
use crate::recordings::record::Record;
use crate::recordings::stated::{CALLIPERS_M, Known};
use crate::workflow::discover;
use meniscus::reduced::effects::{Active, EffectKind};
use std::time::Instant;

/// Returns the seconds of one discovery on three recordings of 10 s and a held-out one, with three references.
///
/// The recordings are made up, because the time does not depend on what they show.
///
/// # Errors
/// [`StudyError`], when it fails.
pub fn long_discovery_s() -> Result<f64, StudyError> {
    let known = Known {
        radius_m: 0.035,
        radius_error_m: CALLIPERS_M,
        fill_m: 0.07,
        density_kg_m3: DENSITY_KG_M3,
        viscosity_pa_s: VISCOSITY_PA_S,
        motion_share: [1.0; 2],
    };
    let theta = Calibration::blind(&[], 0.0).mean;
    let make = |known: &Known, seed: u64, active: &[Active]| -> Vec<Record> {
        let plans = [0.6, 1.2, 2.2, 1.7].map(|a| MotionPlan::jolt(0.28, a, 10.0));
        let all = plans.iter().enumerate();
        all.filter_map(|(i, c)| synthetic_record("long", known, c, &theta, active, 1e-4, seed + i as u64))
            .collect()
    };
    let mut groups = Vec::new();
    for (i, factor) in [0.85, 1.0, 1.15].into_iter().enumerate() {
        let known = Known { viscosity_pa_s: factor * known.viscosity_pa_s, ..known };
        groups.push(Group::new(known, make(&known, 10 * i as u64, &[]), None)?);
    }
    let references: Vec<&Group> = groups.iter().collect();
    let entry = EffectKind::YieldStress.effect();
    let records = make(&known, 99, &[Active { entry, values: [1.0, 0.0] }]);
    let begun = Instant::now();
    discover(&records, known, &references, &Thresholds::default(), &Settings::default())?;
    Ok(begun.elapsed().as_secs_f64())
}
