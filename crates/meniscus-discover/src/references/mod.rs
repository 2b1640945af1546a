//! References that the simulator makes where a person has none.
//!
//! ```text
//! recordings, stated liquid and glass --glasses--> set-ups --simulations--> heights on disk --records--> references
//! ```
//! They are glasses of the stated liquid, and of one that is a fifth more viscous, on the motions of the recordings: several
//! packings at two spacings, so that what packing and spacing change counts as scatter and not as an effect. A verdict
//! against them says where simulation and measurement disagree. It cannot tell an effect of the liquid from an error of the
//! simulator.
//!
//! | file | purpose |
//! |---|---|
//! | `glasses` | glasses that are simulated, and the work that they are |
//! | `records` | simulated heights as recordings with the noise of the measured ones |

pub mod glasses;
mod records;

use self::glasses::{GLASSES, ReferencePlan};
pub(crate) use self::records::record;
use crate::baseline::noise::rest_noise;
use crate::recordings::record::Record;
use crate::recordings::stated::Known;
use crate::sizing::error::SizingError;
use crate::sizing::simulations::Simulations;
use std::path::PathBuf;

/// Settings of references by simulation.
#[derive(Clone, Debug, PartialEq)]
pub struct ReferenceSettings {
    /// Spacing of the particles of most glasses, m.
    pub spacing_m: f64,
    /// Seed of the first packing.
    pub seed: u64,
    /// Folder of the simulations.
    pub store: PathBuf,
}

/// Coarsest spacing of references in units of the radius.
const COARSEST: f64 = 0.2;

/// Spacing of most references, m: the search of the sizes begins there too.
const SPACING_M: f64 = 0.007;

/// First packing of the references less the seed: others than those of the sizes.
const FIRST_PACKING: u64 = 300;

impl ReferenceSettings {
    /// Returns the settings for a glass of `radius_m` with the `seed` of the discovery.
    #[must_use]
    pub fn new(radius_m: f64, seed: u64, store: PathBuf) -> Self {
        Self { spacing_m: SPACING_M.min(COARSEST * radius_m), seed: FIRST_PACKING + seed, store }
    }
}

/// One simulated reference: what is known of it, and its recordings.
pub type SimulatedReference = (Known, Vec<Record>);

/// Makes the references of `records` of the liquid `known`, or takes them from the store of `simulations`.
///
/// # Errors
/// [`SizingError`], when a motion or the glass cannot be simulated, or the work ends early.
pub fn simulated_references(
    records: &[Record],
    known: &Known,
    settings: &ReferenceSettings,
    simulations: &Simulations<'_>,
) -> Result<Vec<SimulatedReference>, SizingError> {
    let plan = ReferencePlan::new(records, known, settings, simulations.simulator)?;
    plan.announce(simulations);
    let batch: Vec<_> = plan.wanted.iter().flatten().cloned().collect();
    let heights = simulations.run(&batch)?;
    let noise = rest_noise(records);
    let refused = |reason| SizingError::NotSimulated { reason };
    let mut out = Vec::with_capacity(GLASSES.len());
    for (number, (glass, heights)) in plan.glasses.iter().zip(heights.chunks(records.len())).enumerate() {
        let one = |(which, (like, heights)): (usize, (&Record, &Result<Vec<f32>, String>))| {
            let heights = heights.as_ref().map_err(|reason| refused(format!("{}: {reason}", like.name)))?;
            let channels = glass.seen.channels(like, heights, 0.0).map_err(refused)?;
            let seed = settings.seed.wrapping_mul(1000).wrapping_add((number * 100 + which) as u64);
            Ok(record(like, channels, &noise, seed))
        };
        let all: Result<Vec<Record>, SizingError> =
            records.iter().zip(heights).enumerate().map(one).collect();
        out.push((glass.known, all?));
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::insert::simulator::Particles;
    use crate::recordings::motion_plan::MotionPlan;
    use crate::recordings::stated::CALLIPERS_M;
    use crate::sizing::store::{SimulationStore, digest};
    use crate::study::synthetic::synthetic_record;
    use meniscus::surface::POINTS;
    use std::sync::atomic::Ordering;

    const KNOWN: Known = Known {
        radius_m: 0.035,
        radius_error_m: CALLIPERS_M,
        fill_m: 0.05,
        density_kg_m3: 1261.0,
        viscosity_pa_s: 0.2,
        motion_share: [1.0; 2],
    };

    fn records() -> Vec<Record> {
        let theta = crate::baseline::calibrate::Calibration::blind(&[], 0.0).mean;
        let one =
            |a: f64| synthetic_record("swing", &KNOWN, &MotionPlan::jolt(0.28, a, 1.2), &theta, &[], 1e-4, 3);
        [0.6, 1.2].into_iter().filter_map(one).collect()
    }

    #[test]
    fn references_come_from_the_store_with_the_noise_of_the_recordings_and_a_cut_file_is_no_simulation() {
        let folder = std::env::temp_dir().join(format!("meniscus-references-{}", std::process::id()));
        let (records, store) = (records(), SimulationStore::new(&folder));
        let settings = ReferenceSettings { spacing_m: 0.007, seed: 1, store: folder.clone() };
        let plan = ReferencePlan::new(&records, &KNOWN, &settings, &Particles).expect("possible");
        let mut files = 0;
        for wanted in plan.wanted.iter().flatten() {
            let level = vec![0.0512_f32; wanted.course.frames * POINTS];
            store.put(digest(&wanted.setup, &wanted.course), &Ok(level)).expect("kept");
            files += 1;
        }
        assert_eq!(files, GLASSES.len() * records.len());
        let watch = |_| {};
        let simulations = Simulations::new(&store, &watch);
        let made = simulated_references(&records, &KNOWN, &settings, &simulations).expect("all are there");
        assert_eq!(simulations.made.load(Ordering::Relaxed), 0);
        assert_eq!(made.len(), GLASSES.len());
        let viscous = made.iter().filter(|(known, _)| known.viscosity_pa_s > 0.2).count();
        assert!((1..made.len()).contains(&viscous), "two viscosities: {viscous}");
        for (_, simulated) in &made {
            for (simulated, like) in simulated.iter().zip(&records) {
                assert_eq!(simulated.frames(), like.frames());
                let level: Vec<f64> = simulated.channels[0].value.iter().flatten().copied().collect();
                let mean = level.iter().sum::<f64>() / level.len() as f64;
                let spread =
                    (level.iter().map(|z| (z - mean).powi(2)).sum::<f64>() / level.len() as f64).sqrt();
                assert!((mean - 1.2e-3).abs() < 1e-4, "{mean}");
                assert!((0.4e-4..2.5e-4).contains(&spread), "{spread}");
            }
        }
        // A file that was cut short is not taken for whole: with no time to simulate, the work ends as stopped.
        let first = &plan.wanted[0][0];
        let path = folder.join(format!("{:016x}.heights", digest(&first.setup, &first.course)));
        std::fs::write(&path, [0; 9]).expect("written");
        let stop = std::sync::atomic::AtomicBool::new(true);
        let mut stopped = Simulations::new(&store, &watch);
        stopped.stop = Some(&stop);
        let ended = simulated_references(&records, &KNOWN, &settings, &stopped);
        assert!(matches!(ended, Err(SizingError::Stopped)), "{ended:?}");
        std::fs::remove_dir_all(&folder).expect("removed");
    }

    #[test]
    fn two_runs_at_once_share_one_store() {
        let folder = std::env::temp_dir().join(format!("meniscus-references-both-{}", std::process::id()));
        let store = SimulationStore::new(&folder);
        let heights: Vec<f32> = (0..60 * POINTS).map(|n| n as f32).collect();
        std::thread::scope(|scope| {
            for _ in 0..2 {
                scope.spawn(|| {
                    for _ in 0..200 {
                        store.put(7, &Ok(heights.clone())).expect("kept");
                        // What is there is whole at any time.
                        assert_eq!(store.get(7, 60), Some(Ok(heights.clone())));
                    }
                });
            }
        });
        std::fs::remove_dir_all(&folder).expect("removed");
    }
}
