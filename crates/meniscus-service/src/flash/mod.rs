//! Writing a model to a board: two slots, so that at any moment one of them holds a whole, checked blob.
//!
//! ```text
//! folder/  slot-a.blob  slot-a.sig     the blob and, where a key is set, its ed25519 signature (64 bytes)
//!          slot-b.blob  slot-b.sig
//!          active                      one letter: the slot that boots
//!
//! flash:  check -> other slot: write beside, sync, rename, sync the folder, read back, check -> active: the same
//! boot:   the slot that `active` names, if it holds a whole, checked blob; else the other one
//! ```
//!
//! The slot that boots is never written. Before the one rename of `active` the old blob boots, behind it the new
//! one; [`rehearse`] cuts the power at every step, with what was not synced lost, torn or there in part.

mod disk;
mod power_loss;
mod signature;

pub use disk::{Disk, Folder};
use meniscus::blob::{LoadError, Model};
use meniscus_platform::files::AlignedBytes;
pub use power_loss::{Rehearsed, rehearse, sibling};
pub use signature::{PublicKey, SIGNATURE};
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

/// A blob that may boot.
#[derive(Debug)]
pub struct Booted {
    /// Where it lies.
    pub slot: Slot,
    /// The blob.
    pub blob: AlignedBytes,
    /// The slot that `active` names does not boot, and why; the other one was taken.
    pub fell_back: Option<FlashError>,
}

/// Whether a blob may boot: a model of this version, signed if there is a key.
///
/// # Errors
/// [`FlashError`] says what is wrong.
pub fn check(blob: &[u8], signature: Option<&[u8]>, key: Option<&PublicKey>) -> Result<(), FlashError> {
    if let Some(key) = key {
        key.verify(blob, signature.ok_or(FlashError::Unsigned)?)?;
    }
    Model::load(&AlignedBytes::copy(blob)).map(drop).map_err(FlashError::Blob)
}

/// Writes `blob` to the slot that does not boot and makes it the one that does.
///
/// # Errors
/// [`FlashError`]; what booted before boots then.
pub fn flash(
    disk: &mut impl Disk,
    blob: &[u8],
    signature: Option<&[u8]>,
    key: Option<&PublicKey>,
) -> Result<Slot, FlashError> {
    check(blob, signature, key)?;
    // Where nothing boots, either will do.
    let slot = boot(disk, key).map_or(Slot::A, |booted| booted.slot.other());
    if let Some(signature) = signature {
        put(disk, &slot.signature(), signature)?;
    }
    put(disk, &slot.blob(), blob)?;
    let kept = read(disk, &slot.blob())?;
    let kept_signature = disk.read(&slot.signature()).ok();
    if kept != blob || check(&kept, kept_signature.as_deref(), key).is_err() {
        return Err(FlashError::ReadBack(slot));
    }
    put(disk, ACTIVE, format!("{}\n", slot.letter()).as_bytes())?;
    Ok(slot)
}

/// The blob that boots.
///
/// # Errors
/// [`FlashError::NoneBoots`] with what is wrong with either slot.
pub fn boot(disk: &impl Disk, key: Option<&PublicKey>) -> Result<Booted, FlashError> {
    let named = match disk.read(ACTIVE).as_deref() {
        Ok(b"b\n") => Slot::B,
        // A folder without the file, or with a damaged one, boots what it has.
        _ => Slot::A,
    };
    let first = match whole(disk, named, key) {
        Ok(blob) => return Ok(Booted { slot: named, blob, fell_back: None }),
        Err(error) => error,
    };
    match whole(disk, named.other(), key) {
        Ok(blob) => Ok(Booted { slot: named.other(), blob, fell_back: Some(first) }),
        Err(second) => {
            let both = [Box::new(first), Box::new(second)];
            let [a, b] = both;
            Err(FlashError::NoneBoots(if named == Slot::A { [a, b] } else { [b, a] }))
        }
    }
}

/// The checked blob of a slot.
fn whole(disk: &impl Disk, slot: Slot, key: Option<&PublicKey>) -> Result<AlignedBytes, FlashError> {
    let blob = read(disk, &slot.blob())?;
    let signature = disk.read(&slot.signature()).ok();
    check(&blob, signature.as_deref(), key)?;
    Ok(AlignedBytes::copy(&blob))
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
