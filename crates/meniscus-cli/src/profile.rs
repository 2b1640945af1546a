//! A board's profile: one TOML file that says what is particular of it.

use anyhow::{Context, ensure};
use meniscus_platform::files::read_text;
use meniscus_service::flash::{FlashPolicy, PublicKey, Release, Rollback};
use serde::Deserialize;
use std::net::IpAddr;
use std::path::{Path, PathBuf};

/// Content of a profile; `firmware-config/boards/` has one a board.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Profile {
    /// The board, in words.
    pub(crate) name: String,
    /// The folder with the two slots of the model.
    pub(crate) slots: PathBuf,
    /// Ed25519 public key, 64 hexadecimal digits; with it no blob boots or is written that it did not sign.
    #[serde(default)]
    public_key: Option<String>,
    /// Earliest release that the key must have signed.
    #[serde(default)]
    least_release: u64,
    /// Only address whose samples `run --motion udp:` takes.
    #[serde(default)]
    pub(crate) motion_from: Option<IpAddr>,
    /// File of the word that each of its datagrams has to begin with.
    #[serde(default)]
    pub(crate) motion_token_file: Option<PathBuf>,
}

impl Profile {
    /// Reads a profile.
    pub(crate) fn read(path: &Path) -> anyhow::Result<Self> {
        let text = read_text(path).with_context(|| format!("cannot read the profile {}", path.display()))?;
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

    /// Returns the rules for its slots.
    pub(crate) fn policy(&self) -> anyhow::Result<FlashPolicy> {
        let least = Release(self.least_release);
        Ok(FlashPolicy { key: self.key()?, least, rollback: Rollback::Refused })
    }

    /// Returns the profile at `path` if it is there and names `folder` as its slots: a board's rules hold without --profile.
    pub(crate) fn of_slots(path: &Path, folder: &Path) -> anyhow::Result<Option<Self>> {
        if !path.exists() {
            return Ok(None);
        }
        let profile = Self::read(path)?;
        let same = |one: &Path| std::fs::canonicalize(one).ok();
        let own = same(folder).is_some_and(|folder| same(&profile.slots) == Some(folder));
        Ok(own.then_some(profile))
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

    #[test]
    fn a_boards_profile_holds_for_its_own_slots_alone() {
        let folder = std::env::temp_dir().join(format!("meniscus-board-{}", std::process::id()));
        std::fs::create_dir_all(folder.join("slots")).expect("a folder");
        let (path, slots) = (folder.join("board.toml"), folder.join("slots"));
        assert!(Profile::of_slots(&path, &slots).expect("none").is_none());
        std::fs::write(&path, format!("name = 'x'\nslots = '{}'\nleast_release = 3", slots.display()))
            .expect("written");
        let profile =
            Profile::of_slots(&path, &folder.join("slots/../slots")).expect("read").expect("its own");
        assert_eq!(profile.policy().expect("rules").least, Release(3));
        assert!(Profile::of_slots(&path, &folder).expect("read").is_none());
        std::fs::remove_dir_all(&folder).expect("removed");
    }
}
