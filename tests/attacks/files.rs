//! Attacks on the slots of the models, on the package and on files beside those that are written.

use crate::support::{Scratch, meniscus_command};
use ed25519_dalek::{Signer, SigningKey};
use std::fs;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::Path;
use std::process::{Command, Output, Stdio};

/// Runs `meniscus` with `arguments` in `folder`.
fn meniscus(folder: &Path, arguments: &[&str]) -> Output {
    meniscus_command().args(arguments).current_dir(folder).output().expect("it starts")
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// The shipped model as `a.blob`, a sibling of it as `b.blob`, signatures by one key as openssl makes them, and the profile of a
/// board with that key.
fn board(folder: &Path) {
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
fn flash(folder: &Path, name: &str, release: u64, options: &[&str]) -> Output {
    let (blob, signature, number) =
        (format!("{name}.blob"), format!("{name}.{release}.sig"), release.to_string());
    let own = ["flash", &blob, "--release", &number, "--signature", &signature, "--profile", "board.toml"];
    meniscus(folder, &[&own, options].concat())
}

/// A flash follows no link that somebody has put into its folder.
///
/// Links in the place of each part file and each slot; the file behind them stays, and no slot is a link afterwards.
#[test]
fn a_flash_follows_no_planted_link() {
    let scratch = Scratch::new("links");
    board(&scratch.0);
    let victim = scratch.0.join("victim");
    fs::write(&victim, "kept").expect("written");
    let names = ["slot-a.blob", "slot-a.sig", "slot-b.blob", "slot-b.sig", "active"];
    for name in names.iter().flat_map(|name| [(*name).to_owned(), format!("{name}.part")]) {
        symlink(&victim, scratch.0.join("slots").join(name)).expect("a link");
    }
    for (name, release) in [("a", 5), ("b", 6)] {
        let output = flash(&scratch.0, name, release, &[]);
        assert!(output.status.success(), "{}", said(&output));
    }
    assert_eq!(fs::read(&victim).expect("readable"), b"kept");
    for name in names {
        let kind = fs::symlink_metadata(scratch.0.join("slots").join(name)).expect("there").file_type();
        assert!(kind.is_file(), "{name} is a link");
    }
    let left = fs::read_dir(scratch.0.join("slots")).expect("listed").count();
    assert_eq!(left, names.len(), "no part file is left");
}

/// Two flashes at once leave a slot that boots, and one of them says that it has to wait.
///
/// Eight pairs at the same moment.
#[test]
fn two_flashes_at_once_do_not_mix() {
    let scratch = Scratch::new("pairs");
    board(&scratch.0);
    for pair in 0..8 {
        let start = |name: &str| {
            let mut command = meniscus_command();
            command.args(["flash", name, "--to", "slots"]).current_dir(&scratch.0);
            command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("it starts")
        };
        let both = [start("a.blob"), start("b.blob")].map(|child| child.wait_with_output().expect("it ends"));
        let good = both.iter().filter(|output| output.status.success()).count();
        assert!(good >= 1, "pair {pair}: {} {}", said(&both[0]), said(&both[1]));
        for output in both.iter().filter(|output| !output.status.success()) {
            assert!(said(output).contains("another flash is under way"), "pair {pair}: {}", said(output));
        }
        let booted =
            meniscus(&scratch.0, &["run", "--model", "slots", "--patient", "--seconds", "1.5", "--json"]);
        assert!(booted.status.success(), "pair {pair}: {}", said(&booted));
        assert!(!said(&booted).contains("is used"), "pair {pair}: {}", said(&booted));
    }
}

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

/// The package's script does nothing as root in the folder of its user.
///
/// The script runs with commands that only write down how they are called.
#[test]
fn the_package_works_in_its_users_folder_as_that_user() {
    let scratch = Scratch::new("postinst");
    let (tools, calls) = (scratch.0.join("tools"), scratch.0.join("calls"));
    fs::create_dir(&tools).expect("a folder");
    let names = [
        "getent",
        "adduser",
        "install",
        "meniscus",
        "chown",
        "chmod",
        "cp",
        "mv",
        "ln",
        "runuser",
        "udevadm",
        "systemctl",
        "deb-systemd-helper",
        "deb-systemd-invoke",
    ];
    for name in names {
        let tool = tools.join(name);
        fs::write(&tool, format!("#!/bin/sh\necho {name} \"$@\" >>'{}'\n", calls.display()))
            .expect("written");
        fs::set_permissions(&tool, fs::Permissions::from_mode(0o755)).expect("executable");
    }
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/../firmware-config/systemd/postinst");
    let path = format!("{}:/usr/bin:/bin", tools.display());
    let status =
        Command::new("/bin/sh").args([script, "configure"]).env("PATH", path).status().expect("a shell");
    assert!(status.success());
    let calls = fs::read_to_string(&calls).expect("calls");
    let flashes = "runuser -u meniscus -- meniscus flash shipped --to /var/lib/meniscus";
    assert!(calls.lines().any(|line| line == flashes), "{calls}");
    for line in calls.lines().filter(|line| *line != flashes) {
        let own = line == "install -d -o meniscus -g plugdev /var/lib/meniscus";
        assert!(own || !line.contains("/var/lib/meniscus"), "as root: {line}");
    }
}

/// A file that is written replaces a link beside it, and leaves what the link points to.
///
/// A link in the place of the part file of a run's report.
#[test]
fn a_report_follows_no_planted_link() {
    let scratch = Scratch::new("report");
    let victim = scratch.0.join("victim");
    fs::write(&victim, "kept").expect("written");
    fs::create_dir(scratch.0.join("out")).expect("a folder");
    symlink(&victim, scratch.0.join("out/run.json.part")).expect("a link");
    let run = meniscus(&scratch.0, &["run", "--patient", "--seconds", "1.5", "--json", "--out", "out"]);
    assert!(run.status.success(), "{}", said(&run));
    assert_eq!(fs::read(&victim).expect("readable"), b"kept");
    assert!(fs::symlink_metadata(scratch.0.join("out/run.json")).expect("there").is_file());
}
