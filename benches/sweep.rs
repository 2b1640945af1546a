//! Cost of a sweep beside its parts: the time of `meniscus sweep` from the design to the report, over that of the same
//! commands run one after the other by hand.
//!
//! Both are whole processes of the program and take turns, so that a change of the machine meets both.
//!
//! `cargo build --release -p meniscus-cli && cargo bench -p meniscus-benches --bench sweep`

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

/// Rounds; each runs both ways.
const ROUNDS: usize = 5;

/// Largest time of a sweep over the sum of its parts.
const MOST: f64 = 1.05;

/// Command of a part, in the words of a design.
const PART: &str = "simulate --liquid {liquid} --motion strokes:{seed}x0.2 --seconds 2 --spacing-mm 7 --out {out}/slosh.safetensors";

const LIQUIDS: [&str; 2] = ["water", "glycerine"];
const SEEDS: [&str; 2] = ["1", "2"];

fn main() {
    let program = program();
    let folder = std::env::temp_dir().join(format!("meniscus-sweep-bench-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let design = format!("command = {PART:?}\n[vary]\nliquid = {LIQUIDS:?}\nseed = {SEEDS:?}\n");
    std::fs::write(folder.join("design.toml"), design).expect("a design");
    let (mut by_hand, mut swept) = (Vec::new(), Vec::new());
    for round in 0..ROUNDS {
        by_hand.push(timed(|| parts(&program, &folder, round)));
        swept.push(timed(|| {
            for words in [
                format!("sweep make design.toml --out sweep-{round}"),
                format!("sweep run sweep-{round}"),
                format!("sweep merge sweep-{round}"),
            ] {
                run(&program, &folder, &words);
            }
        }));
    }
    std::fs::remove_dir_all(&folder).expect("the folder goes");
    let mut ratios: Vec<f64> = swept.iter().zip(&by_hand).map(|(swept, parts)| swept / parts).collect();
    let [parts_s, sweep_s, ratio] = [&mut by_hand, &mut swept, &mut ratios].map(|values| median(values));
    let (least, most) = (ratios[0], ratios[ROUNDS - 1]);
    println!("parts by hand {parts_s:.2} s, sweep {sweep_s:.2} s, medians of {ROUNDS} rounds");
    println!("sweep over parts {ratio:.3} (rounds {least:.3} to {most:.3}), at most {MOST}");
}

/// The program under measurement: that of the environment, or the one in the build folder.
fn program() -> PathBuf {
    let built = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/release/meniscus");
    let program = std::env::var_os("MENISCUS_PROGRAM").map_or_else(built, PathBuf::from);
    assert!(program.is_file(), "{} is missing: cargo build --release -p meniscus-cli", program.display());
    program
}

/// Runs the parts one after the other.
fn parts(program: &Path, folder: &Path, round: usize) {
    for liquid in LIQUIDS {
        for seed in SEEDS {
            let out = format!("parts-{round}-{liquid}-{seed}");
            let words = PART.replace("{liquid}", liquid).replace("{seed}", seed).replace("{out}", &out);
            run(program, folder, &words);
        }
    }
}

fn run(program: &Path, folder: &Path, words: &str) {
    let mut command = Command::new(program);
    command.args(words.split(' ')).current_dir(folder).stdout(Stdio::null()).stderr(Stdio::null());
    assert!(command.status().expect("the program starts").success(), "meniscus {words} failed");
}

fn timed(work: impl FnOnce()) -> f64 {
    let begun = Instant::now();
    work();
    begun.elapsed().as_secs_f64()
}

/// Sorts `values` and returns the median.
fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
