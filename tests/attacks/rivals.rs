//! Attacks by a second program that does the same at the same moment.

use crate::boards::{board, meniscus, said};
use crate::support::{Scratch, meniscus_command};
use std::process::Stdio;
use std::time::Duration;

/// Two runs do not write into one folder.
///
/// A second run, and a second recording, while the first goes on.
#[test]
fn a_second_run_into_one_folder_is_refused() {
    let scratch = Scratch::new("twice");
    for arguments in [
        &["run", "--seconds", "8", "--json", "--out", "out"][..],
        &["record", "--source", "simulated-usb", "--seconds", "8", "--force", "--out", "images"],
    ] {
        let start = || {
            let mut command = meniscus_command();
            command.args(arguments).current_dir(&scratch.0).stdout(Stdio::null()).stderr(Stdio::piped());
            command.spawn().expect("it starts")
        };
        let mut first = start();
        std::thread::sleep(Duration::from_secs(2));
        let second = start().wait_with_output().expect("it ends");
        let said = String::from_utf8_lossy(&second.stderr).into_owned();
        assert!(!second.status.success() && said.contains("another run writes there"), "{said}");
        assert!(first.try_wait().expect("a child").is_none(), "the first goes on");
        let _gone = first.kill();
        let _waited = first.wait();
    }
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
