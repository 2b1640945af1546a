//! `meniscus learn` on a tiny set: coarse particles, short recordings, a schedule of a few steps. Nothing is said about how good
//! such a model is; what is tested is that a run can be broken off anywhere and is then the same run.

use meniscus::blob::{FieldGroup, Model};
use meniscus_data::recording::Recording;
use meniscus_data::scene_file::GLASS;
use meniscus_learn::{Hyperparameters, Schedule};
use meniscus_platform::files::AlignedBytes;
use meniscus_relearn::{
    Folder, LiquidSource, Outcome, Plan, Progress, RelearnError, Run, SetSizes, Shard, Silent, Stage, Workers,
};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::atomic::{AtomicBool, Ordering};

/// A folder of its own for each test.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("learn").join(name);
    let _old = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("a folder");
    folder
}

/// Plan that takes seconds.
fn plan() -> Plan {
    let schedule = Schedule { autoencoder: 150, encoder: 10, rollout: 50, seeds: 1 };
    Plan {
        spacing_m: 0.00875,
        seconds: 1.5,
        sizes: SetSizes { training: 2, validation: 1, held_out: 1 },
        hyperparameters: Hyperparameters::with_schedule(schedule),
        ..Plan::new(LiquidSource::Stated("water".into()), GLASS)
    }
}

/// Runs `plan` in `folder` up to `until`.
fn go(
    plan: &Plan,
    folder: &Path,
    until: Stage,
    shard: Shard,
    stop: &AtomicBool,
    progress: &dyn Progress,
) -> Result<Outcome, RelearnError> {
    let folder = Folder::new(folder);
    let workers = Workers { processors: 2, shard };
    let run =
        Run { plan, folder: &folder, measured: &[], base: &[], command: "a test", workers, stop, progress };
    run.go(until)
}

/// The same without interruption.
fn whole(plan: &Plan, folder: &Path, until: Stage) -> Outcome {
    go(plan, folder, until, Shard::WHOLE, &AtomicBool::new(false), &Silent).expect("a whole run")
}

/// Observer that raises `stop` while the first simulations run.
struct Impatient<'a>(&'a AtomicBool);

impl Progress for Impatient<'_> {
    fn begins(&self, _: Stage, _: &str) {}

    fn advances(&self, share: f64) {
        if share > 0.1 {
            self.0.store(true, Ordering::Relaxed);
        }
    }

    fn ends(&self, _: &str) {}

    fn quiet(&self) -> bool {
        true
    }
}

fn bytes(path: &Path) -> Vec<u8> {
    std::fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Stopped among the simulations and in the training, with half a recording left by a crash: the model is the same to the bit.
#[test]
fn a_run_that_was_broken_off_gives_the_model_of_one_that_was_not() {
    let (straight, broken) = (folder("straight"), folder("broken"));
    let plan = plan();
    let outcome = whole(&plan, &straight, Stage::Report);
    assert_eq!(outcome.finished, Stage::Report);

    // One processor for each of two recordings: both are finished when the flag is seen, and no other is begun.
    let stop = AtomicBool::new(false);
    let stopped = go(&plan, &broken, Stage::Report, Shard::WHOLE, &stop, &Impatient(&stop));
    let Err(RelearnError::Interrupted { stage: "simulate", kept }) = stopped else {
        panic!("stopped among the simulations: {stopped:?}")
    };
    assert!(kept.contains("of 4 recordings are finished") && !kept.starts_with('4'), "{kept}");

    let recordings = broken.join("recordings");
    whole(&plan, &broken, Stage::Simulate);
    // What a power cut may leave under the final name: half a file, and one of another motion.
    let names = ["train-strokes-1", "train-random-1"].map(|name| {
        let all =
            std::fs::read_dir(&recordings).expect("recordings").filter_map(|entry| Some(entry.ok()?.path()));
        all.into_iter()
            .find(|path| path.to_string_lossy().contains(name))
            .expect("a recording of that motion")
    });
    let good = names.clone().map(|path| bytes(&path));
    std::fs::write(&names[0], &good[0][..good[0].len() / 2]).expect("half of it");
    std::fs::write(&names[1], &good[0]).expect("another motion");
    whole(&plan, &broken, Stage::Simulate);
    for (name, good) in names.iter().zip(&good) {
        assert!(bytes(name) == *good, "{} is simulated again", name.display());
    }

    // Stopped as soon as the first checkpoint is there.
    let stop = AtomicBool::new(false);
    let training = broken.join("training");
    let stopped = std::thread::scope(|scope| {
        let running = scope.spawn(|| go(&plan, &broken, Stage::Report, Shard::WHOLE, &stop, &Silent));
        while !running.is_finished() && std::fs::read_dir(&training).map_or(0, Iterator::count) == 0 {
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
        stop.store(true, Ordering::Relaxed);
        running.join().expect("no panic")
    });
    assert!(matches!(stopped, Err(RelearnError::Interrupted { stage: "train", .. })), "{stopped:?}");
    assert!(!broken.join("trained.blob").exists() && !broken.join("model.blob").exists(), "no half model");

    whole(&plan, &broken, Stage::Report);
    assert!(
        bytes(&broken.join("model.blob")) == bytes(&straight.join("model.blob")),
        "the same model, bit for bit"
    );
    assert!(!training.exists(), "a finished model needs no checkpoints");

    // The second of two jobs of an array makes every second recording, the same bit for bit, and ends with its simulations.
    let part = folder("part");
    let shard = Shard { job: 2, jobs: 2 };
    let half = go(&plan, &part, Stage::Report, shard, &AtomicBool::new(false), &Silent).expect("a part");
    assert_eq!(half.finished, Stage::Simulate);
    let there = names.each_ref().map(|name| part.join("recordings").join(name.file_name().expect("a name")));
    assert!(!there[0].exists() && bytes(&there[1]) == bytes(&names[1]), "{there:?}");

    unknown_groups_are_absent(&straight, &outcome);
    another_plan_is_refused(&straight);
}

/// Figures of groups that the model does not know do not appear, and those of the others do.
fn unknown_groups_are_absent(folder: &Path, outcome: &Outcome) {
    let blob = AlignedBytes::read(&folder.join("model.blob")).expect("a model");
    let known = Model::load(&blob).expect("a good one").header.known();
    let named = |name: &str| outcome.checks.iter().any(|check| check.name == name);
    for (group, name) in [
        (FieldGroup::Position, "q"),
        (FieldGroup::Velocity, "v"),
        (FieldGroup::InternalEnergy, "e"),
        (FieldGroup::ShearStress, "tau"),
    ] {
        assert_eq!(named(&format!("held_{name}")), known.contains(group), "{name}");
        assert_eq!(named(&format!("coverage_{name}")), known.contains(group), "{name}");
        // A simulation shows the inside: only the heat of a low-viscosity liquid may be unknown.
        assert!(known.contains(group) || group == FieldGroup::InternalEnergy, "{name} is known");
    }
    let report = bytes(&folder.join("report.json"));
    let report: serde_json::Value = serde_json::from_slice(&report).expect("JSON");
    let checks = report["checks"].as_array().expect("checks");
    assert!(checks.iter().any(|check| check["name"] == "held_v" && check["value"].is_number()), "{report:#}");
    assert!(bytes(&folder.join("learning-curves.png")).starts_with(b"\x89PNG"));
    let recording = Recording::load(&first(&folder.join("recordings"))).expect("a recording");
    assert_eq!((recording.frames(), recording.provenance.liquid.as_str()), (90, "water"));
}

/// First file of a folder.
fn first(folder: &Path) -> PathBuf {
    let mut all: Vec<_> =
        std::fs::read_dir(folder).expect("a folder").map(|e| e.expect("an entry").path()).collect();
    all.sort();
    all.swap_remove(0)
}

/// A folder of one run is not continued by another.
fn another_plan_is_refused(folder: &Path) {
    let other = Plan { seed: 2, ..plan() };
    let refused = go(&other, folder, Stage::Report, Shard::WHOLE, &AtomicBool::new(false), &Silent);
    let refused = refused.expect_err("another plan").to_string();
    assert!(refused.contains("another run") && refused.contains("seed is 1 there and 2 here"), "{refused}");
}

/// Runs the command.
fn meniscus(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_meniscus-under-test"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("it starts")
}

/// It has to fail, and to say each of `words`.
fn refused(output: &Output, words: &[&str]) {
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success(), "this must be refused");
    for word in words {
        assert!(errors.contains(word), "`{word}` is missing in: {errors}");
    }
    assert!(!errors.contains("panicked"), "{errors}");
}

/// Errors name the fault, its value and the remedy, and leave nothing that looks like a result.
#[test]
fn mistakes_are_named() {
    let folder = folder("mistakes");
    let learn = |arguments: &[&str]| meniscus(&folder, &[&["learn"], arguments, &["--out", "x"]].concat());
    refused(&learn(&["treacle"]), &["no liquid is called 'treacle'"]);
    refused(&learn(&["water", "--seconds", "1"]), &["--seconds = 1 is out of range", "1.5 to 60"]);
    refused(&learn(&["water", "--shard", "9/8"]), &["'9/8' is not I/N"]);
    refused(&learn(&["water", "--density", "1000"]), &["--density goes with recordings"]);
    refused(&learn(&["water", "--spacing-mm", "30"]), &["cannot be simulated", "spacing"]);
    std::fs::write(folder.join("tiny.json"), "{\"schedule\": 3}").expect("written");
    refused(&learn(&["water", "--hyperparameters", "tiny.json"]), &["tiny.json", "hyperparameters"]);
    assert!(!folder.join("x").join("model.blob").exists());
}

/// A liquid is identified from a recording of the simulator, and a recording that shows nothing is refused with the reason.
#[test]
fn recordings_are_identified_or_refused() {
    let folder = folder("identify");
    let shipped = concat!(env!("CARGO_MANIFEST_DIR"), "/../recordings/glycerine-unseen.safetensors");
    // The first seconds of it, without its states, which no fit looks at.
    let whole = Recording::load(Path::new(shipped)).expect("the shipped recording");
    let cut = |frames: usize, name: &str| {
        let mut recording = whole.clone();
        recording.glass_x_m.truncate(frames);
        recording.acceleration_m_s2.truncate(frames);
        recording.glass_y_m.truncate(frames);
        recording.glass_z_m.truncate(frames);
        recording.tilt_rad.truncate(frames);
        recording.column_m.truncate(frames * meniscus_data::recording::COLUMNS);
        recording.wall_m.truncate(frames * meniscus_data::recording::WALL_POINTS);
        recording.profile_m.truncate(frames * meniscus::surface::POINTS);
        recording.energy.truncate(frames);
        recording.spilled_m3.truncate(frames);
        let state = vec![0.0; frames * meniscus_data::recording::STATE];
        let states = meniscus_data::recording::States::Full(state);
        Recording { states, ..recording }.save(&folder.join(name)).expect("written");
    };
    cut(180, "glycerine.safetensors");
    let output = meniscus(
        &folder,
        &["learn", "glycerine.safetensors", "--rough", "--until", "identify", "--json", "--out", "found"],
    );
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    let answer: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(answer["finished"], "identify");
    let found: serde_json::Value =
        serde_json::from_slice(&bytes(&folder.join("found/identified.json"))).expect("JSON");
    let value = &found["consistency_pa_sn"];
    let number = |v: &serde_json::Value| v.as_f64().expect("a number");
    // liquids/glycerine.toml, which the fit does not get.
    let truth = 0.950;
    println!("{found:#}");
    let (low, high) = (number(&value["interval"][0]), number(&value["interval"][1]));
    assert!((low..=high).contains(&truth), "{low} to {high}");
    assert!((number(&value["best"]) / truth - 1.0).abs() < 0.3, "{value}");
    let liquid = std::fs::read_to_string(folder.join("found/liquid.toml")).expect("a liquid file");
    assert!(liquid.contains("roughly") && liquid.contains("density_kg_m3 = { value = 1261"), "{liquid}");

    cut(48, "short.safetensors");
    let short = meniscus(&folder, &["learn", "short.safetensors", "--out", "none"]);
    refused(&short, &["short", "after the glass begins to move", "give a longer recording"]);
    assert!(!folder.join("none/liquid.toml").exists());
}

/// The simulator finds a viscosity that no line of the fit was tuned on, where the reduced model does not. Nothing is simulated twice,
/// and a stopped fit goes on.
#[test]
#[ignore = "minutes of two cores: cargo xtask nightly --only sizing"]
fn a_viscosity_is_found_by_simulation() {
    const TRUTH: f64 = 0.4;
    let folder = folder("by-simulation");
    // Hidden in finer particles and in another packing than the fit has.
    let words = "simulate --liquid glycerine --effect viscosity=0.4 --motion random:31x0.5 --seconds 2 --spacing-mm 6 \
                 --out random.safetensors";
    let simulated = meniscus(&folder, &words.split_whitespace().collect::<Vec<_>>());
    assert!(simulated.status.success(), "{}", String::from_utf8_lossy(&simulated.stderr));
    let learn = |extra: &[&str]| {
        let words = [
            "learn",
            "random.safetensors",
            "--until",
            "identify",
            "--spacing-mm",
            "7",
            "--json",
            "--out",
            "found",
        ];
        meniscus(&folder, &[&words, extra].concat())
    };
    refused(&learn(&["--shard", "1/2"]), &["not identified yet", "--until identify"]);
    let output = learn(&[]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let found: serde_json::Value =
        serde_json::from_slice(&bytes(&folder.join("found/identified.json"))).expect("JSON");
    println!("{found:#}");
    let number = |v: &serde_json::Value| v.as_f64().expect("a number");
    let value = &found["consistency_pa_sn"];
    let (low, high) = (number(&value["interval"][0]), number(&value["interval"][1]));
    assert!((number(&value["best"]) / TRUTH - 1.0).abs() < 0.1, "{value}");
    assert!((low..=high).contains(&TRUTH), "{low} to {high}");
    let reduced = number(&found["by_simulation"]["reduced_pa_sn"]["best"]);
    println!("by the reduced model {reduced} Pa s");
    assert!((number(&value["best"]) / reduced - 1.0).abs() > 1e-3, "the answer is the simulator's: {value}");
    let simulations = || std::fs::read_dir(folder.join("found/identification")).expect("a store").count();
    let before = simulations();
    assert!(before >= 5, "{before} simulations");
    // A second fit from the same simulations is the same.
    std::fs::remove_file(folder.join("found/identified.json")).expect("removed");
    assert!(learn(&[]).status.success());
    let again: serde_json::Value =
        serde_json::from_slice(&bytes(&folder.join("found/identified.json"))).expect("JSON");
    assert_eq!((again, simulations()), (found, before));
}
