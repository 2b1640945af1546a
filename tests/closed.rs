//! Closed systems from their trajectories, and the published nets replayed.
//!
//! The published data lie beside the repository in `../shared/data/spnn`; where they are absent the test says so and
//! passes.
#![allow(clippy::disallowed_methods, reason = "only storey 1 must compute the same bits on every platform")]

use generic_systems::{Dataset, Kinds, Options, Published, Schedule, checks, train};
use nalgebra::DVector;
use npyz::WriterBuilder;
use npyz::npz::{NpzArchive, NpzWriter};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

fn shared(name: &str) -> Option<PathBuf> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/spnn").join(name);
    if !path.exists() {
        println!("skipped: {} is absent", path.display());
        return None;
    }
    Some(path)
}

fn array(path: &Path, name: &str) -> Vec<f64> {
    let mut archive = NpzArchive::open(path).expect("an npz file");
    let file = archive.by_name(name).expect(name).expect(name);
    file.into_vec::<f32>().expect(name).into_iter().map(f64::from).collect()
}

/// DE, DS, one step and a roll-out of both published nets, against what they gave themselves.
#[test]
fn published_nets_are_replayed() {
    for system in ["double_pendulum", "viscoelastic"] {
        let Some(weights) = shared(&format!("spnn_{system}_weights.npz")) else { return };
        let Some(io) = shared(&format!("spnn_{system}_io.npz")) else { return };
        let net = Published::read(&weights).expect("the published weights");
        let n = net.variables();
        let [z, z1, de, ds] = ["z_norm", "z1_norm", "DE", "DS"].map(|name| array(&io, name));
        for (k, z) in z.chunks_exact(n).enumerate() {
            let said = net.say(&DVector::from_column_slice(z));
            for (ours, theirs) in [(&said.energy, &de), (&said.entropy, &ds), (&said.next, &z1)] {
                for (ours, theirs) in ours.iter().zip(&theirs[k * n..]) {
                    assert!((ours - theirs).abs() < 1e-5, "{system}, input {k}: {ours} against {theirs}");
                }
            }
        }
        // [variable, step].
        let (rolled, truth) = (array(&io, "rollout0"), array(&io, "gt0"));
        let steps = rolled.len() / n;
        let first = DVector::from_fn(n, |i, _| truth[i * steps]);
        for (step, ours) in net.roll_out(&first, steps).iter().enumerate() {
            for (i, ours) in ours.iter().enumerate() {
                let theirs = rolled[i * steps + step];
                assert!(
                    (ours - theirs).abs() < 3e-5 * (1.0 + theirs.abs()),
                    "{system}, step {step}: {ours}, {theirs}"
                );
            }
        }
    }
}

/// The published trajectories lie in the order of numpy's transpose, and are read as they are meant: neighbours in time
/// are close, and the first of them is the published net's.
#[test]
fn published_trajectories_are_read() {
    let Some(path) = shared("spnn_double_pendulum_dataset.npz") else { return };
    let Some(io) = shared("spnn_double_pendulum_io.npz") else { return };
    let data = Dataset::read(&path, 1).expect("trajectories");
    assert_eq!((data.variables(), data.training.len(), data.test.len()), (10, 40, 10));
    let truth = array(&io, "gt0");
    let first =
        &data.paths.iter().position(|path| (0..10).all(|i| (path[0][i] - truth[i * 200]).abs() < 1e-4));
    let first = &data.paths[first.expect("the trajectory of the roll-out")];
    for (step, z) in first.iter().enumerate() {
        for i in 0..10 {
            assert!((z[i] - truth[i * 200 + step]).abs() < 1e-4, "step {step}, variable {i}");
        }
    }
}

/// A swing with friction, q'' = -sin q - 0.1 q', whose heat is a third variable; every trajectory its own height.
fn swing(path: &Path) {
    let (count, steps, dt, fine) = (12_usize, 60_usize, 0.1, 100);
    let mut z = vec![0.0; count * 3 * steps];
    for k in 0..count {
        let (mut q, mut p, mut heat) = (0.5 + 0.1 * k as f64, 0.0, 0.0);
        for step in 0..steps {
            for (i, value) in [q, p, heat].into_iter().enumerate() {
                z[(k * 3 + i) * steps + step] = value;
            }
            for _ in 0..fine {
                let h = dt / f64::from(fine);
                heat += 0.1 * p * p * h;
                p -= h * (q.sin() + 0.1 * p);
                q += h * p;
            }
        }
    }
    let mut file = NpzWriter::create(path).expect("a file");
    let mut put = |name: &str, shape: &[u64], values: &[f64]| {
        let array = file.array::<f64>(name, Default::default()).expect("an array");
        let mut writer = array.default_dtype().shape(shape).begin_nd().expect("a header");
        writer.extend(values.iter().copied()).expect("numbers");
        writer.finish().expect("the end");
    };
    put("Z", &[count as u64, 3, steps as u64], &z);
    put("dt", &[1], &[dt]);
}

fn scratch(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("closed");
    std::fs::create_dir_all(&folder).expect("a folder");
    folder.join(name)
}

/// Nothing of it is told: operators, energy and friction are learnt from states, and the laws hold to rounding.
#[test]
fn a_swing_with_friction_is_learnt() {
    let path = scratch("swing.npz");
    swing(&path);
    let data = Dataset::read(&path, 1).expect("trajectories");
    assert_eq!((data.training.len(), data.test.len(), data.variables()), (10, 2, 3));
    let options = Options {
        seed: 1,
        schedule: Schedule { steps: 20, rollouts: 4, soft: [300, 10], seeds: 1 },
        kinds: Kinds::default(),
        loose: false,
        soft: true,
        quiet: true,
        checkpoints: None,
    };
    let names = ["q", "p", "heat"].map(String::from).to_vec();
    let outcome = train(data, names, None, &options, &AtomicBool::new(false));
    let checks = checks(&outcome);
    for check in &checks {
        println!("{:24} {:12.4e} {}", check.name, check.value.unwrap_or(f64::NAN), check.unit);
    }
    let value = |name: &str| checks.iter().find(|c| c.name == name).and_then(|c| c.value).expect(name);
    assert!(value("exact_rollout") < 10.0, "{} %", value("exact_rollout"));
    assert!(value("soft_rollout").is_finite());
    for law in ["entropy_falls", "energy_drift_step", "exact_energy_drift", "exact_L_dS", "exact_M_dE"] {
        let check = checks.iter().find(|c| c.name == law).expect(law);
        assert!(check.ok, "{law}: {:?}", check.value);
    }
    // The meter can move: what is only asked for is not kept.
    assert!(value("soft_energy_drift") > 1e-6 && value("soft_M_dE") > 1e-6);
    assert!(!outcome.safetensors().expect("a file").is_empty());
}

/// What is wrong with a file is said by array and cause.
#[test]
fn a_wrong_file_is_refused_by_name() {
    let path = scratch("wrong.npz");
    let put = |arrays: &[(&str, &[u64], &[f64])]| {
        let mut file = NpzWriter::create(&path).expect("a file");
        for (name, shape, values) in arrays {
            let array = file.array::<f64>(name, Default::default()).expect("an array");
            let mut writer = array.default_dtype().shape(shape).begin_nd().expect("a header");
            writer.extend(values.iter().copied()).expect("numbers");
            writer.finish().expect("the end");
        }
    };
    let z: Vec<f64> = (0..100).map(f64::from).collect();
    let refused = || Dataset::read(&path, 1).expect_err("a refusal").to_string();
    put(&[("dt", &[1], &[0.1])]);
    assert!(refused().contains("no array 'Z'"), "{}", refused());
    put(&[("Z", &[100], &z), ("dt", &[1], &[0.1])]);
    assert!(refused().contains("[trajectory, variable, step]"), "{}", refused());
    put(&[("Z", &[5, 2, 10], &z), ("dt", &[1], &[-1.0])]);
    assert!(refused().contains("'dt'"), "{}", refused());
    put(&[("Z", &[5, 2, 10], &z), ("dt", &[1], &[0.1]), ("L", &[2, 2], &[0.0, 1.0, 1.0, 0.0])]);
    assert!(refused().contains("not skew"), "{}", refused());
    let mut holed = z.clone();
    holed[7] = f64::NAN;
    put(&[("Z", &[5, 2, 10], &holed), ("dt", &[1], &[0.1])]);
    assert!(refused().contains("number 7"), "{}", refused());
    put(&[("Z", &[5, 2, 10], &z), ("dt", &[1], &[0.1]), ("L", &[2, 2], &[0.0, 1.0, -1.0, 0.0])]);
    let data = Dataset::read(&path, 1).expect("trajectories");
    let kinds = Kinds { entropies: vec![1], ..Kinds::default() };
    assert!(kinds.clash(&data).expect("a clash").contains("moves the sum of the entropies"));
    assert_eq!(Kinds::default().clash(&data), None);
    let twice = Kinds { points: vec![vec![0]], entropies: vec![0], ..Kinds::default() };
    assert!(twice.fault(2).expect("a fault").contains("two kinds") && kinds.fault(1).is_some());
    assert!(
        Dataset::read(Path::new("absent.npz"), 1).expect_err("no file").to_string().contains("absent.npz")
    );
}
