use super::*;
use ed25519_dalek::{Signer, SigningKey};

const MODEL: &[u8] = meniscus_shipped::MODEL;

fn plain(blob: &[u8]) -> Flashed<'_> {
    Flashed { blob, signed: None }
}

fn folder(name: &str) -> Folder {
    let path = std::env::temp_dir().join(format!("meniscus-flash-{name}-{}", std::process::id()));
    let _old = std::fs::remove_dir_all(&path);
    Folder::create(&path).expect("a temporary folder")
}

#[test]
fn the_slots_take_turns_and_the_last_one_boots() {
    let (mut disk, second) = (folder("turns"), sibling(MODEL));
    assert!(matches!(boot(&disk, &FlashPolicy::default()), Err(FlashError::NoneBoots(_))), "an empty folder");
    for (blob, slot) in [(MODEL, Slot::A), (&second[..], Slot::B), (MODEL, Slot::A)] {
        assert_eq!(flash(&mut disk, plain(blob), &FlashPolicy::default()).expect("flashed"), slot);
        let booted = boot(&disk, &FlashPolicy::default()).expect("boots");
        assert_eq!((booted.slot, booted.fell_back.is_none()), (slot, true));
        assert!(*booted.blob == *blob);
    }
}

#[test]
fn a_damaged_slot_falls_back_and_is_the_next_to_be_written() {
    let (mut disk, second) = (folder("damaged"), sibling(MODEL));
    flash(&mut disk, plain(MODEL), &FlashPolicy::default()).expect("flashed");
    flash(&mut disk, plain(&second), &FlashPolicy::default()).expect("flashed");
    disk.write("slot-b.blob", &second[..1000]).expect("damaged");
    let booted = boot(&disk, &FlashPolicy::default()).expect("boots");
    assert_eq!(booted.slot, Slot::A);
    assert!(booted.fell_back.expect("it says why").to_string().contains("refused"));
    assert_eq!(
        flash(&mut disk, plain(&second), &FlashPolicy::default()).expect("flashed"),
        Slot::B,
        "the one that boots is kept"
    );
    assert!(boot(&disk, &FlashPolicy::default()).expect("boots").fell_back.is_none());
}

fn hex(key: &SigningKey) -> String {
    key.verifying_key().to_bytes().map(|byte| format!("{byte:02x}")).concat()
}

fn policy_of(key: &SigningKey) -> FlashPolicy {
    let key = Some(PublicKey::from_hex(&hex(key)).expect("a key"));
    FlashPolicy { key, ..FlashPolicy::default() }
}

/// `blob` signed as `release` by `key`.
fn signed<'b>(key: &SigningKey, release: u64, blob: &'b [u8]) -> Flashed<'b> {
    let release = Release(release);
    let signature = key.sign(&release.signed_bytes(blob)).to_bytes();
    Flashed { blob, signed: Some(Signed { release, signature }) }
}

#[test]
fn a_key_refuses_what_is_unsigned_or_signed_by_another() {
    let (own, foreign) = (SigningKey::from_bytes(&[7; 32]), SigningKey::from_bytes(&[8; 32]));
    let (mut disk, policy, second) = (folder("signed"), policy_of(&own), sibling(MODEL));
    let mut refused = |flashed| flash(&mut disk, flashed, &policy).expect_err("refused");
    assert!(matches!(refused(plain(MODEL)), FlashError::Unsigned));
    assert!(matches!(refused(signed(&foreign, 0, MODEL)), FlashError::Signature));
    let right = signed(&own, 0, MODEL);
    assert!(matches!(refused(Flashed { blob: &second, ..right }), FlashError::Signature));
    // The number is signed, too.
    let numbered = signed(&own, 3, MODEL);
    let renumbered = numbered.signed.map(|signed| Signed { release: Release(4), ..signed });
    assert!(matches!(refused(Flashed { signed: renumbered, ..numbered }), FlashError::Signature));
    assert_eq!(flash(&mut disk, right, &policy).expect("flashed"), Slot::A);
    assert!(boot(&disk, &policy).is_ok());
    assert!(boot(&disk, &policy_of(&foreign)).is_err(), "the key counts at the boot too");
    assert!(matches!(PublicKey::from_hex("12"), Err(FlashError::Key(_))));
}

#[test]
fn an_earlier_release_comes_back_on_purpose_only() {
    let (key, second) = (SigningKey::from_bytes(&[7; 32]), sibling(MODEL));
    let (mut disk, policy) = (folder("rollback"), policy_of(&key));
    flash(&mut disk, signed(&key, 5, MODEL), &policy).expect("flashed");
    flash(&mut disk, signed(&key, 6, &second), &policy).expect("flashed");
    let refused = flash(&mut disk, signed(&key, 5, MODEL), &policy).expect_err("earlier");
    assert!(matches!(refused, FlashError::Rollback { release: Release(5), least: Release(6) }), "{refused}");
    // The file that is not signed does not bring it back either.
    disk.write("active", b"a\n").expect("written");
    assert_eq!(boot(&disk, &policy).expect("boots").release, Release(6));
    let allowed = FlashPolicy { rollback: Rollback::Allowed, ..policy.clone() };
    flash(&mut disk, signed(&key, 5, MODEL), &allowed).expect("on purpose");
    let booted = boot(&disk, &policy).expect("boots");
    assert_eq!((booted.release, *booted.blob == *MODEL), (Release(5), true));
    let floor = FlashPolicy { least: Release(6), ..allowed };
    assert!(boot(&disk, &floor).is_err(), "the profile's floor");
    assert!(matches!(flash(&mut disk, signed(&key, 5, MODEL), &floor), Err(FlashError::Rollback { .. })));
}

#[test]
fn one_flash_at_a_time_and_no_parts_are_left() {
    let mut disk = folder("alone");
    disk.write("slot-b.blob.part", b"a flash that was killed").expect("written");
    let held = disk.begin().expect("locked");
    let refused = flash(&mut disk.clone(), plain(MODEL), &FlashPolicy::default()).expect_err("refused");
    assert!(
        matches!(&refused, FlashError::Busy(_)) && refused.to_string().contains("under way"),
        "{refused}"
    );
    drop(held);
    flash(&mut disk, plain(MODEL), &FlashPolicy::default()).expect("flashed");
    assert!(disk.read("slot-b.blob.part").is_err());
}

#[test]
fn two_hundred_power_cuts_leave_a_blob_that_boots() {
    let second = sibling(MODEL);
    let done = rehearse([MODEL, &second], 200, 1);
    assert_eq!(done.first_failure, None);
    assert_eq!((done.cuts, done.survived), (200, 200));
    assert!(done.new > 20 && done.new < 180, "{done:?}: cuts before and behind the switch");
    let done = rehearse_signed([MODEL, &second], 60, 2);
    assert_eq!((done.first_failure.as_deref(), done.survived), (None, 60));
    assert!(done.new > 5 && done.new < 55, "{done:?}: cuts before and behind the switch");
}

/// The rehearsal can fail: a disk that says it synced and did not is found out.
#[test]
fn a_disk_that_does_not_sync_is_found_out() {
    let second = sibling(MODEL);
    let rehearsal = power_loss::Rehearsal { blobs: [MODEL, &second], cuts: 50, seed: 1, key: None };
    let done = power_loss::rehearse_on(power_loss::Forgetful::careless(), &rehearsal);
    assert!(done.survived < 50 && done.first_failure.is_some(), "{done:?}");
}
