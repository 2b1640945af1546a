//! `cargo xtask under-attack`: runs of the program with and without attackers, in turn.
//!
//! ```text
//! quiet, attacked, quiet, attacked, ...  --median-->  ratios of turn time and of the error of v; frames lost; what got in
//! quiet, attacked, under callgrind       --median-->  ratio of the instructions of a turn
//! ```
//! The program serves a page, Foxglove and a Unix socket, and listens for motion. The attackers hold the page and the socket,
//! flood the port of the motion, and ask Foxglove as a web page of somebody else.

mod attackers;
mod instructions;
mod rounds;

use crate::report::{self, Check, Target};
use crate::workspace;
use anyhow::{Context, Result, ensure};
use clap::Args;
use rounds::{Meter, Program, Round};
use std::path::PathBuf;

/// Largest median of the instructions of a turn under attack, in units of that without.
const INSTRUCTIONS_RATIO: f64 = 1.05;
/// Largest median time of a turn under attack, in units of that without.
const TURN_RATIO: f64 = 1.1;
/// Largest error of v under attack, in units of that without.
const ERROR_RATIO: f64 = 1.1;
/// Least number of connections, requests and datagrams of an attacked run: without attempts nothing was attacked.
const LEAST_ATTEMPTS: f64 = 1e4;

#[derive(Args)]
pub(crate) struct Options {
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
    /// Program with the feature foxglove.
    #[arg(long, value_name = "FILE", default_value = "target/release/meniscus")]
    program: PathBuf,
    /// Pairs of a quiet and an attacked run.
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=100))]
    pairs: u32,
    /// Length of each run, s.
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u32).range(5..=3600))]
    seconds: u32,
    /// Length of the two runs whose instructions are counted, s of the camera's time; each takes some ten times as long.
    #[arg(long, default_value_t = 6, value_parser = clap::value_parser!(u32).range(2..=60))]
    counted_seconds: u32,
}

/// Runs the verb; whether every check meets its target.
pub(crate) fn run(options: &Options) -> Result<bool> {
    let root = workspace::root()?;
    let path = root.join(&options.program);
    ensure!(
        path.is_file(),
        "there is no program {}; build it: cargo build --release -p meniscus-cli --features foxglove",
        path.display()
    );
    let folder = root.join("target/under-attack");
    std::fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
    let program = Program { path, meter: Meter::Time, seconds: options.seconds, folder };
    let (mut quiet, mut attacked) = (Vec::new(), Vec::new());
    for pair in 1..=options.pairs {
        eprintln!("pair {pair} of {}: quiet, then attacked, {} s each", options.pairs, options.seconds);
        quiet.push(program.quiet()?);
        attacked.push(program.attacked()?);
    }
    let program = Program { meter: Meter::Instructions, seconds: options.counted_seconds, ..program };
    let checks = checks(&quiet, &attacked, instructions_ratio(&program)?);
    report::print(&checks, options.json);
    Ok(checks.iter().all(Check::ok))
}

/// Returns the median of the instructions of a turn under attack, in units of that without.
fn instructions_ratio(program: &Program) -> Result<f64> {
    eprintln!("instructions: quiet, then attacked, {} s of the camera's time each", program.seconds);
    program.quiet()?;
    let quiet = program.instructions()?;
    let round = program.attacked()?;
    let attacked = program.instructions()?;
    eprintln!("instructions of a turn: {quiet:.0}, attacked {attacked:.0} ({:.0} attempts)", round.attempts);
    // A run that nobody attacked shows nothing.
    ensure!(round.attempts >= LEAST_ATTEMPTS, "the counted run met {} attempts only", round.attempts);
    Ok(attacked / quiet)
}

/// The median of a figure over some runs.
fn median(rounds: &[Round], figure: impl Fn(&Round) -> f64) -> f64 {
    let mut all: Vec<f64> = rounds.iter().map(figure).collect();
    all.sort_by(f64::total_cmp);
    let upper = all.get(all.len() / 2).copied().unwrap_or(f64::NAN);
    let lower = all.get(all.len().saturating_sub(1) / 2).copied().unwrap_or(f64::NAN);
    0.5 * (lower + upper)
}

fn checks(quiet: &[Round], attacked: &[Round], instructions_ratio: f64) -> Vec<Check> {
    let sum = |rounds: &[Round], figure: fn(&Round) -> f64| rounds.iter().map(figure).sum::<f64>();
    let ratio = |figure: fn(&Round) -> f64| median(attacked, figure) / median(quiet, figure);
    let check = |name, value, unit, target| Check { name, value, unit, target, offenders: Vec::new() };
    let lost = |round: &Round| round.lost;
    let attempts = sum(attacked, |round| round.attempts);
    vec![
        check("turn_instructions_ratio", instructions_ratio, "1", Target::AtMost(INSTRUCTIONS_RATIO)),
        check("turn_time_under_attack", ratio(|round| round.turn_us), "1", Target::AtMost(TURN_RATIO)),
        check("v_error_under_attack", ratio(|round| round.v_error), "1", Target::AtMost(ERROR_RATIO)),
        check("frames_more_lost", sum(attacked, lost) - sum(quiet, lost), "frames", Target::AtMost(0.0)),
        check("false_samples_used", sum(attacked, |round| round.samples_used), "turns", Target::AtMost(0.0)),
        check("intruders_let_in", sum(attacked, |round| round.let_in), "pages", Target::AtMost(0.0)),
        check("attempts", attempts, "", Target::AtLeast(LEAST_ATTEMPTS * attacked.len() as f64)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    const QUIET: Round =
        Round { turn_us: 300.0, v_error: 0.06, lost: 1.0, samples_used: 0.0, let_in: 0.0, attempts: 0.0 };

    fn missed(attacked: Round) -> Vec<&'static str> {
        missed_with(attacked, 1.0)
    }

    fn missed_with(attacked: Round, instructions_ratio: f64) -> Vec<&'static str> {
        let checks = checks(&[QUIET, QUIET], &[attacked, attacked], instructions_ratio);
        checks.iter().filter(|check| !check.ok()).map(|check| check.name).collect()
    }

    #[test]
    fn each_harm_has_a_check_that_it_misses() {
        let fended = Round { attempts: 2e4, ..QUIET };
        assert!(missed(fended).is_empty(), "{:?}", missed(fended));
        assert_eq!(missed(QUIET), ["attempts"]);
        assert_eq!(missed_with(fended, 1.06), ["turn_instructions_ratio"]);
        assert_eq!(missed_with(fended, f64::NAN), ["turn_instructions_ratio"]);
        assert_eq!(missed(Round { turn_us: 340.0, ..fended }), ["turn_time_under_attack"]);
        assert_eq!(missed(Round { v_error: 0.07, ..fended }), ["v_error_under_attack"]);
        assert_eq!(missed(Round { lost: 2.0, ..fended }), ["frames_more_lost"]);
        assert_eq!(missed(Round { samples_used: 1.0, ..fended }), ["false_samples_used"]);
        assert_eq!(missed(Round { let_in: 1.0, ..fended }), ["intruders_let_in"]);
    }
}
