//! The simulator against theory, and recordings against the disk.
//!
//! The frequency is measured at the spacing of the recordings, 5 mm; the other runs have 7 mm (about
//! 800 particles), a quarter of the cost. The bounds are the measured errors, rounded up.

#[cfg(target_arch = "x86_64")]
#[path = "support/optional.rs"]
mod optional;

use meniscus_data::effects::Effects;
use meniscus_data::glass::WallShape;
use meniscus_data::liquids::{Liquid, Rheology};
use meniscus_data::motion::Motion;
use meniscus_data::recording::{Glass, Recording, STATE, States};
use meniscus_sph::validate::{Mode, Tone, fit};
use meniscus_sph::{Error, Setup, Simulator, record, relative_closure};
use std::path::PathBuf;

const GLASS: Glass = Glass { radius_m: 0.035, fill_m: 0.07, rim_m: 0.11, wall: WallShape::UPRIGHT };

fn setup(viscosity: f64, spacing_m: f64) -> Setup {
    let rheology = Rheology::newtonian(viscosity);
    let liquid = Liquid { name: "test".into(), density_kg_m3: 1261.0, rheology, effects: Effects::default() };
    Setup {
        glass: GLASS,
        liquid,
        spacing_m,
        seed: 0,
        no_slip: true,
        effects: Effects::default(),
        step_s: None,
    }
}

/// Lets the first mode ring from 0.05 m/s for `seconds`; returns times and modal momentum.
fn ring(viscosity: f64, spacing_m: f64, seconds: f64) -> Vec<(f64, f64)> {
    let mut simulator = Simulator::new(&setup(viscosity, spacing_m)).expect("the glass settles");
    let mode = Mode::first(GLASS);
    simulator.set_velocity(|x| mode.velocity(x).map(|v| 0.05 * v));
    let mut series = Vec::new();
    while simulator.time_s() < seconds {
        let momentum = |(x, v, m): ([f64; 3], [f64; 3], f64)| {
            m * mode.velocity(x).iter().zip(v).map(|(e, v)| e * v).sum::<f64>()
        };
        series.push((simulator.time_s(), simulator.motion().map(momentum).sum()));
        simulator.step(|_| 0.0).expect("the mode rings inside the glass");
    }
    series
}

#[test]
fn the_first_mode_has_its_inviscid_frequency() {
    let theory = Mode::first(GLASS).hz();
    let guess = Tone { hz: theory, decay: 0.5 };
    let Tone { hz, decay } = fit(&ring(0.0, 0.005, 0.5), guess, &[]).expect("it rings").tone;
    println!("inviscid: {hz} Hz for {theory}, decay {decay} /s for 0");
    assert!((hz / theory - 1.0).abs() < 0.03, "{hz} Hz for {theory}");
    assert!((0.0..1.5).contains(&decay), "numerical decay {decay} /s");
}

#[test]
fn glycerine_decays_by_boundary_layer_and_bulk() {
    let series = ring(0.950, 0.007, 0.6);
    // The start is not the viscous mode: leave out the first 50 ms, in which the wall layer forms.
    let rest = series.iter().position(|(t, _)| *t > 0.05).expect("the series is longer");
    let mode = Mode::first(GLASS);
    let theory = mode.layer_decay(0.950 / 1261.0);
    let guess = Tone { hz: mode.hz(), decay: theory };
    let Tone { hz, decay } = fit(&series[rest..], guess, &[]).expect("it rings").tone;
    println!("glycerine: {hz} Hz, decay {decay} /s for {theory}");
    assert!((decay / theory - 1.0).abs() < 0.15, "{decay} /s for {theory}");
}

/// A short recording of `motion` in a glycerine-like liquid on `threads` threads.
fn short(motion: &Motion, frames: usize, threads: usize) -> Recording {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start");
    pool.install(|| record(&setup(0.950, 0.007), motion, frames, "test", |_| ()))
        .expect("the glass is simulated")
}

fn states(recording: &Recording) -> Vec<u32> {
    let mut row = vec![0.0; STATE];
    let mut bits = Vec::new();
    for frame in 0..recording.frames() {
        recording.state(frame, &mut row);
        bits.extend(row.iter().map(|x| x.to_bits()));
    }
    bits
}

/// A file of this process that is gone when the test ends.
struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str) -> Self {
        Self(std::env::temp_dir().join(format!("meniscus-{}-{name}", std::process::id())))
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // A test that failed before it wrote the file leaves nothing to remove.
        let _ = std::fs::remove_file(&self.0);
    }
}

#[test]
fn threads_change_no_bit_and_the_disk_changes_none_either() {
    let motion = Motion::parse("jolts:3", 2.0).expect("a known motion");
    let (one, two) = (short(&motion, 30, 1), short(&motion, 30, 2));
    assert_eq!(states(&one), states(&two));
    assert_eq!(one.energy, two.energy);

    let file = Scratch::new("full");
    one.save(&file.0).expect("the recording is written");
    let read = Recording::load(&file.0).expect("the recording is read");
    assert_eq!(states(&read), states(&one));
    assert_eq!((&read.provenance, &read.energy, &read.wall_m), (&one.provenance, &one.energy, &one.wall_m));

    let compact = one.clone().compact(0.01);
    compact.save(&file.0).expect("the compact recording is written");
    let read = Recording::load(&file.0).expect("the compact recording is read");
    assert_eq!(states(&read), states(&compact));

    let bytes = std::fs::read(&file.0).expect("the file is there");
    for cut in [0, 7, bytes.len() / 2, bytes.len() - 1] {
        std::fs::write(&file.0, &bytes[..cut]).expect("the file is cut");
        assert!(Recording::load(&file.0).is_err(), "a file cut at {cut} of {} bytes was read", bytes.len());
    }
}

/// Bits of all positions and velocities of a liquid of the viscosity `viscosity` after 40 jolted steps.
fn jolted(viscosity: f64) -> Vec<u64> {
    let mut simulator = Simulator::new(&setup(viscosity, 0.007)).expect("the glass settles");
    simulator.divide(0.02);
    for _ in 0..40 {
        simulator.step(|t| if t < 0.01 { 3.0 } else { -3.0 }).expect("the liquid stays inside");
    }
    simulator.motion().flat_map(|(x, v, _)| x.into_iter().chain(v)).map(f64::to_bits).collect()
}

/// No other test of this file widens the vectors.
#[cfg(target_arch = "x86_64")]
#[test]
fn vectors_of_any_width_change_no_bit() {
    let words = meniscus_platform::cpu_features::words();
    assert_eq!(words, "SSE2, as any x86-64", "vectors are wide before anything has asked for it");
    // With and without the friction of what is not smooth.
    let narrow = [0.001, 0.950].map(jolted);
    meniscus_platform::cpu_features::widen();
    if !meniscus_platform::cpu_features::words().starts_with("AVX2") {
        return optional::skip("this processor has no AVX2, or MENISCUS_NARROW is set");
    }
    let wide = [0.001, 0.950].map(jolted);
    assert!(narrow == wide, "a position or a velocity differs between the widths");
}

#[test]
fn energy_closes_and_the_surface_rests_at_the_fill() {
    let motion = Motion::parse("strokes:7", 2.0).expect("a known motion");
    let recording = short(&motion, 100, 2);
    let closure = relative_closure(&recording.energy);
    println!("closure {closure}");
    assert!(closure < 0.01, "energy closes to {closure} of the slosh energy");
    let work = recording.energy.iter().map(|b| b.work).fold(0.0, f64::max);
    assert!(work > 1e-4, "the motion did only {work} J of work");
    let columns = recording.column_m.len() / recording.frames();
    let worst = recording.column_m[..columns].iter().map(|h| (h - 0.07).abs()).fold(0.0, f32::max);
    println!("rest error {worst} m");
    assert!(worst < 0.5e-3, "the resting surface is off by {worst} m");
}

#[test]
fn a_glass_torn_away_is_refused_with_the_escape() {
    let file = Scratch::new("torn.csv");
    let lines: Vec<_> =
        (0..20).map(|i| format!("{},{}", 0.01 * f64::from(i), if i < 10 { 0.0 } else { 0.2 })).collect();
    std::fs::write(&file.0, lines.join("\n")).expect("the motion is written");
    let motion = Motion::parse(&file.0.to_string_lossy(), 0.3).expect("a valid file");
    let refused = record(&setup(0.01, 0.007), &motion, 18, "test", |_| ()).expect_err("the liquid flies out");
    assert!(matches!(refused, Error::Escaped { count: 1.., .. }), "{refused}");
}

/// The crest stands 33 mm above the fill at the wall. With the step of the rest its edge shot through the wall at 0.74 s.
#[test]
fn a_wave_that_breaks_below_the_rim_stays_in_the_glass() {
    let liquid = Liquid::load("water").expect("a named liquid");
    let motion = Motion::parse("jolts:2", 2.0).expect("a known motion");
    let water = Setup { liquid, ..setup(0.0, 0.005) };
    let recording = record(&water, &motion, 54, "test", |_| ()).expect("the wave breaks inside the glass");
    let crest = recording.column_m.iter().fold(0.0_f32, |a, h| a.max(*h));
    println!("crest {crest} m");
    assert!(crest > 0.09, "the wave is too gentle to break: {crest} m");
}

/// Runs `meniscus simulate` with `arguments` and `--out file`.
fn command(arguments: &[&str], file: &Scratch) -> std::process::Output {
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_meniscus-under-test"));
    command.arg("simulate").args(arguments).arg("--out").arg(&file.0);
    command.output().expect("the command starts")
}

#[test]
fn the_command_records_and_tells_how_to_record_again() {
    let file = Scratch::new("command");
    let arguments =
        ["--motion", "still", "--seconds", "0.1", "--spacing-mm", "8.75", "--particles", "--json"];
    let output = command(&arguments, &file);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).expect("a JSON object");
    assert_eq!((report["frames"].as_u64(), report["escapes"].as_u64()), (Some(6), Some(0)));
    let recording = Recording::load(&file.0).expect("the recording is read");
    assert_eq!(recording.frames(), 6);
    let beside = Scratch(file.0.with_extension("particles.safetensors"));
    let bytes = std::fs::read(&beside.0).expect("the particles are written beside it");
    let tensors = safetensors::SafeTensors::deserialize(&bytes).expect("a safetensors file");
    let position = tensors.tensor("position_m").expect("it holds places");
    let [frames, particles, 3] = *position.shape() else { panic!("{:?}", position.shape()) };
    assert_eq!((frames, tensors.tensor("mass_kg").expect("it holds masses").shape()), (6, &[particles][..]));
    let height = |place: &[u8; 12]| f32::from_le_bytes([place[8], place[9], place[10], place[11]]);
    let heights = position.data().as_chunks::<12>().0.iter().map(height);
    assert!(
        heights.into_iter().all(|z| (0.0..0.075).contains(&z)),
        "a particle is not in the liquid at rest"
    );
    let again = "meniscus simulate --liquid glycerine --motion still --seconds 0.1 --spacing-mm 8.75";
    assert_eq!(recording.provenance.command, again);
}

#[test]
fn the_command_refuses_wrong_input_and_leaves_no_file() {
    for (wrong, reason) in [
        (["--liquid", "treacle", "--motion", "still"], "no liquid is called 'treacle'"),
        (["--motion", "stroke:1", "--seconds", "4"], "no motion is spelled 'stroke:1'"),
        (["--motion", "still", "--seconds", "-1"], "--seconds"),
        (["--motion", "still", "--spacing-mm", "20"], "particle spacing of 20.00 mm"),
    ] {
        let file = Scratch::new("refused");
        let output = command(&wrong, &file);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && said.contains(reason), "{wrong:?} said {said}");
        assert!(!file.0.exists(), "{wrong:?} left a file");
    }
}

#[test]
fn the_shipped_recording_is_whole_and_states_its_error() {
    let path =
        PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../recordings/glycerine-unseen.safetensors"));
    let size = std::fs::metadata(&path).expect("the recording is there").len();
    assert!(size < 3_670_016, "{size} bytes are more than 3.5 MiB");
    let recording = Recording::load(&path).expect("the recording is read");
    assert_eq!(recording.frames(), 600);
    let motion = Motion::parse(&recording.provenance.motion, 10.0).expect("a known motion");
    for (frame, x) in recording.glass_x_m.iter().enumerate() {
        assert!((x - motion.position(frame as f64 / 60.0)).abs() < 1e-12, "frame {frame}");
    }
    let States::Factored(factored) = &recording.states else { panic!("the states are not factored") };
    assert!(factored.truncation.iter().all(|e| (0.0..0.006).contains(e)), "{:?}", factored.truncation);
}
