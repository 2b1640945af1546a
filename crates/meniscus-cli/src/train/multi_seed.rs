//! `meniscus train --repeat N`: the same training from N seeds, and what of its figures is chance.

use super::{Arguments, Data, beside, command, hyperparameters, once, write};
use crate::stop::finish;
use meniscus_learn::Trained;
use meniscus_learn::seeds::{markdown, over_seeds};
use meniscus_platform::files::write_whole;
use meniscus_report::checks::table;
use serde_json::{Value, json};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

/// Trains from every seed, each with its checkpoints in a folder of its own; writes the best by the validation
/// recordings and the table of all.
pub(super) fn run(args: &Arguments, data: &Data, folder: &Path, stop: &AtomicBool) -> anyhow::Result<Value> {
    let (mut seeds, mut runs): (Vec<u64>, Vec<Trained>) = Default::default();
    for seed in args.seed..args.seed.saturating_add(args.repeat) {
        if !args.json {
            eprintln!("seed {seed}, {} of {}", runs.len() + 1, args.repeat);
        }
        let trained = once(args, data, seed, &folder.join(format!("seed-{seed}")), stop);
        if stop.load(Ordering::Relaxed) {
            // The checkpoints of every seed stay.
            finish();
        }
        seeds.push(seed);
        runs.push(trained?);
    }
    let best = (0..runs.len()).min_by(|&a, &b| runs[a].slosh_rel.total_cmp(&runs[b].slosh_rel));
    let best = best.ok_or_else(|| anyhow::anyhow!("--repeat 0 trains nothing"))?;
    let picture = write(args, &runs[best])?;
    let all: Vec<_> = runs.iter().map(|run| run.checks.clone()).collect();
    let spreads = over_seeds(&all);
    let place = beside(&args.out, ".md");
    let flag = |given: bool, name: &'static str| if given { name } else { "" };
    let beside_ours = format!("{}{}", flag(args.soft, " --soft"), flag(args.sparse, " --sparse"));
    let test = args.test.as_ref().and_then(|path| path.file_name());
    let test = test.map(|name| format!(" --test {}", name.to_string_lossy())).unwrap_or_default();
    let made_by = format!("{} --repeat {}{beside_ours}{test}", command(args, args.seed), args.repeat);
    write_whole(&place, markdown(&spreads, &seeds, &made_by).as_bytes())?;
    let checks: Vec<_> = spreads.iter().flat_map(|spread| spread.checks()).collect();
    if !args.json {
        println!("seed {}, above, did best on the validation recordings; over the seeds:", seeds[best]);
        print!("{}", table(&checks));
        println!("{}: the table", place.display());
    }
    let by_seed: Vec<_> =
        seeds.iter().zip(&all).map(|(seed, checks)| json!({ "seed": seed, "checks": checks })).collect();
    Ok(json!({
        "bytes": runs[best].blob.len(),
        "curves": picture,
        "table": place,
        "best_seed": seeds[best],
        "checks": checks,
        "seeds": by_seed,
        "stages": runs[best].stages,
        "hyperparameters": hyperparameters(args),
    }))
}
