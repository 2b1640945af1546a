//! Mistakes that people make at the command line: each is refused before any work, with what is wrong, where, and what to
//! do.

#[path = "support/snapshots.rs"]
mod snapshots;

use snapshots::{Case, Snapshots};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

/// Longest time of a refusal: 2 s, and as much again for a machine with other work.
const REFUSED_WITHIN: Duration = Duration::from_secs(4);

/// Longest time from Ctrl-C to the end: 2 s, and as much again.
const ENDED_WITHIN: Duration = Duration::from_secs(4);

/// Files of answers in `tests/mistakes/`.
const FILES: [&str; 7] = ["run", "sources", "models", "setups", "motions", "learning", "webcam"];

/// Mistakes at the least.
const LEAST: usize = 60;

/// Density and viscosity of a folder for discovery.
const LIQUID: &str = "density_kg_m3 = 1261\nviscosity_pa_s = 0.95\n";

/// A whole settings file, with more behind it.
fn setup(more: &str) -> String {
    format!(
        "made_by = 'a test'\n[glass]\nradius_mm = 35.0\nfill_mm = 70.0\nrim_mm = 110.0\n[liquid]\ntone = 'dark'\n\
         least_contrast = 25.0\n[view]\ncamera = 'a test'\ndistance_mm = 400.0\nheight_mm = 30.0\npitch_deg = 0.0\n\
         outline = 'colour'\n{more}"
    )
}

/// A scene with this glass.
fn scene(glass: &str) -> String {
    format!("liquid = 'glycerine'\n[glass]\n{glass}\n")
}

/// A folder with files to be mistaken about.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("mistakes").join(name);
    let _old = fs::remove_dir_all(&folder);
    fs::create_dir_all(folder.join("folder")).expect("a folder");
    fs::create_dir_all(folder.join("full")).expect("a folder");
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    for (from, to) in [
        ("models/glycerine.blob", "model.blob"),
        ("recordings/glycerine-unseen.safetensors", "own.safetensors"),
        ("docs/run.png", "picture.png"),
    ] {
        fs::copy(root.join(from), folder.join(to)).expect("copied");
    }
    let rows = |scale: f64| -> String {
        (0..40).map(|k| format!("{:.2},{}\n", 0.05 * f64::from(k), scale * f64::from(k))).collect()
    };
    for (name, text) in [
        ("words.txt", String::from("plain words\n")),
        ("empty.mcap", String::new()),
        ("broken.toml", String::from("# a mistake in the second line\nradius_mm 35\n")),
        ("glass.toml", String::from("made_by = 'a test'\n[glass]\nradius_mm = 35.0\n[view]\n")),
        ("depth.toml", setup("")),
        ("webcam.toml", setup("[lens]\nsize = [640, 480]\nfocal_px = 610.0\n")),
        ("pos.csv", format!("time,pos\n{}", rows(1.0))),
        ("v.csv", format!("t,v\n{}", rows(0.01))),
        ("metres.csv", format!("t,x_m\n{}", rows(0.001))),
        ("far.csv", rows(20.0 / 39.0)),
        ("full/frame.png", String::from("an image")),
        ("nan.csv", String::from("t,x_m\n0,0\n0.05,nan\n0.1,0\n")),
        ("back.csv", String::from("t,x_m\n0,0\n0.1,0\n0.05,0\n")),
        ("gap.csv", String::from("t,x_m\n0,0\n1,0\n2,0\n")),
        ("semi.csv", String::from("t;x_m\n0;0\n0.1;0\n")),
        ("three.csv", String::from("t,x_m,force\n0,0,1\n0.1,0,1\n")),
        ("none.csv", String::new()),
        ("head.csv", String::from("t,x_m\n")),
        ("text.csv", String::from("t,x_m\n0,zero\n0.1,0\n")),
        ("x_mm.csv", String::from("time,x_mm,x_m\n0,0,0\n0.1,0,0\n")),
        ("run.toml", String::from("[images]\nsetpu = 'x'\n")),
        ("run2.toml", String::from("[images]\nseconds = 3\n")),
        ("run3.toml", String::from("[time]\nseconds = 'ten'\n")),
        ("scene.toml", scene("radius_m = 0.035\nfill_m = 0.070\nrim_m = 0.110\ncolour = 3")),
        ("scenemm.toml", scene("radius_m = 35\nfill_m = 70\nrim_m = 110")),
        ("liquid.toml", String::from("name = 'x'\n")),
        (
            "units.toml",
            String::from("made_by = 'a test'\n[glass]\nradius_mm = 3.5\nfill_mm = 7\nrim_mm = 11\n"),
        ),
        ("typo.toml", String::from("name = 'a board'\nmodle = 'slots'\n")),
        ("disc/setup.toml", String::from("radius_m = 0.035\nfill_m = 0.070\ndensity_kg_m3 = 1261\n")),
        ("disc2/setup.toml", format!("radius_m = 35\nfill_m = 70\n{LIQUID}")),
        ("disc3/setup.toml", format!("radius_m = 0.035\nfill_m = 0.07\n{LIQUID}")),
    ] {
        let path = folder.join(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("made");
        fs::write(path, text).expect("written");
    }
    fs::write(folder.join("torn.mcap"), b"\x89MCAP0\r\n\x01").expect("written");
    folder
}

fn meniscus(folder: &Path, arguments: &str) -> Output {
    Command::new(env!("CARGO_BIN_EXE_meniscus-under-test"))
        .args(arguments.split_whitespace())
        .current_dir(folder)
        .stdin(Stdio::null())
        .output()
        .expect("it starts")
}

/// Names and sizes of all files below a folder.
fn contents(folder: &Path) -> Vec<(PathBuf, u64)> {
    let mut all = Vec::new();
    for entry in fs::read_dir(folder).expect("listed").flatten() {
        let (path, meta) = (entry.path(), entry.metadata().expect("known"));
        if meta.is_dir() {
            all.extend(contents(&path));
        }
        all.push((path, if meta.is_dir() { 0 } else { meta.len() }));
    }
    all.sort();
    all
}

/// Runs a mistake in `folder` and returns its answer, with the faults that no answer may have.
fn answer(folder: &Path, arguments: &str) -> (Case, Vec<String>) {
    let before = contents(folder);
    let timed = || {
        let begun = Instant::now();
        (meniscus(folder, arguments), begun.elapsed())
    };
    // Other work on the machine may hold one up, hardly three in a row.
    let (mut output, mut took) = timed();
    for _again in 0..2 {
        if took > REFUSED_WITHIN {
            (output, took) = timed();
        }
    }
    let mut text = String::from_utf8_lossy(&output.stderr).into_owned();
    text += &String::from_utf8_lossy(&output.stdout);
    let root = folder.canonicalize().expect("a folder").display().to_string();
    let mut text = text.replace(&root, "FOLDER").replace(&folder.display().to_string(), "FOLDER");
    for end in ["\n\nFor more information, try '--help'.\n", "\n"] {
        text = text.strip_suffix(end).unwrap_or(&text).to_owned();
    }
    let mut faults = Vec::new();
    let mut fault = |is: bool, what: &str| {
        if is {
            faults.push(format!("`{arguments}` {what}: {text}"));
        }
    };
    fault(output.status.success(), "is accepted");
    fault(text.contains("panicked"), "panics");
    fault(text.contains("os error") || text.contains("literal"), "answers with a message of the system");
    fault(text.matches("no such file").count() > 1, "says one cause twice");
    fault(contents(folder) != before, "leaves a file or folder behind");
    fault(took > REFUSED_WITHIN, "is refused late");
    let status = output.status.code().map_or("ended by a signal".into(), |code| format!("[exit {code}]"));
    (Case { arguments: arguments.into(), answer: format!("{text}\n{status}") }, faults)
}

#[test]
fn mistakes_are_refused_with_what_where_and_what_to_do() {
    let (mut faults, mut count) = (Vec::new(), 0);
    for name in FILES {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("mistakes").join(name).with_extension("txt");
        let (snapshots, folder) = (Snapshots::read(&path), folder(name));
        let mut cases = Vec::new();
        for arguments in snapshots.arguments() {
            let (case, wrong) = answer(&folder, arguments);
            faults.extend(wrong);
            cases.push(case);
        }
        count += cases.len();
        faults.extend(snapshots.compare(&cases));
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert!(count >= LEAST, "{count}");
}

#[test]
fn another_answer_and_another_status_are_found() {
    let text =
        "A preface.\n\n$ meniscus run --x\nerror: no\n  more\n[exit 2]\n\n$ meniscus\nerror: yes\n[exit 1]\n";
    let (preface, cases) = snapshots::parse(text);
    assert_eq!((cases.len(), cases[0].answer.as_str()), (2, "error: no\n  more\n[exit 2]"));
    assert_eq!(snapshots::text(&preface, &cases), text);
    let mut other = cases.clone();
    assert!(snapshots::differences(&cases, &other).is_empty());
    other[1].answer = "error: yes\n[exit 2]".into();
    assert_eq!(snapshots::differences(&cases, &other).len(), 1);
}

#[test]
fn without_arguments_the_program_says_where_to_start() {
    let output = meniscus(Path::new("."), "");
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    for word in ["meniscus run --view", "meniscus doctor", "meniscus run --source usb", "--help"] {
        assert!(said.contains(word), "`{word}` is missing in: {said}");
    }
}

#[test]
fn an_interrupted_command_ends_soon_and_leaves_nothing_that_looks_finished() {
    let folder = folder("interrupted");
    for (arguments, product, word) in [
        ("correct --recordings own.safetensors --out new.blob", "new.blob", "no blob is written"),
        ("evaluate --liquid beer --out report", "report/evaluate.md", "no report is written"),
        (
            "simulate --motion strokes:1 --seconds 20 --out new.safetensors",
            "new.safetensors",
            "is not written",
        ),
        ("discover study --out study --cache cache", "study/study.md", "--report-only"),
    ] {
        let mut running = Command::new(env!("CARGO_BIN_EXE_meniscus-under-test"))
            .args(arguments.split_whitespace())
            .current_dir(&folder)
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("it starts");
        std::thread::sleep(Duration::from_secs(3));
        assert!(running.try_wait().expect("asked").is_none(), "{arguments} ended by itself");
        let pid = running.id().to_string();
        assert!(Command::new("kill").args(["-INT", &pid]).status().expect("kill").success());
        let begun = Instant::now();
        let output = running.wait_with_output().expect("it ends");
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(begun.elapsed() < ENDED_WITHIN, "{arguments} ran on for {:?}", begun.elapsed());
        assert_eq!(output.status.code(), Some(130), "{arguments}: {said}");
        assert!(said.contains("interrupted") && said.contains(word), "{arguments}: {said}");
        assert!(!folder.join(product).exists(), "{arguments} left {product}");
    }
    let parts = fs::read_dir(&folder).expect("listed").flatten();
    assert!(!parts.into_iter().any(|entry| entry.file_name().to_string_lossy().ends_with(".part")));
}

/// A camera's recording needs no `replay`, whatever its name.
#[test]
fn a_recording_is_known_by_its_content_and_is_not_overwritten() {
    let folder = folder("content");
    let made = meniscus(&folder, "record --source simulated-usb --seconds 2 --out try.mcap");
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    fs::copy(folder.join("try.mcap"), folder.join("try.data")).expect("copied");
    for name in ["try.mcap", "try.data"] {
        let ran = meniscus(&folder, &format!("run --source {name} --seconds 1.5 --json"));
        let said = String::from_utf8_lossy(&ran.stderr);
        assert!(ran.status.success(), "{name}: {said}");
        assert!(said.contains("without --setup the camera is assumed level, 400 mm"), "{said}");
    }
    let before = fs::read(folder.join("try.mcap")).expect("read");
    let again = meniscus(&folder, "record --source simulated-usb --seconds 1 --out try.mcap");
    assert!(!again.status.success() && String::from_utf8_lossy(&again.stderr).contains("--force"));
    assert!(fs::read(folder.join("try.mcap")).expect("kept") == before);
}
