//! Attacks on the signatures of models.

use crate::boards::{board, flash, meniscus, said};
use crate::support::Scratch;
use std::fs;

/// An older signed model does not come back by itself.
///
/// A flash of an earlier release, and an `active` that was edited by hand.
#[test]
fn an_older_signed_model_does_not_come_back() {
    let scratch = Scratch::new("rollback");
    board(&scratch.0);
    for (name, release) in [("a", 5), ("b", 6)] {
        assert!(flash(&scratch.0, name, release, &[]).status.success());
    }
    let older = flash(&scratch.0, "a", 5, &[]);
    assert!(!older.status.success() && said(&older).contains("release 5"), "{}", said(&older));
    let unnumbered = flash(&scratch.0, "a", 0, &[]);
    assert!(!unnumbered.status.success(), "{}", said(&unnumbered));
    fs::write(scratch.0.join("slots/active"), "a\n").expect("written");
    // The next flash reads which slot boots: the later release still does, so the other slot is written.
    let again = flash(&scratch.0, "b", 6, &["--json"]);
    assert!(String::from_utf8_lossy(&again.stdout).contains("\"slot\": \"A\""), "{again:?}");
    let allowed = flash(&scratch.0, "a", 5, &["--allow-rollback"]);
    assert!(allowed.status.success(), "{}", said(&allowed));
}

/// With a key, no way starts an unsigned model.
///
/// `run --model FILE`, and a folder of slots, each with the profile; an altered model with the signature of the true one.
#[test]
fn a_key_covers_every_way_in() {
    let scratch = Scratch::new("key");
    board(&scratch.0);
    let run = |model: &str| {
        let words =
            ["run", "--model", model, "--profile", "board.toml", "--patient", "--seconds", "1.5", "--json"];
        meniscus(&scratch.0, &words)
    };
    let unsigned = run("a.blob");
    assert!(
        !unsigned.status.success() && said(&unsigned).contains("a.blob.sig is no signature"),
        "{}",
        said(&unsigned)
    );
    fs::copy(scratch.0.join("a.0.sig"), scratch.0.join("a.blob.sig")).expect("copied");
    let signed = run("a.blob");
    assert!(signed.status.success(), "{}", said(&signed));
    fs::copy(scratch.0.join("a.0.sig"), scratch.0.join("b.blob.sig")).expect("copied");
    assert!(!run("b.blob").status.success(), "the signature of another model");
    let plain = meniscus(&scratch.0, &["flash", "b.blob", "--to", "slots"]);
    assert!(plain.status.success(), "{}", said(&plain));
    let slots = run("slots");
    assert!(!slots.status.success() && said(&slots).contains("no signature"), "{}", said(&slots));
}

/// The number of a release cannot be raised by hand.
///
/// The signature file of release 5 with the number 9 in it: in a slot, beside a model, and given to `flash`.
#[test]
fn the_number_of_a_release_is_signed() {
    let scratch = Scratch::new("raised");
    board(&scratch.0);
    for (name, release) in [("a", 5), ("b", 6)] {
        assert!(flash(&scratch.0, name, release, &[]).status.success());
    }
    let slot = scratch.0.join("slots/slot-a.sig");
    let mut forged = fs::read(&slot).expect("the signature of release 5");
    assert_eq!(forged.len(), 72, "number and signature");
    forged[..8].copy_from_slice(&9_u64.to_le_bytes());
    fs::write(&slot, &forged).expect("written");
    fs::write(scratch.0.join("slots/active"), "a\n").expect("written");
    let run =
        ["run", "--model", "slots", "--profile", "board.toml", "--patient", "--seconds", "1.5", "--json"];
    let booted = meniscus(&scratch.0, &run);
    let words = said(&booted);
    assert!(booted.status.success() && words.contains("the signature does not belong"), "{words}");
    fs::write(scratch.0.join("a.blob.sig"), &forged).expect("written");
    let beside = ["run", "--model", "a.blob", "--profile", "board.toml", "--patient", "--seconds", "1.5"];
    let refused = meniscus(&scratch.0, &beside);
    assert!(!refused.status.success() && said(&refused).contains("does not belong"), "{}", said(&refused));
    let words = ["flash", "a.blob", "--signature", "a.blob.sig", "--profile", "board.toml"];
    let flashed = meniscus(&scratch.0, &words);
    assert!(!flashed.status.success() && said(&flashed).contains("does not belong"), "{}", said(&flashed));
    assert!(flash(&scratch.0, "b", 6, &[]).status.success(), "release 6 is the latest still");
}
