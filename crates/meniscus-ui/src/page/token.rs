//! The word that opens the page to those who come from another machine.

use super::PageError;
use meniscus_platform::files::read_text;
use std::path::Path;
use subtle::ConstantTimeEq;

/// Letters of a token: those that stand in an address as they are, 32 of them, so that five bits of a random
/// byte choose one without preferring any.
const LETTERS: [u8; 32] = *b"abcdefghijkmnpqrstuvwxyz23456789";

/// Letters of a token that is made here: 130 bits.
const LENGTH: usize = 26;

/// Fewest letters of a token from a file.
const LEAST: usize = 16;

/// The secret; it shows itself to nobody but [`Self::reveal`].
#[derive(Clone)]
pub struct Token(String);

impl std::fmt::Debug for Token {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Token(..)")
    }
}

impl Token {
    /// A new one.
    ///
    /// # Errors
    /// When the system gives no random numbers.
    pub fn generate() -> Result<Self, PageError> {
        let mut bytes = [0; LENGTH];
        getrandom::fill(&mut bytes).map_err(|error| {
            PageError::new("a token", format!("{error}"), "give one by --token-file FILE")
        })?;
        let letter = |byte: &u8| char::from(LETTERS[usize::from(byte % 32)]);
        Ok(Self(bytes.iter().map(letter).collect()))
    }

    /// The one in the file `path`: one line of at least 16 letters, digits, `-` or `_`.
    ///
    /// # Errors
    /// When the file cannot be read, or holds none.
    pub fn from_file(path: &Path) -> Result<Self, PageError> {
        let file = || format!("the token in {}", path.display());
        let text = read_text(path)
            .map_err(|error| PageError::new(file(), format!("{error}"), "write one line into that file"))?;
        let token = text.trim();
        let plain = |letter: char| letter.is_ascii_alphanumeric() || matches!(letter, '-' | '_');
        if token.len() < LEAST || !token.chars().all(plain) {
            let why = format!("it has to be one line of at least {LEAST} letters, digits, - or _");
            let remedy = format!("openssl rand -hex 16 > {}", path.display());
            return Err(PageError::new(file(), why, remedy));
        }
        Ok(Self(token.into()))
    }

    /// Whether `candidate` is the token, in a time that does not tell how much of it is right.
    #[must_use]
    pub fn admits(&self, candidate: &str) -> bool {
        self.0.as_bytes().ct_eq(candidate.as_bytes()).into()
    }

    /// The token in plain letters.
    #[must_use]
    pub fn reveal(&self) -> &str {
        &self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_are_the_same_and_only_the_whole_admits() {
        let (one, two) = (Token::generate().expect("random"), Token::generate().expect("random"));
        assert_eq!(one.reveal().len(), LENGTH);
        assert!(one.admits(one.reveal()) && !one.admits(two.reveal()));
        assert!(!one.admits("") && !one.admits(&one.reveal()[1..]));
        assert_eq!(format!("{one:?}"), "Token(..)");
    }

    #[test]
    fn a_short_or_spaced_token_in_a_file_is_refused() {
        let path = std::env::temp_dir().join(format!("meniscus-{}.token", std::process::id()));
        for (text, good) in [("0123456789abcdef\n", true), ("short", false), ("0123456789 abcdef", false)] {
            std::fs::write(&path, text).expect("written");
            assert_eq!(Token::from_file(&path).is_ok(), good, "{text}");
        }
        std::fs::remove_file(&path).expect("removed");
        let message = format!("{}", Token::from_file(&path).expect_err("no file"));
        assert!(message.contains("What to do: write one line"), "{message}");
    }
}
