//! A board's profile: one TOML file that says what is particular of it.

use anyhow::{Context, ensure};
use meniscus_service::flash::PublicKey;
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// Content of a profile; `firmware-config/boards/` has one a board.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Profile {
    /// The board, in words.
    pub(crate) name: String,
    /// The folder with the two slots of the model.
    pub(crate) slots: PathBuf,
    /// Ed25519 public key, 64 hexadecimal digits; with it no blob boots or is written that it did not sign.
    #[serde(default)]
    public_key: Option<String>,
}

impl Profile {
    /// Reads a profile.
    pub(crate) fn read(path: &Path) -> anyhow::Result<Self> {
        let text = std::fs::read_to_string(path)
            .with_context(|| format!("cannot read the profile {}", path.display()))?;
        let profile: Self =
            toml::from_str(&text).with_context(|| format!("{} is no board profile", path.display()))?;
        ensure!(profile.slots.is_absolute(), "{}: slots must be an absolute path", path.display());
        profile.key()?;
        Ok(profile)
    }

    /// Its key, if it has one.
    pub(crate) fn key(&self) -> anyhow::Result<Option<PublicKey>> {
        Ok(self.public_key.as_deref().map(PublicKey::from_hex).transpose()?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_profile_that_comes_along_reads() {
        let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../firmware-config/boards"));
        let files: Vec<_> = std::fs::read_dir(folder).expect("the folder").flatten().collect();
        assert!(files.len() >= 3);
        for file in files {
            let profile = Profile::read(&file.path()).expect("a profile");
            assert!(!profile.name.is_empty(), "{profile:?}");
        }
    }

    #[test]
    fn a_misspelt_word_and_a_bad_key_are_refused() {
        let path = std::env::temp_dir().join(format!("meniscus-profile-{}.toml", std::process::id()));
        for text in [
            "name = 'x'\nslots = '/x'\npublic_kye = ''",
            "name = 'x'\nslots = 'x'",
            "name = 'x'\nslots = '/x'\npublic_key = '12'",
        ] {
            std::fs::write(&path, text).expect("written");
            assert!(Profile::read(&path).is_err(), "{text}");
        }
        std::fs::remove_file(&path).expect("removed");
    }
}
