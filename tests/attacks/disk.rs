//! Attacks by the surroundings: full disks, two runs at once, terminals and names that are not as expected.

use crate::optional::skip;
use crate::support::{Scratch, meniscus_command};
use std::ffi::OsStr;
use std::fs;
use std::os::unix::ffi::OsStrExt;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// A recording into a folder of images can be opened after its disk was full.
///
/// A disk of 2 MB in memory, filled by `record --out FOLDER`; the folder is then read again.
#[test]
fn a_folder_on_a_full_disk_can_be_opened() {
    let scratch = Scratch::new("full");
    let program = meniscus_command();
    // A name space of its own, in which a disk may be mounted without being root.
    let script = format!(
        "mount -t tmpfs -o size=2m tmpfs disk || exit 77\n\
         {0} record --source simulated-usb --seconds 4 --out disk/images >/dev/null 2>first.txt; echo $? >first\n\
         {0} record --source disk/images --out again.csv >again.txt 2>&1; echo $? >again\n",
        program.get_program().display()
    );
    fs::create_dir(scratch.0.join("disk")).expect("a folder");
    let status = Command::new("unshare")
        .args(["--user", "--map-root-user", "--mount", "sh", "-c", &script])
        .current_dir(&scratch.0)
        .status();
    if !status.is_ok_and(|status| status.success()) {
        return skip("a mount name space (unshare --user --mount)");
    }
    let read = |name: &str| fs::read_to_string(scratch.0.join(name)).expect("written");
    let (first, again) = (read("first.txt"), read("again.txt"));
    assert!(read("first").trim() == "1" && first.contains("which are kept"), "{first}");
    let images: usize =
        first.split("behind ").nth(1).and_then(|rest| rest.split(' ').next()?.parse().ok()).expect(&first);
    assert_eq!((read("again").trim(), images > 0), ("0", true), "{again}");
    assert!(again.contains("profiles"), "{again}");
}

/// A folder of images can be opened after `kill -9`, with all pairs but the one under way.
///
/// A recording that is killed after eleven pairs.
#[test]
fn a_folder_of_a_killed_recording_can_be_opened() {
    let scratch = Scratch::new("killed");
    let images = scratch.0.join("images");
    let mut child = meniscus_command()
        .args(["record", "--source", "simulated-usb", "--seconds", "300", "--out"])
        .arg(&images)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("it starts");
    let begun = Instant::now();
    while !images.join("infrared-0010.png").exists() && begun.elapsed() < Duration::from_secs(120) {
        std::thread::sleep(Duration::from_millis(10));
    }
    child.kill().expect("killed");
    let _waited = child.wait();
    let pairs = fs::read_dir(&images).expect("listed").flatten();
    let whole = |name: &str| name.starts_with("infrared-") && name.ends_with(".png");
    let pairs = pairs.filter(|file| whole(&file.file_name().to_string_lossy())).count();
    let recording = meniscus_bags::open(&images).expect("it opens");
    let read = recording.images.filter(Result::is_ok).count();
    assert!(pairs > 10 && read >= 2 * (pairs - 1), "{read} images of {pairs} pairs");
}

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

/// A terminal that moves no cursor gets plain lines.
///
/// `run` on a terminal of its own with TERM=dumb: no escape sequence comes out.
#[test]
fn a_dumb_terminal_gets_plain_lines() {
    let scratch = Scratch::new("dumb");
    let program = meniscus_command();
    let on_terminal = |term: &str| {
        let line = format!("{} run --seconds 2 --out out", program.get_program().display());
        let output = Command::new("script")
            .args(["-qec", &line, "/dev/null"])
            .env("TERM", term)
            .current_dir(&scratch.0)
            .stdin(Stdio::null())
            .output();
        output.map(|output| (output.status.success(), output.stdout))
    };
    let Ok((ended, dumb)) = on_terminal("dumb") else { return skip("script, of util-linux") };
    let text = String::from_utf8_lossy(&dumb);
    assert!(ended && !dumb.contains(&0x1b), "{text}");
    assert!(text.contains("running: 0 of 2 s") && text.lines().count() > 5, "{text}");
    // The terminal is one: another TERM gets the dashboard.
    let (_, full) = on_terminal("xterm").expect("it starts again");
    assert!(full.contains(&0x1b));
}

/// Names that are no text are names.
///
/// A model, a camera's recording, a simulator's recording and an output folder with a byte that is no UTF-8.
#[test]
fn names_that_are_no_text_are_taken() {
    let scratch = Scratch::new("names");
    let name = |ending: &str| scratch.0.join(OsStr::from_bytes(&[b"\xff\xfe ", ending.as_bytes()].concat()));
    fs::write(name("model.blob"), meniscus_shipped::MODEL).expect("written");
    fs::write(name("made.safetensors"), meniscus_shipped::RECORDING).expect("written");
    let run = |arguments: &[&OsStr]| {
        let output = meniscus_command().args(arguments).current_dir(&scratch.0).output().expect("it starts");
        assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    };
    let word = OsStr::new;
    let run_words =
        [word("run"), word("--patient"), word("--seconds"), word("1.5"), word("--json"), word("--out")];
    let (model, made, out) = (name("model.blob"), name("made.safetensors"), name("out"));
    run(&[&run_words[..], &[out.as_os_str(), word("--model"), model.as_os_str()]].concat());
    run(&[&run_words[..], &[out.as_os_str(), word("--source"), made.as_os_str()]].concat());
    let images = name("images");
    run(&[
        word("record"),
        word("--source"),
        word("simulated-usb"),
        word("--seconds"),
        word("0.5"),
        word("--out"),
        images.as_os_str(),
    ]);
    run(&[
        word("record"),
        word("--source"),
        images.as_os_str(),
        word("--out"),
        name("kept.mcap").as_os_str(),
    ]);
    run(&[word("flash"), model.as_os_str(), word("--to"), name("slots").as_os_str()]);
}
