//! A board's folder with slots, signed models and a profile, for several classes of attacks.

use crate::support::meniscus_command;
use ed25519_dalek::{Signer, SigningKey};
use std::fs;
use std::path::Path;
use std::process::Output;

/// Runs `meniscus` with `arguments` in `folder`.
pub(crate) fn meniscus(folder: &Path, arguments: &[&str]) -> Output {
    meniscus_command().args(arguments).current_dir(folder).output().expect("it starts")
}

/// Returns what the program wrote to its standard error.
pub(crate) fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// The shipped model as `a.blob`, a sibling of it as `b.blob`, signatures by one key as openssl makes them, and the profile of a
/// board with that key.
pub(crate) fn board(folder: &Path) {
    let key = SigningKey::from_bytes(&[7; 32]);
    let hex = key.verifying_key().to_bytes().map(|byte| format!("{byte:02x}")).concat();
    let slots = folder.join("slots");
    fs::create_dir_all(&slots).expect("a folder");
    let profile = format!("name = 'a test'\nslots = '{}'\npublic_key = '{hex}'\n", slots.display());
    fs::write(folder.join("board.toml"), profile).expect("written");
    let sibling = meniscus_service::flash::sibling(meniscus_shipped::MODEL);
    for (name, blob) in [("a", meniscus_shipped::MODEL), ("b", &sibling[..])] {
        fs::write(folder.join(format!("{name}.blob")), blob).expect("written");
        for release in [0, 5, 6] {
            let file = format!("{name}.{release}");
            let to_sign =
                ["flash", &format!("{name}.blob"), "--release", &release.to_string(), "--to-sign", &file];
            let output = meniscus(folder, &to_sign);
            assert!(output.status.success(), "{}", said(&output));
            let bytes = fs::read(folder.join(&file)).expect("the bytes to sign");
            fs::write(folder.join(format!("{file}.sig")), key.sign(&bytes).to_bytes()).expect("written");
        }
    }
}

/// Flashes `NAME.blob` as `release` with the profile and more `options`.
pub(crate) fn flash(folder: &Path, name: &str, release: u64, options: &[&str]) -> Output {
    let (blob, signature, number) =
        (format!("{name}.blob"), format!("{name}.{release}.sig"), release.to_string());
    let own = ["flash", &blob, "--release", &number, "--signature", &signature, "--profile", "board.toml"];
    meniscus(folder, &[&own, options].concat())
}
