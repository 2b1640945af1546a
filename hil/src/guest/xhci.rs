//! Scenarios with a camera outside of the guest, behind QEMU's host controller: the console requests the plug.

use super::program;
use super::{MARK, facts, kernel};
use serde_json::json;
use std::process::ExitCode;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Longest time for the camera to come, and to go.
const LIMIT: Duration = Duration::from_secs(60);

/// Runs the plans, each with a camera of its own.
pub(crate) fn run(plans: &[String]) -> ExitCode {
    for plan in plans {
        println!("HIL-PLUG {plan}");
        let found = kernel::wait_for_camera(LIMIT);
        let seconds = plan.split(':').nth(2).and_then(|word| word.parse().ok()).unwrap_or(4.0);
        let mut arguments = program::arguments(seconds, &[]);
        // The surface alone: a guest without virtual time is slow enough.
        arguments.extend(["--fields", "none"].map(str::to_owned));
        let mut facts = match program::run(&arguments) {
            Ok(ran) => facts::of(&ran),
            Err(error) => [("error".to_owned(), error.to_string().into())].into_iter().collect(),
        };
        println!("HIL-UNPLUG");
        let begun = Instant::now();
        while kernel::wait_for_camera(Duration::from_millis(1)).is_some() && begun.elapsed() < LIMIT {
            sleep(Duration::from_millis(100));
        }
        if let Some((enumerated, _)) = found {
            facts.insert("enumerated".into(), enumerated.json());
        }
        facts.insert("kernel_complaints".into(), kernel::complaints().into());
        println!("{MARK}{}", json!({ "scenario": plan, "facts": facts }));
    }
    ExitCode::SUCCESS
}
