//! `tests/corpus`: small files, each of which ends a reader in another way. They are read as they are, so that a change of
//! format or checksum cannot hide the parsers from the fuzzing unnoticed.
//!
//! `MENISCUS_BLESS=1 cargo test --release -p meniscus-tests --test fuzz corpus` makes them anew by seeded mutation: for each
//! outcome that was not met before, the file that led to it.

use crate::blobs::with_header;
use crate::bytes::{configuration, sound_recording};
use crate::containers::{db3, list_edits, mcap, ros1, safetensors, safetensors_header};
use crate::mutation::{edited, edits};
use crate::recordings;
use crate::resealed::resealed;
use crate::texts::{LIQUID, SCENE, altered};
use crate::wires::{descriptors, plan};
use meniscus::blob::Model;
use meniscus_data::liquids::Liquid;
use meniscus_data::recording::Recording;
use meniscus_data::scene_file::Experiment;
use meniscus_platform::files::AlignedBytes;
use meniscus_service::controller::Plan;
use meniscus_usb::camera::{OutlineImage, Plan as CameraPlan};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Kind of a file, the outcomes that its reader must have shown at the least, and the mutations of a making.
const KINDS: [(&str, usize, u32); 9] = [
    ("bag", 8, 600),
    ("blob", 8, 3_000),
    ("db3", 8, 400),
    ("descriptors", 6, 3_000),
    ("liquid", 6, 3_000),
    ("mcap", 5, 600),
    ("plan", 8, 3_000),
    ("safetensors", 8, 1_000),
    ("scene", 8, 3_000),
];

/// Most files of a kind, and longest file, bytes.
const FILES: usize = 14;
const LONGEST: usize = 48 * 1024;

/// Instant of the plans, ns since 1970.
const NOW_NS: u64 = 1_000_000_000_000_000_000;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus")
}

/// The shipped model with `header` in the place of its own.
fn blob_of(header: &[u8]) -> Vec<u8> {
    let sound = meniscus_shipped::MODEL;
    let mut all = [header, sound.get(header.len()..).unwrap_or_default()].concat();
    all.truncate(sound.len());
    resealed(all)
}

/// Reads a recording of a camera to its end.
fn recording(name: &str, bytes: &[u8]) -> Result<String, String> {
    let folder = recordings::scratch(&format!("corpus-{name}"));
    let path = folder.0.join(name);
    std::fs::write(&path, bytes).expect("written");
    let recording = meniscus_bags::open(&path).map_err(|why| why.to_string())?;
    let mut count = 0;
    for image in recording.images.take(100) {
        image.map_err(|why| format!("after images: {why}"))?;
        count += 1;
    }
    Ok(if count == 0 { "no image" } else { "images" }.into())
}

/// Ends the reader of this kind of file; returns the way in which it ended, without numbers and quotations.
fn outcome(kind: &str, bytes: &[u8]) -> String {
    let text = || String::from_utf8_lossy(bytes).into_owned();
    let end = match kind {
        "bag" | "db3" | "mcap" => recording(&format!("a.{kind}"), bytes),
        "blob" => match Model::load(&AlignedBytes::copy(&blob_of(bytes))) {
            Ok(_) => Ok("a model".into()),
            Err(why) => Err(why.to_string()),
        },
        "descriptors" => match CameraPlan::read(bytes, (640, 480), OutlineImage::Infrared) {
            Ok(_) => Ok("a plan".into()),
            // Debug names the missing part in quotes.
            Err(why) => Err(format!("{why:?}").replace(['"', '(', ')', '{', '}', ','], " ")),
        },
        "liquid" => {
            Liquid::parse("a.toml", &text()).map(|_| "a liquid".into()).map_err(|why| why.to_string())
        }
        "plan" => match Plan::read(bytes, &[1.0, 0.0, 0.0], NOW_NS) {
            Ok(_) => Ok("a plan".into()),
            Err(why) => Err(why.to_string()),
        },
        "safetensors" => match Recording::from_bytes(Path::new("a"), &safetensors(bytes)) {
            Ok(_) => Ok("a recording".into()),
            Err(why) => Err(why.to_string()),
        },
        "scene" => Experiment::parse(Path::new("a.toml"), &text())
            .map(|scene| if scene.glass.is_some() { "a glass" } else { "no glass" }.into())
            .map_err(|why| why.to_string()),
        other => panic!("no reader of {other}"),
    };
    let (Ok(said) | Err(said)) = end;
    // What stands between quotes or marks is of the file; numbers as well.
    let mut words = Vec::new();
    for (index, part) in said.split(['\'', '"', '`', '\n', '|', '^']).enumerate() {
        if index.is_multiple_of(2) {
            words
                .extend(part.split_whitespace().filter(|word| word.chars().all(|c| c.is_ascii_alphabetic())));
        }
    }
    words.truncate(14);
    words.join(" ")
}

/// One mutation of a sound file of this kind.
fn mutated(kind: &str, runner: &mut TestRunner) -> Vec<u8> {
    fn draw<T: std::fmt::Debug>(strategy: impl Strategy<Value = T>, runner: &mut TestRunner) -> T {
        strategy.new_tree(runner).expect("a value").current()
    }
    let pairs = prop::collection::vec((any::<usize>(), any::<usize>()), 0..4);
    match kind {
        "bag" => {
            let sound = recordings::ros1(&recordings::images(2), false);
            ros1(&sound, &draw(list_edits(), runner), draw(prop::option::of(0..2_usize), runner))
        }
        "blob" => {
            let mut all = with_header(meniscus_shipped::MODEL, &draw(edits(), runner));
            all.truncate(640);
            all
        }
        "db3" => {
            let folder = recordings::scratch("corpus-make");
            let path = folder.0.join("a.db3");
            db3(&path, &draw(prop::collection::vec((any::<usize>(), any::<i64>(), edits()), 0..4), runner));
            std::fs::read(&path).expect("a database")
        }
        "descriptors" => descriptors(&draw(list_edits(), runner)),
        "liquid" => altered(LIQUID, &draw(pairs, runner)).into_bytes(),
        "mcap" => mcap(&sound_recording("mcap"), &draw(list_edits(), runner), draw(any::<bool>(), runner)),
        "plan" => edited(&plan(), &draw(edits(), runner)),
        "safetensors" => {
            let all = prop::collection::vec((any::<usize>(), any::<usize>(), any::<usize>()), 0..3);
            safetensors_header(&draw(all, runner))
        }
        _ => altered(SCENE, &draw(pairs, runner)).into_bytes(),
    }
}

/// Makes the files of one kind.
fn make(kind: &str, mutations: u32) {
    let folder = folder().join(kind);
    let _gone = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("a folder");
    let random = TestRng::from_seed(RngAlgorithm::ChaCha, &[7; 32]);
    let mut runner = TestRunner::new_with_rng(Config::default(), random);
    let mut found: BTreeMap<String, Vec<u8>> = BTreeMap::new();
    for _ in 0..mutations {
        let bytes = mutated(kind, &mut runner);
        if found.len() >= FILES || bytes.len() > LONGEST {
            continue;
        }
        found.entry(outcome(kind, &bytes)).or_insert(bytes);
    }
    for (index, (outcome, bytes)) in found.iter().enumerate() {
        println!("{kind} {index:02}: {outcome}");
        std::fs::write(folder.join(format!("{index:02}")), bytes).expect("written");
    }
}

/// No two files of a kind end its reader in the same way, and there are as many ways as there were.
#[test]
fn each_file_of_the_corpus_ends_its_reader_in_another_way() {
    // The folder's size in the repository is bounded, too.
    let mut bytes = 0;
    for (kind, least, mutations) in KINDS {
        if std::env::var_os("MENISCUS_BLESS").is_some() {
            make(kind, mutations);
        }
        let mut files: Vec<_> =
            std::fs::read_dir(folder().join(kind)).expect(kind).flatten().map(|file| file.path()).collect();
        files.sort();
        let mut outcomes: BTreeMap<String, PathBuf> = BTreeMap::new();
        for path in files {
            let file = std::fs::read(&path).expect("readable");
            bytes += file.len();
            let outcome = outcome(kind, &file);
            let before = outcomes.insert(outcome.clone(), path.clone());
            assert_eq!(before, None, "{} ends as another: {outcome}", path.display());
        }
        assert!(outcomes.len() >= least, "{kind}: {} outcomes of {least}: {outcomes:#?}", outcomes.len());
    }
    assert!(bytes < 1 << 20, "{bytes} bytes");
    assert!(outcome("descriptors", &configuration()) == "a plan");
}
