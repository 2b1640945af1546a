//! Closed systems that the tests simulate, learnt from their trajectories, and the replay of a net in the published
//! form. `docs/evaluation/published.md` names the commands that compare with the published nets themselves.

#[path = "closed/baselines.rs"]
mod baselines;

use baselines::{Linear, relative_error};
use generic_systems::{
    Dataset, Kinds, Networks, Options, Outcome, ProgressBars, Published, ReversibleOperator, Schedule,
    checks, train,
};
use nalgebra::DVector;
use npyz::WriterBuilder;
use npyz::npz::NpzWriter;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

/// Writes arrays of a name, a shape and numbers.
fn write(path: &Path, arrays: &[(&str, &[u64], &[f64])]) {
    let mut file = NpzWriter::create(path).expect("a file");
    for (name, shape, values) in arrays {
        let array = file.array::<f64>(name, Default::default()).expect("an array");
        let mut writer = array.default_dtype().shape(shape).begin_nd().expect("a header");
        writer.extend(values.iter().copied()).expect("numbers");
        writer.finish().expect("the end");
    }
}

/// A net of two variables in the published form: its hidden layer passes max(z, 0) on, of which A and B take their
/// upper left and lower right numbers. The expected numbers are worked out by hand.
#[test]
fn a_net_in_the_published_form_is_replayed() {
    let path = scratch("published.npz");
    // A = [[max(z1, 0), 0], [0, 1]], B = [[0, 0], [0, 2 max(z2, 0)]].
    let mut last = [0.0; 16];
    (last[0], last[15]) = (1.0, 2.0);
    let arrays: [(&str, &[u64], &[f64]); 9] = [
        ("W0", &[2, 2], &[1.0, 0.0, 0.0, 1.0]),
        ("b0", &[2], &[0.0, 0.0]),
        ("W1", &[8, 2], &last),
        ("b1", &[8], &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0]),
        ("mean", &[2], &[10.0, 20.0]),
        ("std", &[2], &[2.0, 4.0]),
        ("L", &[2, 2], &[0.0, 1.0, -1.0, 0.0]),
        ("M", &[2, 2], &[0.0, 0.0, 0.0, 3.0]),
        ("dt", &[1], &[0.5]),
    ];
    write(&path, &arrays);
    let net = Published::read(&path).expect("weights");
    assert_eq!(net.variables(), 2);
    // z = (3, 2): DE = (9, 2), DS = (0, 8); L DE = (2, -9), M DS = (0, 24).
    let said = net.say(&DVector::from_vec(vec![3.0, 2.0]));
    assert_eq!((said.energy.as_slice(), said.entropy.as_slice()), (&[9.0, 2.0][..], &[0.0, 8.0][..]));
    assert_eq!(said.next.as_slice(), [4.0, 9.5]);
    // z = (-3, -2): the ReLU is closed; DE = (0, -2), DS = 0, L DE = (-2, 0).
    let said = net.say(&DVector::from_vec(vec![-3.0, -2.0]));
    assert_eq!(said.next.as_slice(), [-4.0, -2.0]);
    // The same step from a state in its units: 10 + 2 z1, 20 + 4 z2.
    let path = net.roll_out(&DVector::from_vec(vec![4.0, 12.0]), 2);
    assert_eq!((path[0].as_slice(), path[1].as_slice()), (&[4.0, 12.0][..], &[2.0, 12.0][..]));
}

/// Largest relative error of the exact net's roll-outs over the swing's test trajectories, percent; measured: 0.3.
const SWING_TARGET: f64 = 1.0;

/// Returns the value of the check called `name`.
fn value(outcome: &Outcome, name: &str) -> f64 {
    let checks = checks(outcome);
    checks.iter().find(|c| c.name == name).and_then(|c| c.value).expect(name)
}

fn assert_laws(outcome: &Outcome) {
    let checks = checks(outcome);
    for check in &checks {
        println!("{:28} {:12.4e} {}", check.name, check.value.unwrap_or(f64::NAN), check.unit);
    }
    for law in ["entropy_falls", "energy_drift_step", "exact_energy_drift", "exact_L_dS", "exact_M_dE"] {
        let check = checks.iter().find(|c| c.name == law).expect(law);
        assert_eq!(check.ok, Some(true), "{law}: {:?}", check.value);
    }
    // The meter can move: the soft net's loss asks for the laws, and its numbers show what is left.
    for law in ["soft_energy_drift", "soft_M_dE"] {
        assert!(value(outcome, law) > 1e-6, "{law}");
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
    write(path, &[("Z", &[count as u64, 3, steps as u64], &z), ("dt", &[1], &[dt])]);
}

fn scratch(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("closed");
    std::fs::create_dir_all(&folder).expect("a folder");
    folder.join(name)
}

/// Nothing of it is given: operators, energy and friction are learnt from states, and the laws hold to rounding.
#[test]
fn a_swing_with_friction_is_learnt() {
    let path = scratch("swing.npz");
    swing(&path);
    let data = Dataset::read(&path, 1).expect("trajectories");
    assert_eq!((data.training.len(), data.test.len(), data.variables()), (10, 2, 3));
    let truth: Vec<&[DVector<f64>]> = data.test.iter().map(|&k| data.paths[k].as_slice()).collect();
    let error = |said: Vec<Vec<DVector<f64>>>| 100.0 * relative_error(&truth, &said);
    let still = error(truth.iter().map(|path| vec![path[0].clone(); path.len()]).collect());
    let model = Linear::fit(data.training.iter().map(|&k| data.paths[k].as_slice()));
    let linear = error(truth.iter().map(|path| model.roll_out(&path[0], path.len())).collect());
    // Energy of the whole, p^2/2 - cos q + heat, stays to the accuracy of the integration.
    for path in &data.paths {
        let energy = |z: &DVector<f64>| 0.5 * z[1] * z[1] + 1.0 - z[0].cos() + z[2];
        let first = energy(&path[0]);
        assert!(path.iter().all(|z| (energy(z) / first - 1.0).abs() < 2e-3));
    }
    let options = Options {
        seed: 1,
        schedule: Schedule { steps: 20, rollouts: 4, soft: [300, 10], seeds: 1 },
        kinds: Kinds::default(),
        reversible: ReversibleOperator::FromFile,
        networks: Networks::ExactAndSoft,
        progress: ProgressBars::Hidden,
        checkpoints: None,
    };
    let names = ["q", "p", "heat"].map(String::from).to_vec();
    let outcome = train(data, names, None, &options, &AtomicBool::new(false));
    assert_laws(&outcome);
    let exact = value(&outcome, "exact_rollout");
    println!("roll-outs: exact {exact:.2} %, linear model {linear:.2} %, no dynamics {still:.2} %");
    assert!(exact < SWING_TARGET, "{exact} %");
    // Neither the first state for ever nor the best linear model comes near.
    assert!(linear > 5.0 * SWING_TARGET && still > 5.0 * SWING_TARGET, "{linear} %, {still} %");
    assert!(value(&outcome, "soft_rollout").is_finite());
    assert!(!outcome.safetensors().expect("a file").is_empty());
}

/// The error of a wrong file names the array and the cause.
#[test]
fn a_wrong_file_is_refused_by_name() {
    let path = scratch("wrong.npz");
    let put = |arrays: &[(&str, &[u64], &[f64])]| write(&path, arrays);
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
