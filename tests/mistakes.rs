//! Mistakes that people make at the command line: each is refused before any work, with what is wrong, where, and what to
//! do.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

/// Longest time of a refusal: 2 s, and as much again for a machine with other work.
const REFUSED_WITHIN: Duration = Duration::from_secs(4);

/// Longest time from Ctrl-C to the end: 2 s, and as much again.
const ENDED_WITHIN: Duration = Duration::from_secs(4);

/// Arguments, and words that the answer has to have.
type Mistake = (&'static str, &'static [&'static str]);

const RUN: &[Mistake] = &[
    ("run --seconds -3", &["--seconds -3 is out of range", "1.5 to 3600"]),
    ("run --seconds 1", &["--seconds 1 is out of range", "1.5 to 3600"]),
    ("run --seconds abc", &["'abc'", "--seconds"]),
    ("run --seed -1", &["'-1'", "--seed"]),
    ("run --vieww", &["--vieww", "--view"]),
    ("simulat", &["simulat", "simulate"]),
    ("run --patient --view", &["--patient", "--view"]),
    ("run --service", &["--service is for a camera on a bus"]),
    ("run --truth shipped", &["--truth is for a camera on a bus"]),
    ("run --fields q,z", &["no group 'z'", "sigma"]),
    ("run --faults gremlins:0.1", &["gremlins", "drop"]),
    ("run --view --listen 8060", &["'8060'", "127.0.0.1:8060"]),
    ("run --foxglove 8765", &["'8765'", "ADDRESS:PORT"]),
    ("run --publish somewhere", &["somewhere", "write unix:/run/meniscus.sock"]),
    ("run --among nowhere.liquid.json", &["nowhere.liquid.json", "no such file"]),
    ("run --out words.txt", &["--out", "words.txt"]),
    ("run --turns words.txt/x.csv", &["cannot make the folder of words.txt/x.csv"]),
    ("run --estimates folder", &["folder", "it is a folder; name a file in it"]),
];

const SOURCES: &[Mistake] = &[
    ("run --source nowhere.mcap", &["--source nowhere.mcap", "no such file", "shipped, usb"]),
    ("run --source empty.mcap", &["empty.mcap", "it is an empty file"]),
    ("run --source words.txt", &["words.txt is not a recording", "it is a text file"]),
    ("run --source model.blob", &["a model blob; --model takes it"]),
    ("run --source picture.png", &["it is a picture"]),
    ("run --source glass.toml", &["--setup takes it"]),
    ("run --source metres.csv", &["it is a table"]),
    ("run --source folder", &["folder", "without frames.csv"]),
    ("run --source torn.mcap", &["torn.mcap"]),
    ("run --source replay", &["--source replay FILE"]),
    ("run --source replay own.safetensors", &["a recording of the simulator"]),
    ("run torn.mcap", &["meniscus run --source torn.mcap"]),
    ("run --source simulated-usb:gremlins", &["gremlins", "unplug"]),
    ("run --source usb --model nowhere.blob", &["nowhere.blob", "no such file"]),
    ("render torn.mcap", &["a camera's recording", "run --source"]),
    ("render nowhere.safetensors", &["nowhere.safetensors", "no such file"]),
    ("render --rate 7", &["--rate 7", "20, 30 or 60"]),
    ("quantize --to bf16 --source torn.mcap --out new.blob", &["a camera's recording"]),
];

const MODELS: &[Mistake] = &[
    (
        "run --model nowhere.blob",
        &["cannot read nowhere.blob", "no such file", "--model takes", "names count from /"],
    ),
    ("run --model own.safetensors", &["not a weight blob", "a recording of the simulator"]),
    ("run --model words.txt", &["words.txt is not a weight blob"]),
    ("run --model folder", &["not a folder of `meniscus flash`"]),
    ("quantize --to f64 --out new.blob", &["'f64'", "bf16"]),
    ("quantize --to bf16 --rank-budget 3 --out new.blob", &["--rank-budget 3 is out of range"]),
    ("quantize --to bf16 --out model.blob", &["model.blob exists already", "--force"]),
    ("quantize --to bf16 --out words.txt/x.blob", &["cannot make the folder of words.txt/x.blob"]),
    ("flash", &["BLOB"]),
    ("flash shipped", &["--to"]),
    ("flash nowhere.blob --to slots", &["nowhere.blob", "no such file"]),
    ("flash shipped --profile broken.toml", &["broken.toml", "line 2"]),
    ("insert --effect ghosts=1 --out new.blob", &["no effect is called 'ghosts'"]),
    ("insert --effect foam=x --out new.blob", &["foam", "x"]),
    ("insert --verdict nowhere.json --out new.blob", &["nowhere.json", "no such file"]),
    ("insert --effect foam=0.1 --out model.blob", &["model.blob exists already", "--force"]),
];

const SETUPS: &[Mistake] = &[
    ("run --setup nowhere.toml", &["nowhere.toml", "no such file"]),
    ("run --setup broken.toml", &["broken.toml", "line 2"]),
    ("run --setup words.txt", &["words.txt", "line 1"]),
    ("setup --yes", &["--radius-mm", "--fill-mm"]),
    ("setup --yes --radius-mm 3.5 --fill-mm 70", &["3.5", "10 to 60 mm"]),
    ("setup --yes --radius-mm -35 --fill-mm 70", &["-35", "10 to 60 mm"]),
    ("setup --out other.toml", &["--yes", "--radius-mm"]),
    ("setup --yes --radius-mm 35 --fill-mm 70", &["glass.toml exists already", "--force"]),
    ("setup --pairs 2", &["--pairs", "8"]),
    ("record --out a.safetensors", &[".safetensors", ".mcap, .csv"]),
    ("record --out torn.mcap", &["torn.mcap exists already", "--force"]),
    ("record --source simulated-usb --out full", &["full exists already", "--force"]),
    ("record --source own.safetensors --out a.mcap", &["a recording of the simulator"]),
    ("record --source nowhere.mcap --out a.mcap", &["nowhere.mcap", "no such file"]),
    ("record --seconds -1 --out a.mcap", &["--seconds -1 is out of range"]),
    ("record --outline red --out a.mcap", &["red", "infrared"]),
    ("record --source torn.mcap --setup glass.toml --out a.csv", &["glass.toml"]),
    ("doctor --simulated gremlins", &["gremlins", "unplug"]),
    ("dump --simulated --out words.txt/a.json", &["cannot make the folder of words.txt/a.json"]),
];

const MOTIONS: &[Mistake] = &[
    ("run --motion pos.csv", &["pos.csv, line 1", "'pos' names no coordinate with a unit", "x_m", "x_mm"]),
    ("run --motion v.csv", &["v.csv, line 1", "'v' names no coordinate", "x_mm"]),
    ("run --motion far.csv", &["far.csv", "spans 20 m", "t,x_mm"]),
    ("run --motion nowhere.csv", &["nowhere.csv", "no such file"]),
    ("run --motion udp:nowhere", &["udp:HOST:PORT"]),
    ("run --motion stroke:1", &["no motion is spelled 'stroke:1'", "strokes"]),
    ("simulate --motion pos.csv --out a.safetensors", &["'pos' names no coordinate with a unit"]),
    ("simulate --motion strokes:1", &["--out"]),
    ("simulate --out a.safetensors", &["--motion"]),
    ("simulate --motion strokes:1 --seconds -1 --out a.safetensors", &["--seconds -1 is out of range"]),
    ("simulate --motion strokes:1 --liquid treacle --out a.safetensors", &["treacle", "glycerine, water"]),
    ("simulate --motion strokes:1 --effect ghosts=1 --out a.safetensors", &["no effect is called 'ghosts'"]),
    ("simulate --motion strokes:1 --compact 9 --out a.safetensors", &["--compact 9 is out of range"]),
    ("simulate --motion strokes:1 --spacing-mm 20 --out a.safetensors", &["20.00 mm"]),
    ("simulate --motion strokes:1 --fine --spacing-mm 4 --out a.safetensors", &["--fine", "--spacing-mm"]),
    ("simulate --scene nowhere.toml --out a.safetensors", &["nowhere.toml", "no such file"]),
    ("simulate --scene broken.toml --out a.safetensors", &["broken.toml", "line 2"]),
    ("simulate --motion strokes:1 --out own.safetensors", &["own.safetensors exists already", "--force"]),
    ("simulate --motion strokes:1 --out words.txt/a.safetensors", &["words.txt"]),
];

const LEARNING: &[Mistake] = &[
    ("correct --recordings nowhere.safetensors --out new.blob", &["nowhere.safetensors", "no such file"]),
    (
        "correct --recordings torn.mcap --out new.blob",
        &["need --setup FILE.toml", "`meniscus setup` writes it"],
    ),
    ("correct --recordings torn.mcap own.safetensors --out new.blob", &["1 of 2", "give one kind"]),
    ("correct --recordings model.blob --out new.blob", &["a model blob; --model takes it"]),
    ("correct --recordings own.safetensors --out model.blob", &["model.blob exists already", "--force"]),
    ("correct --recordings own.safetensors --out words.txt/x", &["cannot make the folder of words.txt/x"]),
    ("correct --recordings own.safetensors --out folder", &["it is a folder; name a file in it"]),
    ("correct --recordings folder --out new.blob", &["folder holds no *.safetensors"]),
    ("correct --recordings own.safetensors --steps 0 --out new.blob", &["--steps 0 is out of range"]),
    ("correct --recordings own.safetensors --noise-px -1 --out new.blob", &["--noise-px -1 is out of range"]),
    ("train --recordings folder --validate folder --out new.blob", &["folder holds no train-*.safetensors"]),
    ("train --recordings folder --validate folder --out model.blob", &["exists already", "--force"]),
    ("train --recordings folder --out new.blob", &["--validate"]),
    ("train --recordings x --validate x --repeat 0 --out new.blob", &["--repeat", "1"]),
    ("evaluate --liquid treacle", &["treacle", "beer"]),
    ("evaluate --out words.txt", &["cannot make the folder of words.txt"]),
    ("generic nowhere.npz", &["nowhere.npz", "no such file"]),
    ("discover", &["--recordings"]),
    ("discover --recordings nowhere --out found", &["nowhere", "no such file"]),
    ("discover --recordings folder --library ghosts --out found", &["folder"]),
    ("recognise nowhere.safetensors", &["nowhere.safetensors", "no such file"]),
    ("recognise torn.mcap", &["need --setup"]),
    ("recognise learn --recordings own.safetensors --out a.json", &["a.json must end with .liquid.json"]),
    ("deadline --rates 60:x", &["'x'", "minutes"]),
    ("bench --rounds 0", &["--rounds 0 is out of range"]),
    ("camera", &["study", "film"]),
];

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
        ("pos.csv", format!("time,pos\n{}", rows(1.0))),
        ("v.csv", format!("t,v\n{}", rows(0.01))),
        ("metres.csv", format!("t,x_m\n{}", rows(0.001))),
        ("far.csv", rows(20.0 / 39.0)),
        ("full/frame.png", String::from("an image")),
    ] {
        fs::write(folder.join(name), text).expect("written");
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

/// Every fault of the answers to `mistakes`.
fn faults(name: &str, mistakes: &[Mistake]) -> Vec<String> {
    let folder = folder(name);
    let mut faults = Vec::new();
    for (arguments, words) in mistakes {
        let begun = Instant::now();
        let output = meniscus(&folder, arguments);
        let (took, said) = (begun.elapsed(), String::from_utf8_lossy(&output.stderr).into_owned());
        let missing: Vec<_> = words.iter().filter(|word| !said.contains(**word)).collect();
        if output.status.success() || !missing.is_empty() {
            faults.push(format!("`{arguments}` lacks {missing:?}: {said}"));
        }
        if said.contains("panicked") || said.contains("os error") || said.matches("no such file").count() > 1
        {
            faults.push(format!("`{arguments}` is not a message for a person: {said}"));
        }
        if took > REFUSED_WITHIN {
            faults.push(format!("`{arguments}` took {took:?}"));
        }
    }
    faults
}

#[test]
fn mistakes_are_refused_with_what_where_and_what_to_do() {
    let tables = [
        ("run", RUN),
        ("sources", SOURCES),
        ("models", MODELS),
        ("setups", SETUPS),
        ("motions", MOTIONS),
        ("learning", LEARNING),
    ];
    let count: usize = tables.iter().map(|(_, mistakes)| mistakes.len()).sum();
    assert!(count >= 60, "{count}");
    let faults: Vec<String> = tables.iter().flat_map(|(name, mistakes)| faults(name, mistakes)).collect();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
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
