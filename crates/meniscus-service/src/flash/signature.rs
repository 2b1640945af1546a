//! Ed25519 signatures of blobs (RFC 8032) with the number of their release.
//!
//! A signature is of the bytes
//!
//! ```text
//! "meniscus release " (17 bytes), the release (u64, little-endian), the blob        or, without a number, of the blob alone
//! ```
//!
//! A slot's signature file is the release and the signature, 72 bytes; without a number it is the signature, 64 bytes, and
//! counts as release 0. The number is what keeps an older signed blob from coming back.

use super::FlashError;
use ed25519_dalek::{Signature, SigningKey, VerifyingKey};

/// Bytes of a signature.
pub const SIGNATURE: usize = 64;

/// Bytes before release and blob: no signature of one is one of the other.
const PREFIX: &[u8; 17] = b"meniscus release ";

/// Number of a signed blob; a later one is larger. 0 stands for none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Release(pub u64);

impl Release {
    /// Returns the bytes that a signature of `blob` as this release is of.
    #[must_use]
    pub fn signed_bytes(self, blob: &[u8]) -> Vec<u8> {
        if self.0 == 0 {
            return blob.to_vec();
        }
        [PREFIX.as_slice(), &self.0.to_le_bytes(), blob].concat()
    }
}

/// Signature with its release.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Signed {
    /// The release.
    pub release: Release,
    /// The signature.
    pub signature: [u8; SIGNATURE],
}

impl Signed {
    /// Reads a slot's signature file; `None` where it is none.
    #[must_use]
    pub fn read(bytes: &[u8]) -> Option<Self> {
        if let Ok(signature) = bytes.try_into() {
            return Some(Self { release: Release(0), signature });
        }
        let (release, signature) = bytes.split_first_chunk::<8>()?;
        let release = Release(u64::from_le_bytes(*release));
        // A number of zero has a form of its own.
        (release.0 > 0).then_some(Self { release, signature: signature.try_into().ok()? })
    }

    /// Returns the bytes of a slot's signature file.
    #[must_use]
    pub fn bytes(&self) -> Vec<u8> {
        match self.release {
            Release(0) => self.signature.to_vec(),
            Release(number) => [number.to_le_bytes().as_slice(), &self.signature].concat(),
        }
    }
}

/// The public half of the key that blobs are signed with.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PublicKey(VerifyingKey);

impl PublicKey {
    /// From 64 hexadecimal digits, as in a board's profile.
    ///
    /// # Errors
    /// [`FlashError::Key`].
    pub fn from_hex(text: &str) -> Result<Self, FlashError> {
        let refused = || FlashError::Key(text.into());
        let text = text.trim();
        if text.len() != 64 || !text.is_ascii() {
            return Err(refused());
        }
        let mut bytes = [0; 32];
        for (place, byte) in bytes.iter_mut().enumerate() {
            *byte = u8::from_str_radix(&text[2 * place..2 * place + 2], 16).map_err(|_| refused())?;
        }
        VerifyingKey::from_bytes(&bytes).map(Self).map_err(|_| refused())
    }

    /// Returns the public half of `key`.
    pub(super) fn of(key: &SigningKey) -> Self {
        Self(key.verifying_key())
    }

    /// Whether `signed` is of this blob by this key. Weak keys and malleable signatures are refused.
    ///
    /// # Errors
    /// [`FlashError::Signature`].
    pub fn verify(&self, blob: &[u8], signed: &Signed) -> Result<(), FlashError> {
        let signature = Signature::from_bytes(&signed.signature);
        let bytes = signed.release.signed_bytes(blob);
        self.0.verify_strict(&bytes, &signature).map_err(|_| FlashError::Signature)
    }
}
