//! Outside of the guest: boots it, keeps its log, and judges what the scenarios came to.
//!
//! ```text
//! plans                                   the scenarios, for the guest
//! watch LOG SECONDS COMMAND...            runs an emulator; its lines into LOG, wall times into LOG.times
//! judge [--json] LOG LOG FILM.json GOLDEN the checks; --bless writes GOLDEN anew
//! show LOG                                the facts of one log, judged by nobody
//! sections PROGRAM                        bytes of a program's static memory
//! payloads FILM FRAMES OUT                a film's payloads in a file, for the board
//! ```
//! `hil/run` calls it.

mod judge;
mod log;
mod payloads;
mod report;
mod scenarios;
mod sections;
mod watch;

use std::path::Path;
use std::process::ExitCode;

type Failure = Box<dyn std::error::Error>;

const USAGE: &str = "usage: meniscus-hil-gate plans [soak] | watch LOG SECONDS COMMAND... | show LOG | payloads FILM FRAMES OUT | sections PROGRAM | \
                     judge [--json] [--bless] [--wall=SECONDS] LOG LOG FILM.json GOLDEN [REPORT.json...]";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let done = match words.as_slice() {
        ["plans", rest @ ..] => {
            scenarios::plans(rest.contains(&"soak")).for_each(|plan| println!("{plan}"));
            Ok(true)
        }
        ["watch", log, seconds, command @ ..] if !command.is_empty() => watch::run(log, seconds, command),
        ["show", log] => show(log),
        ["sections", program] => sections::run(program),
        ["payloads", film, frames, out] => payloads::write(film, frames, out),
        ["judge", rest @ ..] => {
            let is = |flag: &str| rest.contains(&flag);
            let files: Vec<&Path> =
                rest.iter().filter(|word| !word.starts_with("--")).map(Path::new).collect();
            match files.as_slice() {
                [first, second, film, golden, with @ ..] => {
                    let wall = rest.iter().find_map(|word| word.strip_prefix("--wall="));
                    let wall_s = wall.and_then(|wall| wall.parse().ok()).unwrap_or(f64::NAN);
                    let wanted = report::Wanted { json: is("--json"), bless: is("--bless"), wall_s, with };
                    report::judge([first, second], film, golden, wanted)
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

fn show(log: &str) -> Result<bool, Failure> {
    let facts = log::Log::read(Path::new(log))?.facts;
    for (plan, facts) in &facts {
        println!("{plan}\n{}", serde_json::to_string_pretty(facts)?);
    }
    Ok(!facts.is_empty())
}
