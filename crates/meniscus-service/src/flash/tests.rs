use super::*;
use ed25519_dalek::{Signer, SigningKey};

const MODEL: &[u8] = meniscus_shipped::MODEL;

fn folder(name: &str) -> Folder {
    let path = std::env::temp_dir().join(format!("meniscus-flash-{name}-{}", std::process::id()));
    let _old = std::fs::remove_dir_all(&path);
    Folder::create(&path).expect("a temporary folder")
}

#[test]
fn the_slots_take_turns_and_the_last_one_boots() {
    let (mut disk, second) = (folder("turns"), sibling(MODEL));
    assert!(matches!(boot(&disk, None), Err(FlashError::NoneBoots(_))), "an empty folder");
    for (blob, slot) in [(MODEL, Slot::A), (&second[..], Slot::B), (MODEL, Slot::A)] {
        assert_eq!(flash(&mut disk, blob, None, None).expect("flashed"), slot);
        let booted = boot(&disk, None).expect("boots");
        assert_eq!((booted.slot, booted.fell_back.is_none()), (slot, true));
        assert!(*booted.blob == *blob);
    }
}

#[test]
fn a_damaged_slot_falls_back_and_is_the_next_to_be_written() {
    let (mut disk, second) = (folder("damaged"), sibling(MODEL));
    flash(&mut disk, MODEL, None, None).expect("flashed");
    flash(&mut disk, &second, None, None).expect("flashed");
    disk.write("slot-b.blob", &second[..1000]).expect("damaged");
    let booted = boot(&disk, None).expect("boots");
    assert_eq!(booted.slot, Slot::A);
    assert!(booted.fell_back.expect("it says why").to_string().contains("refused"));
    assert_eq!(
        flash(&mut disk, &second, None, None).expect("flashed"),
        Slot::B,
        "the one that boots is kept"
    );
    assert!(boot(&disk, None).expect("boots").fell_back.is_none());
}

#[test]
fn a_key_refuses_what_is_unsigned_or_signed_by_another() {
    let hex = |key: &SigningKey| key.verifying_key().to_bytes().map(|byte| format!("{byte:02x}")).concat();
    let (own, foreign) = (SigningKey::from_bytes(&[7; 32]), SigningKey::from_bytes(&[8; 32]));
    let key = PublicKey::from_hex(&hex(&own)).expect("a key");
    let mut disk = folder("signed");
    let signed = |by: &SigningKey, blob: &[u8]| by.sign(blob).to_bytes();
    assert!(matches!(flash(&mut disk, MODEL, None, Some(&key)), Err(FlashError::Unsigned)));
    let wrong = signed(&foreign, MODEL);
    assert!(matches!(flash(&mut disk, MODEL, Some(&wrong), Some(&key)), Err(FlashError::Signature)));
    let right = signed(&own, MODEL);
    assert!(matches!(
        flash(&mut disk, &sibling(MODEL), Some(&right), Some(&key)),
        Err(FlashError::Signature)
    ));
    assert_eq!(flash(&mut disk, MODEL, Some(&right), Some(&key)).expect("flashed"), Slot::A);
    assert!(boot(&disk, Some(&key)).is_ok());
    let other = PublicKey::from_hex(&hex(&foreign)).expect("a key");
    assert!(boot(&disk, Some(&other)).is_err(), "the key counts at the boot too");
    assert!(matches!(PublicKey::from_hex("12"), Err(FlashError::Key(_))));
}

#[test]
fn two_hundred_power_cuts_leave_a_blob_that_boots() {
    let second = sibling(MODEL);
    let done = rehearse([MODEL, &second], 200, 1);
    assert_eq!(done.first_failure, None);
    assert_eq!((done.cuts, done.survived), (200, 200));
    assert!(done.new > 20 && done.new < 180, "{done:?}: cuts before and behind the switch");
}

/// The rehearsal can fail: a disk that says it synced and did not is found out.
#[test]
fn a_disk_that_does_not_sync_is_found_out() {
    let done = power_loss::rehearse_on(power_loss::Forgetful::careless(), [MODEL, &sibling(MODEL)], 50, 1);
    assert!(done.survived < 50 && done.first_failure.is_some(), "{done:?}");
}
