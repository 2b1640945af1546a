//! Prints the definition of the command `meniscus` as JSON: verbs, their flags, and their help texts at 80 columns.
//!
//! `cargo xtask words` reads it.

use clap::Command;
use serde_json::{Value, json};

/// Width of a terminal that every help text has to suit, columns.
const COLUMNS: usize = 80;

fn main() {
    let mut program = meniscus_cli::command().term_width(COLUMNS);
    program.build();
    println!("{}", definition(&mut program));
}

/// Definition of a verb and of the verbs below it.
fn definition(verb: &mut Command) -> Value {
    let long = verb.get_arguments().flat_map(|flag| flag.get_long_and_visible_aliases().unwrap_or_default());
    let short =
        verb.get_arguments().flat_map(|flag| flag.get_short_and_visible_aliases().unwrap_or_default());
    let flags: Vec<String> =
        long.map(|name| format!("--{name}")).chain(short.map(|name| format!("-{name}"))).collect();
    let verbs = verb.get_subcommands_mut().filter(|below| below.get_name() != "help").map(definition);
    let verbs: Vec<Value> = verbs.collect();
    json!({
        "name": verb.get_name(),
        "aliases": verb.get_all_aliases().collect::<Vec<_>>(),
        "flags": flags,
        "help": verb.render_long_help().to_string(),
        "verbs": verbs,
    })
}
