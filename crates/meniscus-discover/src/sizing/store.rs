//! Simulated heights on disk: one file for each motion of each glass, named after a digest of all that it was made of.
//!
//! ```text
//! DIGEST.heights     21 heights of every frame, little-endian f32, m
//! DIGEST.failed      the reason, where the simulator stopped
//! versions.txt       versions of the program and of the simulator's results that have written here, one a line
//! ```
//!
//! A file is written whole or not at all, so an interrupted run goes on from those that are there, two runs may share a
//! folder, and folders of several machines can be joined. The folder may be removed at any time.

use crate::fitting::fit_cache::CacheKey;
use crate::insert::simulated::Course;
use meniscus::surface::POINTS;
use meniscus_platform::files::{FileError, write_whole};
use meniscus_sph::Setup;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Version of the simulator's results, raised when the same set-up gives other heights.
pub(crate) const SIMULATOR_VERSION: f64 = 4.0;

/// Name of the list of versions.
const VERSIONS: &str = "versions.txt";

/// Returns the version of this program and of the simulator's results.
fn own_version() -> String {
    format!("{} {SIMULATOR_VERSION}", env!("CARGO_PKG_VERSION"))
}

/// Heights of a simulation, or the reason why there are none.
pub type Heights = Result<Vec<f32>, String>;

/// Folder of simulated heights.
#[derive(Clone, Debug)]
pub struct SimulationStore {
    folder: PathBuf,
}

impl SimulationStore {
    /// Opens the store in `folder`, which is created with the first simulation.
    #[must_use]
    pub fn new(folder: &Path) -> Self {
        Self { folder: folder.into() }
    }

    /// Returns the folder.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    fn path(&self, key: u64, kind: &str) -> PathBuf {
        self.folder.join(format!("{key:016x}.{kind}"))
    }

    /// Returns what is kept under `key`; none where nothing is, or a file was cut short.
    #[must_use]
    pub fn get(&self, key: u64, frames: usize) -> Option<Heights> {
        if let Ok(bytes) = std::fs::read(self.path(key, "heights")) {
            let (chunks, rest) = bytes.as_chunks::<4>();
            let heights: Vec<f32> = chunks.iter().map(|b| f32::from_le_bytes(*b)).collect();
            let whole = rest.is_empty() && heights.len() == frames * POINTS;
            return (whole && heights.iter().all(|z| z.is_finite())).then_some(Ok(heights));
        }
        let reason = std::fs::read_to_string(self.path(key, "failed")).ok()?;
        (!reason.is_empty()).then_some(Err(reason))
    }

    /// Returns what is to be said where another version of the program has written in the folder: its simulations are of no use to
    /// this one.
    #[must_use]
    pub fn others(&self) -> Option<String> {
        self.others_than(&own_version())
    }

    fn others_than(&self, own: &str) -> Option<String> {
        let text = std::fs::read_to_string(self.folder.join(VERSIONS)).ok()?;
        let others: Vec<&str> =
            text.lines().filter(|line| *line != own && !line.is_empty()).take(4).collect();
        let (folder, others) = (self.folder.display(), (!others.is_empty()).then(|| others.join(", "))?);
        Some(format!(
            "{folder} holds simulations of another version of the program ({others}), which are made again: heights of two versions \
             are not compared. `rm -r {folder}` frees their room"
        ))
    }

    /// Notes the version `own` in the folder.
    fn note(&self, own: &str) -> Result<(), FileError> {
        let path = self.folder.join(VERSIONS);
        let text = std::fs::read_to_string(&path).unwrap_or_default();
        if text.lines().any(|line| line == own) {
            return Ok(());
        }
        self.keep(&path, format!("{text}{own}\n").as_bytes())
    }

    /// Keeps `heights` under `key`.
    ///
    /// # Errors
    /// [`FileError`], when the file cannot be written.
    pub fn put(&self, key: u64, heights: &Heights) -> Result<(), FileError> {
        self.note(&own_version())?;
        match heights {
            Ok(heights) => {
                let bytes: Vec<u8> = heights.iter().flat_map(|z| z.to_le_bytes()).collect();
                self.keep(&self.path(key, "heights"), &bytes)
            }
            Err(reason) => self.keep(&self.path(key, "failed"), reason.as_bytes()),
        }
    }

    /// Writes `bytes` under a name of this process and thread, and renames the file to `path` when it is whole: two runs may
    /// make the same simulation at once, and neither takes the other's half file or fails by it.
    fn keep(&self, path: &Path, bytes: &[u8]) -> Result<(), FileError> {
        static WRITTEN: AtomicUsize = AtomicUsize::new(0);
        let mine = format!("{}-{}.writing", std::process::id(), WRITTEN.fetch_add(1, Ordering::Relaxed));
        let mine = self.folder.join(mine);
        write_whole(&mine, bytes)?;
        std::fs::rename(&mine, path).map_err(|cause| FileError { path: path.into(), doing: "rename", cause })
    }
}

/// Returns the digest of everything that the heights of `course` in `setup` by the particle simulator depend on.
#[must_use]
pub fn digest(setup: &Setup, course: &Course) -> u64 {
    digest_by("", setup, course)
}

/// Returns the same of a simulation by the simulator with the given `identity`.
#[must_use]
pub fn digest_by(identity: &str, setup: &Setup, course: &Course) -> u64 {
    let mut key = key_of(setup);
    if !identity.is_empty() {
        key.add_word(identity);
    }
    key.add([course.frames as f64]);
    key.add(course.samples.iter().flat_map(|(t, x)| [*t, *x]));
    key.finish()
}

/// Returns the digest of `setup` alone: simulations that share it share a settled glass.
#[must_use]
pub fn setup_digest(setup: &Setup) -> u64 {
    key_of(setup).finish()
}

fn key_of(setup: &Setup) -> CacheKey {
    let mut key = CacheKey::new();
    key.add_word(env!("CARGO_PKG_VERSION"));
    let Setup { glass, liquid, spacing_m, seed, no_slip, effects, step_s } = setup;
    key.add([SIMULATOR_VERSION, glass.radius_m, glass.fill_m, glass.rim_m]);
    // The name of a liquid changes nothing.
    key.add_word(&format!(
        "{:?} {:?} {effects:?} {seed} {no_slip} {:?}",
        liquid.rheology, liquid.effects, glass.wall
    ));
    key.add([liquid.density_kg_m3, *spacing_m, step_s.unwrap_or(0.0)]);
    key
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus::reduced::effects::EffectKind;
    use meniscus_data::effects::Effects;
    use meniscus_data::glass::{Glass, WallShape};
    use meniscus_data::liquids::{Liquid, Rheology};

    fn setup() -> Setup {
        let rheology = Rheology::newtonian(0.2);
        Setup {
            glass: Glass { radius_m: 0.035, fill_m: 0.07, rim_m: 0.11, wall: WallShape::UPRIGHT },
            liquid: Liquid { name: "x".into(), density_kg_m3: 1261.0, rheology, effects: Effects::default() },
            spacing_m: 0.007,
            seed: 1,
            no_slip: true,
            effects: Effects::default(),
            step_s: None,
        }
    }

    #[test]
    fn everything_that_changes_heights_changes_the_digest_and_a_name_does_not() {
        let course = Course { samples: vec![(0.0, 0.0), (1.0, 0.01)], frames: 60 };
        let mut changed: Vec<(Setup, Course)> = vec![(setup(), course.clone())];
        let mut with = |change: &dyn Fn(&mut Setup, &mut Course)| {
            let (mut setup, mut course) = (setup(), course.clone());
            change(&mut setup, &mut course);
            changed.push((setup, course));
        };
        with(&|setup, _| setup.seed = 2);
        with(&|setup, _| setup.spacing_m = 0.005);
        with(&|setup, _| setup.glass.fill_m = 0.071);
        with(&|setup, _| setup.liquid.rheology.consistency = 0.21);
        with(&|setup, _| setup.effects = setup.effects.with(EffectKind::YieldStress, 1.0));
        with(&|setup, _| setup.effects = setup.effects.with(EffectKind::YieldStress, 1.1));
        with(&|_, course| course.frames = 61);
        with(&|_, course| course.samples[1].1 = 0.011);
        let mut keys: Vec<u64> = changed.iter().map(|(setup, course)| digest(setup, course)).collect();
        keys.sort_unstable();
        keys.dedup();
        assert_eq!(keys.len(), changed.len());
        let mut named = setup();
        named.liquid.name = "y".into();
        assert_eq!(digest(&named, &course), digest(&setup(), &course));
        // Another simulator gives other heights.
        let others = ["mine", "yours"].map(|identity| digest_by(identity, &setup(), &course));
        assert!(others[0] != others[1] && !others.contains(&digest(&setup(), &course)));
    }

    #[test]
    fn simulations_of_another_version_are_named_with_what_frees_their_room() {
        let folder = std::env::temp_dir().join(format!("meniscus-versions-{}", std::process::id()));
        let store = SimulationStore::new(&folder);
        assert_eq!(store.others(), None);
        store.put(1, &Err("it spills".into())).expect("written");
        store.put(2, &Err("it spills".into())).expect("written");
        let text = std::fs::read_to_string(folder.join(VERSIONS)).expect("read");
        assert_eq!((text.lines().count(), store.others()), (1, None), "{text}");
        store.note("9.9.9 7").expect("written");
        let said = store.others().expect("another version");
        assert!(said.contains("(9.9.9 7)") && said.contains("`rm -r "), "{said}");
        assert!(store.others_than("9.9.9 7").expect("this one").contains(text.trim()));
        std::fs::remove_dir_all(&folder).expect("removed");
    }

    #[test]
    fn a_simulation_is_found_again_with_its_failure_and_one_that_was_cut_short_is_not() {
        let folder = std::env::temp_dir().join(format!("meniscus-heights-{}", std::process::id()));
        let store = SimulationStore::new(&folder);
        assert_eq!(store.get(1, 2), None);
        let heights: Heights = Ok((0..2 * POINTS).map(|n| 0.07 + n as f32 * 1e-4).collect());
        store.put(1, &heights).expect("written");
        store.put(2, &Err("particles left the glass".into())).expect("written");
        assert_eq!(store.get(1, 2), Some(heights));
        assert_eq!(store.get(1, 3), None, "another length");
        assert_eq!(store.get(2, 2), Some(Err("particles left the glass".into())));
        std::fs::write(store.path(1, "heights"), [0; 7]).expect("written");
        assert_eq!(store.get(1, 2), None, "cut short");
        std::fs::remove_dir_all(&folder).expect("removed");
    }
}
