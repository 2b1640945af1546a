//! Writing a model to a board: two slots, so that at any moment one of them holds a whole, checked blob.
//!
//! ```text
//! folder/  slot-a.blob  slot-a.sig     the blob and, where a key is set, its release and ed25519 signature
//!          slot-b.blob  slot-b.sig
//!          active                      one letter: the slot that boots
//!
//! flash:  check -> other slot: write beside, sync, rename, sync the folder, read back, check -> active: the same
//! boot:   the slot that `active` names, if it holds a whole, checked blob; else the other one
//! ```
//!
//! With a key, the slot with the later release boots, whatever `active` says, and an earlier release is not written unless
//! that is allowed; then it goes into both slots. The profile may name the earliest release that boots at all: that holds
//! even against somebody who can change the folder.
//!
//! The slot that boots is never written. Before the one rename of `active` the old blob boots, behind it the new
//! one; [`rehearse`] cuts the power at every step, with what was not synced lost, torn or there in part.

mod disk;
mod power_loss;
mod signature;

pub use disk::{Disk, Folder};
use meniscus::blob::{LoadError, Model};
use meniscus_platform::files::AlignedBytes;
pub use power_loss::{Rehearsed, rehearse, rehearse_signed, sibling};
pub use signature::{PublicKey, Release, SIGNATURE, Signed};
use std::fmt;
use std::io;

/// The file that names the slot that boots.
const ACTIVE: &str = "active";

/// One of the two places for a blob.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slot {
    /// The first.
    A,
    /// The second.
    B,
}

impl Slot {
    /// The other one.
    #[must_use]
    pub fn other(self) -> Self {
        match self {
            Self::A => Self::B,
            Self::B => Self::A,
        }
    }

    fn letter(self) -> char {
        match self {
            Self::A => 'a',
            Self::B => 'b',
        }
    }

    fn blob(self) -> String {
        format!("slot-{}.blob", self.letter())
    }

    fn signature(self) -> String {
        format!("slot-{}.sig", self.letter())
    }
}

/// Why a blob is not written, or none boots.
#[derive(Debug)]
pub enum FlashError {
    /// The blob is no model of this version.
    Blob(LoadError),
    /// A key is set and the blob has no signature.
    Unsigned,
    /// The signature does not belong to this blob and this key.
    Signature,
    /// The key is no ed25519 public key.
    Key(String),
    /// The release is earlier than one that is on the board, or than the earliest that the profile allows.
    Rollback {
        /// Release of the blob.
        release: Release,
        /// Earliest release that is taken.
        least: Release,
    },
    /// Another flash is under way.
    Busy(String),
    /// The bytes read back differ from those written.
    ReadBack(Slot),
    /// The folder could not be read or written.
    Disk {
        /// Operation that failed.
        doing: &'static str,
        /// With which file.
        file: String,
        /// Error of the system.
        cause: io::Error,
    },
    /// Neither slot holds a blob that may boot.
    NoneBoots([Box<Self>; 2]),
}

impl fmt::Display for FlashError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Blob(error) => write!(f, "the blob is refused: {error}"),
            Self::Unsigned => write!(
                f,
                "the blob has no signature and the profile has a key: sign it (openssl pkeyutl -sign -rawin -inkey \
                 KEY.pem -in BLOB -out BLOB.sig) and give the file with --signature"
            ),
            Self::Signature => write!(
                f,
                "the signature does not belong to this blob and the profile's key: sign this very file with the key's \
                 other half"
            ),
            Self::Key(text) => {
                write!(f, "`{text}` is no ed25519 public key: 64 hexadecimal digits are needed")
            }
            Self::Rollback { release: Release(release), least: Release(least) } => write!(
                f,
                "the blob is release {release}, and this board takes {least} or later: sign a later one (--release {least}), \
                 or go back on purpose with --allow-rollback; what the profile's least_release excludes never starts"
            ),
            Self::Busy(why) => write!(f, "{why}: wait until it has ended"),
            Self::ReadBack(slot) => write!(
                f,
                "slot {} did not keep what was written to it; the old blob still boots. Look at the board's storage",
                slot.letter()
            ),
            Self::Disk { doing, file, cause } => write!(f, "cannot {doing} {file}: {cause}"),
            Self::NoneBoots([a, b]) => {
                write!(f, "no slot boots: slot a: {a}; slot b: {b}. Write a blob with meniscus flash")
            }
        }
    }
}

impl std::error::Error for FlashError {}

/// Rules of a board.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FlashPolicy {
    /// Key that a blob must be signed with; none, any blob.
    pub key: Option<PublicKey>,
    /// Earliest release that is written or boots.
    pub least: Release,
    /// Whether an earlier release than that on the board may be written.
    pub rollback: Rollback,
}

/// Reaction to an earlier release than that on the board.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Rollback {
    /// It is refused.
    #[default]
    Refused,
    /// It is written into both slots.
    Allowed,
}

/// A blob that is to be written.
#[derive(Clone, Copy, Debug)]
pub struct Flashed<'b> {
    /// The blob.
    pub blob: &'b [u8],
    /// Its signature.
    pub signed: Option<Signed>,
}

/// A blob that may boot.
#[derive(Debug)]
pub struct Booted {
    /// Where it lies.
    pub slot: Slot,
    /// The blob.
    pub blob: AlignedBytes,
    /// Its release; 0 where none was checked.
    pub release: Release,
    /// The slot that `active` names does not boot, and why; the other one was taken.
    pub fell_back: Option<FlashError>,
}

/// Whether a blob may boot: a model of this version, signed as no earlier release than the policy allows if it has a key.
/// Returns its release, 0 without a key.
///
/// # Errors
/// [`FlashError`] says what is wrong.
pub fn check(flashed: Flashed<'_>, policy: &FlashPolicy) -> Result<Release, FlashError> {
    let mut release = Release(0);
    if let Some(key) = &policy.key {
        let signed = flashed.signed.ok_or(FlashError::Unsigned)?;
        key.verify(flashed.blob, &signed)?;
        release = signed.release;
        if release < policy.least {
            return Err(FlashError::Rollback { release, least: policy.least });
        }
    }
    Model::load(&AlignedBytes::copy(flashed.blob)).map(drop).map_err(FlashError::Blob)?;
    Ok(release)
}

/// Writes a blob to the slot that does not boot and makes it the one that does.
///
/// # Errors
/// [`FlashError`]; what booted before boots then.
pub fn flash(disk: &mut impl Disk, flashed: Flashed<'_>, policy: &FlashPolicy) -> Result<Slot, FlashError> {
    let release = check(flashed, policy)?;
    let _alone = disk.begin().map_err(|cause| match cause.kind() {
        io::ErrorKind::ResourceBusy => FlashError::Busy(cause.to_string()),
        _ => FlashError::Disk { doing: "lock", file: "the folder".into(), cause },
    })?;
    let now = boot(disk, policy).ok();
    let earlier = now.as_ref().is_some_and(|now| release < now.release);
    if let Some(now) = now.as_ref().filter(|_| earlier && policy.rollback == Rollback::Refused) {
        return Err(FlashError::Rollback { release, least: now.release });
    }
    // Where nothing boots, either will do.
    let slot = now.map_or(Slot::A, |now| now.slot.other());
    fill(disk, slot, flashed, policy)?;
    put(disk, ACTIVE, format!("{}\n", slot.letter()).as_bytes())?;
    if earlier {
        // The later release would boot as long as it is there.
        fill(disk, slot.other(), flashed, policy)?;
    }
    Ok(slot)
}

/// Writes a blob and its signature into a slot, reads them back and checks them.
fn fill(
    disk: &mut impl Disk,
    slot: Slot,
    flashed: Flashed<'_>,
    policy: &FlashPolicy,
) -> Result<(), FlashError> {
    match flashed.signed {
        Some(signed) => put(disk, &slot.signature(), &signed.bytes())?,
        None => {
            let file = slot.signature();
            let gone = disk.remove(&file);
            gone.map_err(|cause| FlashError::Disk { doing: "remove the old", file, cause })?;
        }
    }
    put(disk, &slot.blob(), flashed.blob)?;
    match whole(disk, slot, policy) {
        Ok(kept) if *kept.blob == *flashed.blob => Ok(()),
        _ => Err(FlashError::ReadBack(slot)),
    }
}

/// The blob that boots.
///
/// # Errors
/// [`FlashError::NoneBoots`] with what is wrong with either slot.
pub fn boot(disk: &impl Disk, policy: &FlashPolicy) -> Result<Booted, FlashError> {
    let named = match disk.read(ACTIVE).as_deref() {
        Ok(b"b\n") => Slot::B,
        // A folder without the file, or with a damaged one, boots what it has.
        _ => Slot::A,
    };
    match (whole(disk, named, policy), whole(disk, named.other(), policy)) {
        // `active` is not signed: it decides between slots of one release only.
        (Ok(first), Ok(other)) if other.release > first.release => Ok(other),
        (Ok(first), _) => Ok(first),
        (Err(first), Ok(other)) => Ok(Booted { fell_back: Some(first), ..other }),
        (Err(first), Err(second)) => {
            let both = [Box::new(first), Box::new(second)];
            let [a, b] = both;
            Err(FlashError::NoneBoots(if named == Slot::A { [a, b] } else { [b, a] }))
        }
    }
}

/// The checked blob of a slot.
fn whole(disk: &impl Disk, slot: Slot, policy: &FlashPolicy) -> Result<Booted, FlashError> {
    let blob = read(disk, &slot.blob())?;
    let signed = disk.read(&slot.signature()).ok().and_then(|bytes| Signed::read(&bytes));
    let release = check(Flashed { blob: &blob, signed }, policy)?;
    Ok(Booted { slot, blob: AlignedBytes::copy(&blob), release, fell_back: None })
}

fn read(disk: &impl Disk, file: &str) -> Result<Vec<u8>, FlashError> {
    disk.read(file).map_err(|cause| FlashError::Disk { doing: "read", file: file.into(), cause })
}

/// The file is the old one or the new one, never a part; behind this call it is the new one.
fn put(disk: &mut impl Disk, file: &str, bytes: &[u8]) -> Result<(), FlashError> {
    let beside = format!("{file}.part");
    let failed = |doing, cause| FlashError::Disk { doing, file: file.into(), cause };
    disk.write(&beside, bytes).map_err(|cause| failed("write beside", cause))?;
    disk.sync(&beside).map_err(|cause| failed("sync what lies beside", cause))?;
    disk.rename(&beside, file).map_err(|cause| failed("rename to", cause))?;
    disk.sync_folder().map_err(|cause| failed("sync the folder of", cause))
}

#[cfg(test)]
mod tests;
