//! Outside of the guest: boots it, keeps its log, and judges what the scenarios came to.
//!
//! ```text
//! plans                                   the scenarios, for the guest
//! soak [--json] LOG                       the checks of a soak
//! watch LOG SECONDS COMMAND...            runs an emulator; its lines into LOG, wall times into LOG.times
//! judge [--json] --first=LOG [--second=LOG] FILM.json GOLDEN
//!                                         the checks; --bless writes GOLDEN anew
//! board [--json] INSTALL.log POWER-ON.log  the same for the edge board's two boots
//! show LOG                                the facts of one log, judged by nobody
//! xhci-plans, xhci-watch, xhci            the same for the rig with QEMU's host controller
//! sibling BLOB OUT                        another model than the shipped one
//! sections PROGRAM                        bytes of a program's static memory
//! payloads FILM FRAMES OUT                a film's payloads in a file, for the board
//! ```
//! `hil/run` calls it.

mod checks;
mod edge;
mod judge;
mod log;
mod payloads;
mod report;
mod scenarios;
mod sections;
mod sibling;
mod soak;
mod watch;
mod xhci;

use std::path::Path;
use std::process::ExitCode;

type Failure = Box<dyn std::error::Error>;

const USAGE: &str = "usage: meniscus-hil-gate plans | soak [--json] [--wall=SECONDS] LOG | watch LOG SECONDS COMMAND... | show LOG | payloads FILM FRAMES OUT | sections PROGRAM | sibling BLOB OUT | xhci-plans | \
                     xhci-watch LOG SECONDS SOCKET FILM COMMAND... | xhci [--json] [--wall=SECONDS] LOG | \
                     board [--json] [--wall=SECONDS] LOG LOG | judge [--json] [--bless] [--wall=SECONDS] --first=LOG [--second=LOG] FILM.json GOLDEN [REPORT.json...]";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let done = match words.as_slice() {
        ["plans"] => {
            scenarios::GATE.iter().for_each(|scenario| println!("{}", scenario.plan));
            Ok(true)
        }
        ["soak", rest @ ..] => match rest.iter().find(|word| !word.starts_with("--")) {
            Some(log) => soak::judge(Path::new(log), rest.contains(&"--json"), wall_s(rest)),
            None => Err(USAGE.into()),
        },
        ["watch", log, seconds, command @ ..] if !command.is_empty() => watch::run(log, seconds, command),
        ["show", log] => show(log),
        ["xhci-plans"] => {
            xhci::PLANS.iter().for_each(|plan| println!("{plan}"));
            Ok(true)
        }
        ["xhci-watch", log, seconds, socket, film, command @ ..] => {
            xhci::run(log, seconds, socket, film, command)
        }
        ["xhci", rest @ ..] => match rest.iter().find(|word| !word.starts_with("--")) {
            Some(log) => xhci::judge(Path::new(log), rest.contains(&"--json"), wall_s(rest)),
            None => Err(USAGE.into()),
        },
        ["sibling", blob, out] => sibling::write(blob, out),
        ["sections", program] => sections::run(program),
        ["payloads", film, frames, out] => payloads::write(film, frames, out),
        ["board", rest @ ..] => {
            let files: Vec<&Path> =
                rest.iter().filter(|word| !word.starts_with("--")).map(Path::new).collect();
            match files.as_slice() {
                [install, power_on] => {
                    edge::judge([install, power_on], rest.contains(&"--json"), wall_s(rest))
                }
                _ => Err(USAGE.into()),
            }
        }
        ["judge", rest @ ..] => {
            let is = |flag: &str| rest.contains(&flag);
            let files: Vec<&Path> =
                rest.iter().filter(|word| !word.starts_with("--")).map(Path::new).collect();
            match files.as_slice() {
                [film, golden, with @ ..] => {
                    let (json, bless) = (is("--json"), is("--bless"));
                    let wanted = report::Wanted { json, bless, wall_s: wall_s(rest), with };
                    let log = |name| rest.iter().find_map(|word| word.strip_prefix(name)).map(Path::new);
                    match log("--first=") {
                        Some(first) => report::judge(
                            report::Boots { first, second: log("--second=") },
                            film,
                            golden,
                            wanted,
                        ),
                        None => Err(USAGE.into()),
                    }
                }
                _ => Err(USAGE.into()),
            }
        }
        _ => Err(USAGE.into()),
    };
    match done {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}

/// Returns the wall time of everything before, seconds.
fn wall_s(words: &[&str]) -> f64 {
    let wall = words.iter().find_map(|word| word.strip_prefix("--wall="));
    wall.and_then(|wall| wall.parse().ok()).unwrap_or(f64::NAN)
}

fn show(log: &str) -> Result<bool, Failure> {
    let facts = log::Log::read(Path::new(log))?.facts;
    for (plan, facts) in &facts {
        println!("{plan}\n{}", serde_json::to_string_pretty(facts)?);
    }
    Ok(!facts.is_empty())
}
