//! Discovery on a simulator that is another program: `examples/one_mode.py`, and programs that are none.

use meniscus::surface::{POINTS, SurfaceProfile};
use meniscus::units::{FRAME_INTERVAL_S, Micros};
use meniscus_data::effects::Effects;
use meniscus_data::glass::{Glass, WallShape};
use meniscus_data::liquids::{Liquid, Rheology};
use meniscus_data::profiles::profiles_to_csv;
use meniscus_discover::foreign::command::{CommandError, CommandSimulator};
use meniscus_discover::insert::simulated::Course;
use meniscus_discover::insert::simulator::{GlassSimulator, SimulatorFault};
use meniscus_discover::recordings::motion_plan::MotionPlan;
use meniscus_numerics::random::normal;
use meniscus_sph::Setup;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

const VISCOSITY: f64 = 0.2;
const FILL_M: f64 = 0.07;
const NOISE_M: f64 = 1e-4;

/// A folder that is gone when the test ends.
struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("meniscus-own-{}-{name}", std::process::id()));
        std::fs::create_dir_all(&path).expect("a folder");
        Self(path)
    }

    fn path(&self, name: &str) -> String {
        self.0.join(name).to_string_lossy().into_owned()
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // What a failed test did not make cannot be removed.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn setup() -> Setup {
    Setup {
        glass: Glass { radius_m: 0.035, fill_m: FILL_M, rim_m: 0.12, wall: WallShape::UPRIGHT },
        liquid: Liquid {
            name: "oil".into(),
            density_kg_m3: 1261.0,
            rheology: Rheology::newtonian(VISCOSITY),
            effects: Effects::default(),
        },
        spacing_m: 0.007,
        seed: 1,
        no_slip: true,
        effects: Effects::default(),
        step_s: None,
    }
}

fn one_mode() -> String {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/one_mode.py");
    format!("python3 '{}'", script.display())
}

/// Returns `plan` as discovery asks for it: four samples a frame, with a rest behind it.
fn course(plan: &MotionPlan) -> Course {
    let sample = |n: usize| 0.25 * n as f64 * FRAME_INTERVAL_S;
    let samples = (0..4 * (plan.frames() + 60)).map(sample).map(|t| (t, plan.position(t))).collect();
    Course { samples, frames: plan.frames() }
}

/// Liquid of a glass whose settings state [`VISCOSITY`] and no yield stress.
struct Hidden {
    yield_stress: f64,
    viscosity: f64,
}

/// Writes recordings of the other program's own glass with `liquid` in it, and the noise of a camera.
fn record(folder: &Path, liquid: &Hidden, seed: u64) {
    std::fs::create_dir_all(folder).expect("a folder");
    let stated = format!(
        "radius_m = 0.035\nfill_m = {FILL_M}\ndensity_kg_m3 = 1261.0\nviscosity_pa_s = {VISCOSITY}\n"
    );
    std::fs::write(folder.join("setup.toml"), stated).expect("written");
    let mut hidden = setup();
    hidden.liquid.rheology = Rheology::newtonian(liquid.viscosity);
    hidden.effects.set("yield_stress", liquid.yield_stress).expect("in its range");
    let simulator = CommandSimulator::new(&one_mode(), Duration::from_secs(60)).expect("it is there");
    let plans = [0.6, 1.25, 2.2, 1.7].map(|strength| MotionPlan::jolt(0.28, strength, 2.2));
    let courses = plans.each_ref().map(course);
    let made = simulator.run(&hidden, &courses.each_ref(), None).expect("simulated");
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    for ((name, plan), heights) in ["a", "b", "c", "d"].iter().zip(&plans).zip(&made) {
        let mut profile = |(frame, row): (usize, &[f32; POINTS])| SurfaceProfile {
            height_m: row.map(|z| z + (NOISE_M * normal(&mut random)) as f32),
            variance_m2: [(NOISE_M * NOISE_M) as f32; POINTS],
            valid: [true; POINTS],
            glass_x_m: None,
            sequence: frame as u32,
            captured: Micros(1_000_000 + (frame as f64 * FRAME_INTERVAL_S * 1e6).round() as u64),
        };
        let rows = heights.as_chunks::<POINTS>().0;
        let profiles: Vec<_> = rows.iter().enumerate().map(&mut profile).collect();
        let file = |kind: &str| folder.join(format!("{name}.{kind}.csv"));
        std::fs::write(file("profile"), profiles_to_csv(&profiles)).expect("written");
        std::fs::write(file("motion"), plan.csv()).expect("written");
    }
}

/// Runs the command with the effects `library` and the arguments `more` on recordings in `folder`.
fn discover(folder: &Scratch, library: &str, more: &[&str]) -> serde_json::Value {
    let done = std::process::Command::new(env!("CARGO_BIN_EXE_meniscus-under-test"))
        .args(["discover", "--recordings", &folder.path("mine"), "--simulator", &one_mode()])
        .args(["--simulator-seconds", "60", "--library", library])
        .args(["--out", &folder.path("out"), "--json"])
        .args(more)
        .output()
        .expect("the command starts");
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    serde_json::from_slice(&done.stdout).expect("one JSON object")
}

#[test]
fn effects_that_are_hidden_in_another_simulator_are_sized_by_it() {
    // The fit gets the recordings alone.
    let mut random = ChaCha8Rng::seed_from_u64(20_261_126);
    let mut covered = 0;
    for trial in 0..3 {
        let scratch = Scratch::new(&format!("sized-{trial}"));
        let hidden = random.random_range(1.0..2.5);
        record(
            Path::new(&scratch.path("mine")),
            &Hidden { yield_stress: hidden, viscosity: VISCOSITY },
            5 + trial,
        );
        let said = discover(&scratch, "viscosity,yield_stress,surface_tension", &[]);
        let words = (said["verdict"].as_str(), said["names"][0].as_str());
        assert_eq!(words, (Some("named"), Some("yield_stress")), "{hidden} Pa: {}", said["sentence"]);
        let size = &said["parameters"][0];
        let number = |value: &serde_json::Value| value.as_f64().expect("a number");
        let (low, high) = (number(&size["interval_90"][0]), number(&size["interval_90"][1]));
        let found = number(&size["value"]);
        println!("hidden {hidden:.3} Pa, found {found:.3} ({low:.3} to {high:.3})");
        covered += usize::from((low..=high).contains(&hidden));
        assert!((found / hidden - 1.0).abs() < 0.03 && high - low < 0.1 * hidden);
        assert_eq!(size["by"], "simulator");
        assert!(said["simulator"]["program"].as_str().is_some_and(|name| name.contains("one_mode.py")));
        if trial == 0 {
            // Once more: nothing is asked again, and the numbers are the same.
            let again = discover(&scratch, "viscosity,yield_stress,surface_tension", &[]);
            assert_eq!(again["parameters"], said["parameters"]);
            assert_eq!(again["simulator"]["simulations"]["made"], 0);
        }
    }
    // Nominally nine in ten.
    assert!(covered >= 2, "{covered} of 3 intervals hold the hidden size");
}

/// A yield stress in a liquid that is half as viscous again as stated, which no effect of the library says.
#[test]
fn a_name_that_the_simulator_refutes_is_unknown_and_a_law_is_drawn() {
    let references = Scratch::new("references");
    let known = references.path("known");
    let scratch = Scratch::new("refuted");
    let thicker = Hidden { yield_stress: 2.0, viscosity: 1.5 * VISCOSITY };
    record(Path::new(&scratch.path("mine")), &thicker, 17);
    record(Path::new(&known), &Hidden { yield_stress: 0.0, viscosity: VISCOSITY }, 18);
    let said = discover(&scratch, "yield_stress", &["--reference", &known]);
    let reduced = &said["reduced_model"];
    assert_eq!((&reduced["verdict"], &reduced["names"][0]), (&"named".into(), &"yield_stress".into()));
    let refuted = said["simulator"]["candidates"][0]["refutation"].as_str().expect("it is refuted");
    println!("{}", said["sentence"]);
    assert!(refuted.starts_with("beside yield_stress the viscosity has to be 1."), "{refuted}");
    assert_eq!((&said["verdict"], &said["simulator"]["change"]), (&"unknown".into(), &"refuted".into()));
    assert!(said["sentence"].as_str().is_some_and(|sentence| sentence.contains(refuted)));
    assert_eq!(said["parameters"], serde_json::json!([]));
    assert_eq!(said["law"]["drawn"], true, "{}", said["law"]);
    let scene = std::fs::read_to_string(scratch.path("out/scene.toml")).expect("written");
    assert!(!scene.contains("\nyield_stress"), "{scene}");
    // Nor is one name enough where the library has both.
    let said = discover(&scratch, "viscosity,yield_stress", &["--reference", &known]);
    assert_eq!((&said["verdict"], &said["simulator"]["change"]), (&"unknown".into(), &"refuted".into()));
    // Of the stated viscosity the same yield stress is named.
    let scratch = Scratch::new("borne-out");
    record(Path::new(&scratch.path("mine")), &Hidden { yield_stress: 2.0, viscosity: VISCOSITY }, 17);
    let said = discover(&scratch, "yield_stress", &["--reference", &known]);
    assert_eq!((&said["verdict"], &said["simulator"]["change"]), (&"named".into(), &"kept".into()));
    assert_eq!(said["simulator"]["candidates"][0]["refutation"], serde_json::Value::Null);
}

/// Returns the fault of the shell text `script` as a simulator; `$1` is the request, `$2` the answer.
fn fault(script: &str, limit: Duration, stop: Option<&AtomicBool>) -> SimulatorFault {
    let text = format!("sh -c '{script}' sim");
    let simulator = CommandSimulator::new(&text, limit).expect("a shell");
    let course = course(&MotionPlan::jolt(0.28, 0.6, 0.8));
    simulator.run(&setup(), &[&course], stop).expect_err(script)
}

#[test]
fn programs_that_fail_hang_or_answer_nonsense_are_refused_by_what_they_did() {
    let limit = Duration::from_secs(20);
    let answer = |content: &str| format!("printf \"%s\" \"{}\" > \"$2\"", content.replace('"', "\\\""));
    let broken = |script: &str, words: &[&str]| match fault(script, limit, None) {
        SimulatorFault::Broken(why) => {
            let all = words.iter().all(|word| why.contains(word));
            assert!(all && why.contains("the simulator"), "{words:?} are not in: {why}");
        }
        other => panic!("{script}: {other:?}"),
    };
    broken("echo no licence >&2; exit 3", &["failed (exit status: 3)", "it said: no licence"]);
    broken("kill -SEGV $$", &["failed (signal: 11"]);
    broken("true", &["ended without the answer"]);
    broken(&answer("hello"), &["something else than JSON"]);
    broken(&answer("{\"meniscus_simulator\": 9, \"heights_m\": []}"), &["version 9", "not 1"]);
    broken(&answer("{\"heights_m\": []}"), &["without \"meniscus_simulator\": 1"]);
    broken(&answer("{\"meniscus_simulator\": 1}"), &["neither heights_m nor a reason"]);
    broken(&answer("{\"meniscus_simulator\": 1, \"heights_m\": []}"), &["0 motions instead of 1"]);
    broken(
        &answer("{\"meniscus_simulator\": 1, \"heights_m\": [[[0.07, NaN]]]}"),
        &["NaN or an infinite number"],
    );
    broken(
        &answer("{\"meniscus_simulator\": 1, \"heights_m\": [[[0.07]]]}"),
        &["motion 1", "frames instead of"],
    );
    broken("head -c 9000000 /dev/zero > \"$2\"", &["more than", "the largest for these motions"]);
    let said = answer("{\"meniscus_simulator\": 1, \"failed\": \"the liquid spills\"}");
    assert_eq!(fault(&said, limit, None), SimulatorFault::Here("the liquid spills".into()));
}

#[test]
fn a_program_that_hangs_is_ended_with_all_that_it_started() {
    let scratch = Scratch::new("hangs");
    let file = scratch.path("ticks");
    // Its child goes on alone unless the whole group is ended.
    let script = format!("(while true; do echo x >> {file}; sleep 0.05; done) & sleep 600");
    let begun = Instant::now();
    let late = fault(&script, Duration::from_millis(700), None);
    assert!(matches!(&late, SimulatorFault::Broken(why) if why.contains("was ended after 0.7 s")), "{late}");
    assert!(begun.elapsed() < Duration::from_secs(10), "{:?}", begun.elapsed());
    let ticks = || std::fs::metadata(&file).map_or(0, |file| file.len());
    let then = ticks();
    assert!(then > 0, "it ran");
    std::thread::sleep(Duration::from_millis(400));
    assert_eq!(ticks(), then, "its child goes on");
    // Ctrl-C.
    let stop = AtomicBool::new(false);
    let ended = std::thread::scope(|scope| {
        scope.spawn(|| {
            std::thread::sleep(Duration::from_millis(200));
            stop.store(true, Ordering::Relaxed);
        });
        fault("sleep 600", Duration::from_secs(600), Some(&stop))
    });
    assert_eq!(ended, SimulatorFault::Stopped);
    assert!(begun.elapsed() < Duration::from_secs(30));
}

#[test]
fn what_is_no_command_is_refused_before_the_work() {
    let refused = |text: &str| CommandSimulator::new(text, Duration::from_secs(1)).expect_err(text);
    assert!(matches!(refused(""), CommandError::Text(_)));
    assert!(matches!(refused("python3 'sim.py"), CommandError::Text(_)));
    assert!(
        refused("no-such-program-anywhere --fast")
            .to_string()
            .contains("'no-such-program-anywhere' is not there")
    );
    // A file that may not be run.
    let scratch = Scratch::new("plain");
    let plain = scratch.path("plain");
    std::fs::write(&plain, "x").expect("written");
    assert!(matches!(refused(&plain), CommandError::Program(_)));
}

#[test]
fn an_edited_program_is_another_simulator() {
    let scratch = Scratch::new("edited");
    let script = scratch.path("sim.py");
    let identity = |content: &str| {
        std::fs::write(&script, content).expect("written");
        let simulator = CommandSimulator::new(&format!("python3 {script}"), Duration::from_secs(1));
        simulator.expect("it is there").identity().to_string()
    };
    let (one, other) = (identity("a = 1"), identity("a = 2"));
    assert!(one != other && one == identity("a = 1"));
}
