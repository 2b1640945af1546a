//! Made-up recordings for discovery.

use meniscus::reduced::effects::{Active, find};
use meniscus_discover::baseline::calibrate::Calibration;
use meniscus_discover::recordings::motion_plan::MotionPlan;
use meniscus_discover::recordings::record::Record;
use meniscus_discover::recordings::stated::{CALLIPERS_M, Known};
use meniscus_discover::study::synthetic::synthetic_record;

pub(crate) const KNOWN: Known = Known {
    radius_m: 0.035,
    radius_error_m: CALLIPERS_M,
    fill_m: 0.07,
    density_kg_m3: 1261.0,
    viscosity_pa_s: 0.2,
    motion_share: [1.0; 2],
};
const NOISE_M: f64 = 1e-4;

/// Four recordings of jolts of 2.2 s; the second strongest is held out by the workflow.
pub(crate) fn glass(known: &Known, effects: &[(&str, f64)], seed: u64) -> Vec<Record> {
    let theta = Calibration::blind(&[], 0.0).mean;
    let active: Vec<Active> = effects
        .iter()
        .map(|(name, value)| {
            let entry = find(name).expect("in the library");
            let mut values = entry.neutral();
            values[0] = *value;
            Active { entry, values }
        })
        .collect();
    let strengths = [0.6, 1.25, 2.2, 1.7];
    strengths
        .iter()
        .zip(["a", "b", "c", "d"])
        .enumerate()
        .map(|(i, (strength, name))| {
            let plan = MotionPlan::jolt(0.28, *strength, 2.2);
            synthetic_record(name, known, &plan, &theta, &active, NOISE_M, 100 * seed + i as u64)
                .expect("a motion")
        })
        .collect()
}
