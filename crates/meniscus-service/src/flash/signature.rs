//! Ed25519 signatures of blobs (RFC 8032, over the whole file).

use super::FlashError;
use ed25519_dalek::{Signature, VerifyingKey};

/// Bytes of a signature.
pub const SIGNATURE: usize = 64;

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

    /// Whether `signature` is of these bytes by this key. Weak keys and malleable signatures are refused.
    ///
    /// # Errors
    /// [`FlashError::Signature`].
    pub fn verify(&self, bytes: &[u8], signature: &[u8]) -> Result<(), FlashError> {
        let signature = Signature::from_slice(signature).map_err(|_| FlashError::Signature)?;
        self.0.verify_strict(bytes, &signature).map_err(|_| FlashError::Signature)
    }
}
