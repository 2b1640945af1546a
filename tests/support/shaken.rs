//! Made-up recordings for discovery, and folders of them as a stranger would write.

use meniscus::effects::{Active, find};
use meniscus::host::bag::profiles_to_csv;
use meniscus::offline::discover::calibrate::Calibration;
use meniscus::offline::discover::predict::Known;
use meniscus::offline::discover::record::{Record, mean_bow};
use meniscus::offline::discover::study::courses::Course;
use meniscus::offline::discover::study::made_up_with;
use meniscus::surface::{POINTS, SurfaceProfile, profile_abscissa};
use meniscus::units::Micros;
use std::path::{Path, PathBuf};

pub(crate) const KNOWN: Known =
    Known { radius_m: 0.035, fill_m: 0.07, density_kg_m3: 1261.0, viscosity_pa_s: 0.2, told: [1.0; 2] };
const NOISE_M: f64 = 1e-4;

/// Four recordings of jolts of 2.2 s; the third strongest is sealed by the workflow.
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
            let course = Course::jolt(0.28, *strength, 2.2);
            made_up_with(name, known, &course, &theta, &active, NOISE_M, 100 * seed + i as u64)
                .expect("a motion")
        })
        .collect()
}

/// A folder that is gone when the test ends.
pub(crate) struct Scratch(pub(crate) PathBuf);

impl Scratch {
    pub(crate) fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("meniscus-discover-{}-{name}", std::process::id()));
        std::fs::create_dir_all(&path).expect("a folder");
        Self(path)
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // What a failed test did not make cannot be removed.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Writes `records` as a stranger would.
pub(crate) fn write(folder: &Path, records: &[Record], viscosity: f64) {
    std::fs::create_dir_all(folder).expect("a folder");
    let setup =
        format!("radius_m = 0.035\nfill_m = 0.07\ndensity_kg_m3 = 1261.0\nviscosity_pa_s = {viscosity}\n");
    std::fs::write(folder.join("setup.toml"), setup).expect("written");
    for (record, strength) in records.iter().zip([0.6, 1.25, 2.2, 1.7]) {
        let at = |c: usize, f: usize| record.channels[c].value[f].expect("seen");
        let profile = |f: usize| {
            let height = |i: usize| {
                let s = profile_abscissa(i);
                0.07 + at(0, f) + at(1, f) * s + at(2, f) * (2.0 * s * s - 1.0 - mean_bow())
            };
            SurfaceProfile {
                height_m: std::array::from_fn(|i| height(i) as f32),
                variance_m2: [1e-8; POINTS],
                valid: [true; POINTS],
                glass_x_m: Some(at(3, f) as f32),
                sequence: f as u32,
                captured: Micros(1_000_000 + (f as f64 / 60.0 * 1e6).round() as u64),
            }
        };
        let profiles: Vec<_> = (0..record.frames()).map(profile).collect();
        std::fs::write(folder.join(format!("{}.profile.csv", record.name)), profiles_to_csv(&profiles))
            .expect("written");
        let motion = Course::jolt(0.28, strength, 2.2).csv();
        std::fs::write(folder.join(format!("{}.motion.csv", record.name)), motion).expect("written");
    }
}
