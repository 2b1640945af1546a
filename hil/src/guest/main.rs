//! Inside the guest: plugs the simulated camera into the kernel, runs the real program on it, and prints what
//! came of it, one JSON object a line. It judges nothing; `meniscus-hil-gate` does, outside.
//!
//! Every time that is printed is the guest's own. Under QEMU's instruction count it is virtual, and two runs
//! print the same bytes.

mod board;
mod facts;
mod kernel;
mod program;
mod scenario;
mod service_scenarios;
mod soak;
mod soak_book;
mod turns;
mod xhci;

use std::path::PathBuf;
use std::process::ExitCode;

/// Begins each line of facts on the console, where the kernel writes too.
const MARK: &str = "HIL ";

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let film = arguments.next().map(PathBuf::from);
    let plans: Vec<String> = arguments.collect();
    if let (Some(film), [word, phase]) = (&film, &plans[..])
        && word == "board"
    {
        return board::run(phase, film);
    }
    if let (Some(_), [word, plans @ ..]) = (&film, &plans[..])
        && word == "xhci"
    {
        return xhci::run(plans);
    }
    let (Some(film), false) = (film, plans.is_empty()) else {
        eprintln!("usage: meniscus-hil-guest FILM SCENARIO...; a scenario is NAME[:TROUBLE[:SECONDS]]");
        eprintln!("       meniscus-hil-guest FILM board install|power-on");
        eprintln!("       meniscus-hil-guest FILM xhci SCENARIO...");
        return ExitCode::FAILURE;
    };
    for plan in plans {
        let facts = scenario::run(&plan, &film).unwrap_or_else(|error| {
            let mut facts = serde_json::Map::new();
            facts.insert("error".into(), error.to_string().into());
            facts
        });
        let facts = serde_json::Value::Object(facts);
        println!("{MARK}{}", serde_json::json!({ "scenario": plan, "facts": facts }));
    }
    ExitCode::SUCCESS
}
