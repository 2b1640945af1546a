//! Settled glasses that are kept: the last few in memory, and many in a folder where the program names one.
//!
//! A file is taken only if its key is the one wanted, to the letter: the source of this crate, the glass, the spacing, the
//! seed and the effects that turn gravity, and the particles before they settled. A file that is cut, changed or of another version is settled anew.
//! Nothing depends on a file: one that cannot be written is left out.

use super::Settled;
use crate::Setup;
use crate::particles::Fluid;
use meniscus_platform::files::{Links, read_regular, write_whole};
use std::collections::VecDeque;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// Glasses in memory: of 2156 particles each has 90 kB.
const IN_MEMORY: usize = 16;

/// Files in the folder; the oldest go.
const IN_FOLDER: usize = 256;

/// Longest file that is read, bytes: 500,000 particles.
const LONGEST: u64 = 1 << 25;

/// Checksum of a file's content.
const CRC: crc::Crc<u32> = crc::Crc::<u32>::new(&crc::CRC_32_ISCSI);

static MEMORY: Mutex<VecDeque<(Key, Arc<Settled>)>> = Mutex::new(VecDeque::new());
static FOLDER: OnceLock<PathBuf> = OnceLock::new();

/// Keeps the glasses that settle from here on in `folder` as well, and takes those that are there. The first call counts.
///
/// Without it glasses are kept in memory alone.
pub fn keep_settled_in(folder: &Path) {
    let _ = FOLDER.set(folder.to_path_buf());
}

/// Everything that the arrangement at rest depends on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Key(String);

impl Key {
    /// Of a glass in which `packed` settles as `setup` says.
    pub(super) fn of(setup: &Setup, packed: &Fluid) -> Self {
        let mut digest = CRC.digest();
        for particle in &packed.particle {
            let numbers = particle.x.into_iter().chain([particle.volume, particle.p]);
            numbers.for_each(|number| digest.update(&number.to_le_bytes()));
        }
        let source = env!("MENISCUS_SPH_SOURCE");
        let Setup { glass, liquid, spacing_m, seed, effects, .. } = setup;
        Self(format!(
            "{source} {glass:?} {liquid:?} {spacing_m:?} {seed} {effects:?} {:08x}",
            digest.finalize()
        ))
    }

    /// Name of its file.
    fn name(&self) -> String {
        let wide = crc::Crc::<u64>::new(&crc::CRC_64_XZ);
        format!("{:016x}.settled", wide.checksum(self.0.as_bytes()))
    }
}

/// The kept glass of `key`.
pub(super) fn find(key: &Key) -> Option<Arc<Settled>> {
    let in_memory = || {
        let memory = MEMORY.lock().unwrap_or_else(PoisonError::into_inner);
        memory.iter().find(|(kept, _)| kept == key).map(|(_, settled)| settled.clone())
    };
    if let Some(settled) = in_memory() {
        return Some(settled);
    }
    let settled = Arc::new(read(&FOLDER.get()?.join(key.name()), key)?);
    remember(key, &settled);
    Some(settled)
}

/// Keeps `settled` under `key`.
pub(super) fn keep(key: &Key, settled: &Arc<Settled>) {
    remember(key, settled);
    if let Some(folder) = FOLDER.get() {
        // A full disk or a folder of another user costs time, and no result.
        if fs::create_dir_all(folder).is_ok()
            && write_whole(&folder.join(key.name()), &bytes(key, settled)).is_ok()
        {
            thin_out(folder);
        }
    }
}

fn remember(key: &Key, settled: &Arc<Settled>) {
    let mut memory = MEMORY.lock().unwrap_or_else(PoisonError::into_inner);
    memory.push_back((key.clone(), settled.clone()));
    if memory.len() > IN_MEMORY {
        memory.pop_front();
    }
}

/// Content of a file: checksum of what follows, key, particles.
fn bytes(key: &Key, settled: &Settled) -> Vec<u8> {
    let body = postcard::to_allocvec(&(&key.0, settled)).unwrap_or_default();
    [CRC.checksum(&body).to_le_bytes().as_slice(), &body].concat()
}

/// The glass of `key` in the file `path`, where that is whole and of this key.
fn read(path: &Path, key: &Key) -> Option<Settled> {
    let bytes = read_regular(path, LONGEST, Links::Refused).ok()?;
    let (sum, body) = bytes.split_first_chunk()?;
    if CRC.checksum(body) != u32::from_le_bytes(*sum) {
        return None;
    }
    let (kept, settled): (String, Settled) = postcard::from_bytes(body).ok()?;
    let Settled { position, mass, density, .. } = &settled;
    let whole = position.len() == mass.len() && position.len() == density.len();
    (kept == key.0 && whole).then_some(settled)
}

/// Removes the oldest files beyond [`IN_FOLDER`].
fn thin_out(folder: &Path) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    let settled =
        entries.flatten().filter(|entry| entry.path().extension().is_some_and(|end| end == "settled"));
    let age = |entry: fs::DirEntry| Some((entry.metadata().ok()?.modified().ok()?, entry.path()));
    let mut files: Vec<_> = settled.filter_map(age).collect();
    files.sort();
    let surplus = files.len().saturating_sub(IN_FOLDER);
    for (_, path) in &files[..surplus] {
        let _ = fs::remove_file(path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn glass() -> (Key, Settled) {
        let settled = Settled {
            position: vec![[0.1, 0.2, 0.3], [0.4, 0.5, 0.6]],
            mass: vec![1.0, 2.0],
            density: vec![3.0, 4.0],
            law: [1.0, 0.5, 0.25, 0.7],
        };
        (Key("this glass".into()), settled)
    }

    #[test]
    fn a_file_that_is_cut_changed_or_of_another_glass_is_not_taken() {
        let folder = std::env::temp_dir().join(format!("meniscus-settled-{}", std::process::id()));
        fs::create_dir_all(&folder).expect("a folder");
        let path = folder.join("x.settled");
        let (key, settled) = glass();
        let whole = bytes(&key, &settled);
        fs::write(&path, &whole).expect("a file");
        assert_eq!(read(&path, &key).as_ref(), Some(&settled));
        assert_eq!(read(&path, &Key("that glass".into())), None);
        for at in 0..whole.len() {
            let mut changed = whole.clone();
            changed[at] ^= 1;
            fs::write(&path, &changed).expect("a file");
            assert_eq!(read(&path, &key), None, "byte {at} changed");
            fs::write(&path, &whole[..at]).expect("a file");
            assert_eq!(read(&path, &key), None, "cut at {at}");
        }
        fs::remove_dir_all(&folder).expect("the folder goes");
    }
}
