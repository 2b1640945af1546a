//! Flashing with the power cut at random, on a disk that forgets: the worst that a journal-less disk may do.
//!
//! What the disk promises is only what was synced. At a cut, a file that was written and not synced keeps a
//! random part of its bytes with noise behind it, or nothing; of the names that were changed and not synced, each
//! change is kept or lost by itself.

use super::{Disk, FlashPolicy, Flashed, PublicKey, Release, Signed, boot, flash};
use ed25519_dalek::{Signer, SigningKey};
use meniscus::blob::{CRC, PREFIX_LEN};
use std::collections::BTreeMap;
use std::io;

/// A generator of random numbers that is small and the same everywhere (xorshift64*).
#[derive(Clone, Copy, Debug)]
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d)
    }

    fn below(&mut self, limit: usize) -> usize {
        (self.next() >> 16) as usize % limit.max(1)
    }
}

/// A change of names that is not synced.
#[derive(Clone, Debug)]
enum Change {
    Made(String, usize),
    Renamed(String, String),
    Removed(String),
}

/// The disk: files by number, and which name has which.
#[derive(Clone, Debug, Default)]
pub(super) struct Forgetful {
    /// Bytes of each file, and whether they are synced.
    files: Vec<(Vec<u8>, bool)>,
    names: BTreeMap<String, usize>,
    synced_names: BTreeMap<String, usize>,
    changes: Vec<Change>,
    /// Steps until the power is cut.
    left: Option<usize>,
    /// Says that it has synced a file, and has not.
    careless: bool,
}

impl Forgetful {
    /// A disk that says it has synced a file, and has not.
    #[cfg(test)]
    pub(super) fn careless() -> Self {
        Self { careless: true, ..Self::default() }
    }

    /// Counts a step; the one at which the power is cut fails, as do all behind it.
    fn step(&mut self) -> io::Result<()> {
        match &mut self.left {
            Some(0) => Err(io::Error::other("the power is cut")),
            Some(left) => {
                *left -= 1;
                Ok(())
            }
            None => Ok(()),
        }
    }

    fn apply(names: &mut BTreeMap<String, usize>, change: &Change) {
        match change {
            Change::Made(name, file) => {
                names.insert(name.clone(), *file);
            }
            Change::Renamed(from, to) => {
                if let Some(file) = names.remove(from) {
                    names.insert(to.clone(), file);
                }
            }
            Change::Removed(name) => {
                names.remove(name);
            }
        }
    }

    /// Restores the power: the synced state, a random part of the later changes, and noise in files that were not synced.
    fn come_back(&mut self, random: &mut Random) {
        let mut names = std::mem::take(&mut self.synced_names);
        for change in self.changes.drain(..) {
            if random.below(2) == 0 {
                Self::apply(&mut names, &change);
            }
        }
        for (bytes, synced) in &mut self.files {
            if !*synced {
                let kept = random.below(bytes.len() + 1);
                bytes.truncate(kept);
                let noise = random.below(64);
                bytes.extend((0..noise).map(|_| random.next() as u8));
                *synced = true;
            }
        }
        (self.names, self.synced_names, self.left) = (names.clone(), names, None);
    }
}

impl Disk for Forgetful {
    fn remove(&mut self, file: &str) -> io::Result<()> {
        let cut = self.step();
        let change = Change::Removed(file.into());
        Self::apply(&mut self.names, &change);
        self.changes.push(change);
        cut
    }

    fn read(&self, file: &str) -> io::Result<Vec<u8>> {
        let number = self.names.get(file).ok_or(io::ErrorKind::NotFound)?;
        Ok(self.files[*number].0.clone())
    }

    fn write(&mut self, file: &str, bytes: &[u8]) -> io::Result<()> {
        let cut = self.step();
        // The power may be cut in the middle of this step: the bytes are on their way then.
        self.files.push((bytes.to_vec(), false));
        self.names.insert(file.into(), self.files.len() - 1);
        self.changes.push(Change::Made(file.into(), self.files.len() - 1));
        cut
    }

    fn sync(&mut self, file: &str) -> io::Result<()> {
        self.step()?;
        let number = self.names.get(file).ok_or(io::ErrorKind::NotFound)?;
        self.files[*number].1 = !self.careless;
        Ok(())
    }

    fn rename(&mut self, from: &str, to: &str) -> io::Result<()> {
        let cut = self.step();
        let change = Change::Renamed(from.into(), to.into());
        Self::apply(&mut self.names, &change);
        self.changes.push(change);
        cut
    }

    fn sync_folder(&mut self) -> io::Result<()> {
        self.step()?;
        (self.synced_names, self.changes) = (self.names.clone(), Vec::new());
        Ok(())
    }
}

/// Result of a rehearsal of power cuts.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Rehearsed {
    /// Cuts.
    pub cuts: u32,
    /// Cuts behind which a whole, checked blob booted: the old one, or the new one.
    pub survived: u32,
    /// Cuts behind which the new blob booted.
    pub new: u32,
    /// Cuts behind which another slot booted than the named one.
    pub fell_back: u32,
    /// The first failure, in words.
    pub first_failure: Option<String>,
}

/// Flashes `blobs` in turn, each time with the power cut at a random step, and boots; the disk is never made anew,
/// so that what a cut leaves behind is there at the next one. Behind each cut the same blob is flashed to the
/// end, and has to boot.
#[must_use]
pub fn rehearse(blobs: [&[u8]; 2], cuts: u32, seed: u64) -> Rehearsed {
    rehearse_on(Forgetful::default(), &Rehearsal { blobs, cuts, seed, key: None })
}

/// Returns the same with signed blobs whose releases rise, on a board with a key.
#[must_use]
pub fn rehearse_signed(blobs: [&[u8]; 2], cuts: u32, seed: u64) -> Rehearsed {
    // The key of the rehearsal alone: nothing is kept that it has signed.
    let key = SigningKey::from_bytes(&[1; 32]);
    rehearse_on(Forgetful::default(), &Rehearsal { blobs, cuts, seed, key: Some(key) })
}

/// A rehearsal.
pub(super) struct Rehearsal<'b> {
    /// Blobs that are flashed in turn.
    pub(super) blobs: [&'b [u8]; 2],
    /// Number of cuts.
    pub(super) cuts: u32,
    /// Seed of the cuts.
    pub(super) seed: u64,
    /// Key of a board that has one.
    pub(super) key: Option<SigningKey>,
}

impl Rehearsal<'_> {
    /// Signature of `blob` as this release, where there is a key.
    fn signed(&self, blob: &[u8], release: u64) -> Option<Signed> {
        let key = self.key.as_ref()?;
        let signature = key.sign(&Release(release).signed_bytes(blob)).to_bytes();
        Some(Signed { release: Release(release), signature })
    }

    fn policy(&self) -> FlashPolicy {
        FlashPolicy { key: self.key.as_ref().map(PublicKey::of), ..FlashPolicy::default() }
    }
}

/// The same model with one bit of its last weight changed: as whole and as checked.
#[must_use]
pub fn sibling(blob: &[u8]) -> Vec<u8> {
    let mut sibling = blob.to_vec();
    if let Some(last) = sibling.len().checked_sub(4).filter(|last| *last > PREFIX_LEN) {
        sibling[last] ^= 1;
        let checksum = CRC.checksum(&sibling[PREFIX_LEN..]);
        sibling[PREFIX_LEN - 4..PREFIX_LEN].copy_from_slice(&checksum.to_le_bytes());
    }
    sibling
}

/// Rehearses on a given disk.
pub(super) fn rehearse_on(mut disk: Forgetful, rehearsal: &Rehearsal<'_>) -> Rehearsed {
    let &Rehearsal { blobs, cuts, seed, .. } = rehearsal;
    let (mut random, mut done) = (Random(seed.max(1)), Rehearsed { cuts, ..Rehearsed::default() });
    let (mut old, policy): (&[u8], _) = (blobs[0], rehearsal.policy());
    // Files of four steps each, the removal of a signature, and one more for a cut that comes too late.
    let steps = if rehearsal.key.is_some() { 13 } else { 10 };
    if let Err(error) = flash(&mut disk, Flashed { blob: old, signed: rehearsal.signed(old, 1) }, &policy) {
        done.first_failure = Some(format!("the first blob: {error}"));
        return done;
    }
    for cut in 0..cuts {
        let new = blobs[(cut as usize + 1) % 2];
        let flashed = || Flashed { blob: new, signed: rehearsal.signed(new, u64::from(cut) + 2) };
        disk.left = Some(random.below(steps));
        let finished = flash(&mut disk, flashed(), &policy).is_ok();
        disk.come_back(&mut random);
        let verdict = match boot(&disk, &policy) {
            Err(error) => Err(error.to_string()),
            Ok(booted) if *booted.blob == *new => Ok((true, booted.fell_back.is_some())),
            Ok(booted) if *booted.blob == *old && !finished => Ok((false, booted.fell_back.is_some())),
            Ok(_) if finished => Err("the old blob boots although the new one was flashed to the end".into()),
            Ok(_) => Err("what boots is neither blob".into()),
        };
        let again = flash(&mut disk, flashed(), &policy).map(drop).and_then(|()| {
            let booted = boot(&disk, &policy)?;
            // What boots has been checked.
            if *booted.blob == *new { Ok(()) } else { Err(super::FlashError::ReadBack(booted.slot)) }
        });
        match (verdict, again) {
            (Ok((is_new, fell_back)), Ok(())) => {
                done.survived += 1;
                done.new += u32::from(is_new);
                done.fell_back += u32::from(fell_back);
            }
            (Err(why), _) => {
                done.first_failure.get_or_insert(format!("cut {cut}: {why}"));
            }
            (Ok(_), Err(error)) => {
                done.first_failure.get_or_insert(format!("behind cut {cut}: {error}"));
            }
        }
        old = new;
        // Files that no name has any more are gone.
        disk.collect();
    }
    done
}

impl Forgetful {
    fn collect(&mut self) {
        let kept: Vec<usize> = self.names.values().copied().collect();
        for (number, (bytes, _)) in self.files.iter_mut().enumerate() {
            if !kept.contains(&number) {
                bytes.clear();
                bytes.shrink_to_fit();
            }
        }
    }
}
