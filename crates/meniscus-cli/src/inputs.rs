//! Inputs of several verbs: models and recordings.

use super::kind::{Kind, expect};
use super::profile::Profile;
use anyhow::{Context, ensure};
use meniscus_data::recording::Recording;
use meniscus_platform::files::{AlignedBytes, Links, read_regular};
use meniscus_service::flash::{FlashPolicy, Flashed, Folder, Signed, boot, check};
use std::path::Path;
#[cfg(feature = "studies")]
use std::path::PathBuf;

/// Bytes of a signature file at the most.
pub(super) const SIGNATURE_FILE: u64 = 1024;

/// Profile of the board that the program runs on.
const BOARD: &str = "/etc/meniscus/board.toml";

/// The bytes of a model where weights can be read in place: the one in the program (`shipped`), a file, or what
/// boots of a folder with slots; where such a folder falls back to its other slot, that is said.
///
/// With a key in `profile`, or in that of the board whose slots these are, each way needs a signature. The model in the program
/// needs none: who changes it can change the check, too.
pub(super) fn blob(path: &Path, profile: Option<&Profile>) -> anyhow::Result<AlignedBytes> {
    if !path.is_dir() {
        let blob = file(path)?;
        if let Some(policy) =
            profile.map(Profile::policy).transpose()?.filter(|_| path != Path::new("shipped"))
        {
            check_signed(path, &blob, &policy)?;
        }
        return Ok(blob);
    }
    expect(path, Kind::Slots, "a folder of `meniscus flash`")?;
    let board = if profile.is_none() { Profile::of_slots(Path::new(BOARD), path)? } else { None };
    let policy = profile.or(board.as_ref()).map(Profile::policy).transpose()?.unwrap_or_default();
    let booted = boot(&Folder::at(path), &policy)?;
    if let Some(why) = &booted.fell_back {
        eprintln!(
            "the model in {} that should start does not ({why}): slot {:?} is used",
            path.display(),
            booted.slot
        );
    }
    Ok(booted.blob)
}

/// Refuses the `blob` of the file at `path` where the policy has a key and FILE.sig beside it is no signature of it.
fn check_signed(path: &Path, blob: &[u8], policy: &FlashPolicy) -> anyhow::Result<()> {
    if policy.key.is_none() {
        return Ok(());
    }
    let mut beside = path.as_os_str().to_owned();
    beside.push(".sig");
    let beside = Path::new(&beside);
    let signed =
        read_regular(beside, SIGNATURE_FILE, Links::Followed).ok().and_then(|bytes| Signed::read(&bytes));
    let checked = check(Flashed { blob, signed }, policy);
    checked.map(drop).with_context(|| {
        format!(
            "{} does not start: the profile has a key, and {} is no signature of it by that key",
            path.display(),
            beside.display()
        )
    })
}

/// The bytes of a model, the one in the program (`shipped`) or a file.
pub(super) fn file(model: impl AsRef<Path>) -> anyhow::Result<AlignedBytes> {
    let path = model.as_ref();
    if path == Path::new("shipped") {
        return Ok(AlignedBytes::copy(meniscus_shipped::MODEL));
    }
    expect(path, Kind::Model, "a weight blob")?;
    AlignedBytes::read(path)
        .context("a model is shipped, a blob of `meniscus train` or `correct`, or a folder of `flash`")
}

/// The recording of the simulator in `file`.
pub(super) fn recording(file: &Path) -> anyhow::Result<Recording> {
    expect(file, Kind::Simulated, "a recording of the simulator")?;
    Ok(Recording::load(file)?)
}

#[cfg(feature = "studies")]
/// The recordings that `paths` name, a folder standing for its files that begin with `prefix`, each read by `read`:
/// `plain` or [`level`].
pub(super) fn recordings(
    paths: &[PathBuf],
    prefix: &str,
    read: fn(&Path) -> anyhow::Result<Recording>,
) -> anyhow::Result<Vec<Recording>> {
    files(paths, prefix)?.iter().map(|file| read(file)).collect()
}

#[cfg(feature = "studies")]
/// The files that `paths` name, a folder standing for its files that begin with `prefix`; each file once.
pub(super) fn files(paths: &[PathBuf], prefix: &str) -> anyhow::Result<Vec<PathBuf>> {
    let mut files: Vec<PathBuf> = Vec::new();
    for path in paths {
        let named = if path.is_dir() { in_folder(path, prefix)? } else { vec![path.clone()] };
        for file in named {
            ensure!(
                !files.iter().any(|other| same(other, &file)),
                "{} is given twice: name each recording once",
                file.display()
            );
            files.push(file);
        }
    }
    Ok(files)
}

#[cfg(feature = "studies")]
/// Whether two names are of one file.
fn same(one: &Path, other: &Path) -> bool {
    one == other
        || one.canonicalize().ok().is_some_and(|one| other.canonicalize().is_ok_and(|other| one == other))
}

#[cfg(feature = "train")]
/// Refuses a recording that is both learnt from and judged by.
pub(super) fn check_apart(learnt: &[PathBuf], judged: &[PathBuf]) -> anyhow::Result<()> {
    let both = judged.iter().find(|file| learnt.iter().any(|other| same(other, file)));
    both.map_or(Ok(()), |file| {
        anyhow::bail!(
            "{} is in --recordings and in --validate: a model is judged on recordings that it did not learn from",
            file.display()
        )
    })
}

#[cfg(feature = "train")]
/// The recording in `file`, of an upright cylinder moved along x, as a model's training wants it.
pub(super) fn plain(file: &Path) -> anyhow::Result<Recording> {
    let recording = level(file)?;
    ensure!(
        recording.is_plain(),
        "{} is of a glass that leaves the line along x: models are trained on glasses that keep to it",
        file.display()
    );
    Ok(recording)
}

#[cfg(feature = "studies")]
/// The recording in `file`, of an upright cylinder on its table, as the rendered camera shows it.
pub(super) fn level(file: &Path) -> anyhow::Result<Recording> {
    let recording = recording(file)?;
    check_level(&recording, &file.display())?;
    Ok(recording)
}

/// Refuses what the rendered camera does not show; `name` is that of the recording.
pub(super) fn check_level(recording: &Recording, name: &dyn std::fmt::Display) -> anyhow::Result<()> {
    ensure!(
        recording.is_level(),
        "{name} is of a conical, round, lifted or inclined glass: the rendered camera shows upright cylinders on a table"
    );
    Ok(())
}

#[cfg(feature = "studies")]
fn in_folder(folder: &Path, prefix: &str) -> anyhow::Result<Vec<PathBuf>> {
    let entries = folder.read_dir().with_context(|| format!("{} cannot be listed", folder.display()))?;
    let mut files: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    files.retain(|file| {
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        name.starts_with(prefix)
            && name.ends_with(".safetensors")
            && !name.ends_with(".particles.safetensors")
    });
    // The order of a folder is not defined, and the order of recordings is part of the seed.
    files.sort();
    ensure!(
        !files.is_empty(),
        "{} holds no {prefix}*.safetensors: `meniscus simulate --out` writes recordings",
        folder.display()
    );
    Ok(files)
}
