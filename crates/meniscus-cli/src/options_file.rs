//! `--config FILE.toml`: the options of a verb from a file.
//!
//! A key is the long name of an option, with `_` for `-`; a table is the heading under which the help shows it. So every option that
//! the verb has can stand in the file, with the values that the command line takes:
//! ```toml
//! [images]
//! source = "usb"
//! [publishing]
//! publish = ["udp:192.168.1.5:9000", "unix:/run/meniscus/estimates"]
//! ```
//! The command line goes before the file. A wrong key or value is named with its line.

use clap::error::ErrorKind;
use clap::{Arg, ArgAction, ArgMatches, Command};
use meniscus_platform::files::read_text;
use std::ffi::OsString;
use std::fmt;
use std::path::{Path, PathBuf};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Option that names the file.
const NAME: &str = "config";

/// Options that a file cannot set.
const NOT_HERE: [&str; 3] = [NAME, "help", "version"];

/// Fault of the file: where, and what.
#[derive(Debug)]
pub(crate) struct OptionsFileError {
    path: PathBuf,
    /// Line from 1; `None` for the file as a whole.
    line: Option<usize>,
    what: String,
}

impl fmt::Display for OptionsFileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.path.display())?;
        if let Some(line) = self.line {
            write!(f, ", line {line}")?;
        }
        write!(f, ": {}", self.what)
    }
}

impl std::error::Error for OptionsFileError {}

/// An option as the file has it.
#[derive(Debug, PartialEq)]
struct Given {
    /// Name in the command line.
    long: String,
    line: usize,
    words: Vec<OsString>,
}

/// Returns `matches` with the options of the file that they name, if they name one. `words` are the arguments of the process.
///
/// # Errors
/// [`OptionsFileError`] names key and line.
pub(crate) fn with_file(
    program: &Command,
    matches: ArgMatches,
    words: &[OsString],
) -> Result<ArgMatches, OptionsFileError> {
    let Some((verb, own)) = matches.subcommand() else { return Ok(matches) };
    let named = own.try_get_one::<PathBuf>(NAME).ok().flatten();
    let (Some(path), Some(of)) = (named, program.find_subcommand(verb)) else { return Ok(matches) };
    let given = read(path, of)?;
    let on_command_line = |one: &&Given| {
        let id = of.get_arguments().find(|arg| arg.get_long() == Some(&one.long)).map(Arg::get_id);
        let from = id.and_then(|id| own.value_source(id.as_str()));
        from == Some(clap::parser::ValueSource::CommandLine)
    };
    let ours: Vec<&Given> = given.iter().filter(|one| !on_command_line(one)).collect();
    let parse = |given: &[&Given], rest: &[OsString]| {
        let before = [OsString::from("meniscus"), OsString::from(verb)];
        let of_file = given.iter().flat_map(|one| one.words.iter().cloned());
        program.clone().try_get_matches_from(before.into_iter().chain(of_file).chain(rest.iter().cloned()))
    };
    let rest = words.get(2..).unwrap_or_default();
    parse(&ours, rest).map_err(|error| {
        // Each option alone tells whose value is wrong; what they are to each other, only all of them.
        let of_value = |error: &clap::Error| {
            let kind = error.kind();
            matches!(
                kind,
                ErrorKind::ValueValidation | ErrorKind::InvalidValue | ErrorKind::WrongNumberOfValues
            )
        };
        let alone = ours.iter().find_map(|one| Some((*one, parse(&[*one], &[]).err().filter(of_value)?)));
        let (line, error) = alone.map_or((None, error), |(one, error)| (Some(one.line), error));
        let text = error.to_string();
        let what = text.lines().next().unwrap_or_default().trim_start_matches("error: ").to_owned();
        OptionsFileError { path: path.clone(), line, what }
    })
}

/// Returns the options in the file at `path`, for the verb `of`.
fn read(path: &Path, of: &Command) -> Result<Vec<Given>, OptionsFileError> {
    let fault = |line, what| OptionsFileError { path: path.into(), line, what };
    let text = read_text(path).map_err(|error| fault(None, error.to_string()))?;
    let line_of = |span: std::ops::Range<usize>| text[..span.start.min(text.len())].matches('\n').count() + 1;
    let table = DeTable::parse(&text)
        .map_err(|error| fault(error.span().map(line_of), error.message().to_owned()))?;
    let mut given = Vec::new();
    for (heading, group) in table.get_ref() {
        let line = Some(line_of(heading.span()));
        let name = heading.get_ref();
        let known = headings(of);
        if !known.contains(&name.to_string()) {
            let what = format!("there is no group '{name}'; the groups are {}", known.join(", "));
            return Err(fault(line, what));
        }
        let DeValue::Table(group) = group.get_ref() else {
            return Err(fault(line, format!("'{name}' is a group of options: write [{name}]")));
        };
        for (key, value) in group {
            let line = line_of(key.span());
            let one = option(of, name, key.get_ref(), value).map_err(|what| fault(Some(line), what))?;
            given.push(Given { line, ..one });
        }
    }
    Ok(given)
}

/// Name of the group of an option in the file: its heading in the help.
fn group_of(arg: &Arg) -> String {
    arg.get_help_heading().unwrap_or("options").to_lowercase().replace(' ', "_")
}

/// Options of `of` that a file can set.
fn settable(of: &Command) -> impl Iterator<Item = &Arg> {
    of.get_arguments().filter(|arg| arg.get_long().is_some_and(|long| !NOT_HERE.contains(&long)))
}

/// Groups of `of`, in the order of the help.
fn headings(of: &Command) -> Vec<String> {
    let mut all: Vec<String> = Vec::new();
    for arg in settable(of) {
        let group = group_of(arg);
        if !all.contains(&group) {
            all.push(group);
        }
    }
    all
}

/// Returns the option `key` of the group `group` with its value, as words of a command line.
fn option(of: &Command, group: &str, key: &str, value: &Spanned<DeValue<'_>>) -> Result<Given, String> {
    let long = key.replace('_', "-");
    let Some(arg) = settable(of).find(|arg| arg.get_long() == Some(&long)) else {
        let near: Vec<String> = settable(of)
            .filter(|arg| group_of(arg) == group)
            .filter_map(|arg| Some(arg.get_long()?.replace('-', "_")))
            .collect();
        return Err(format!("there is no option '{key}' in [{group}]; there are {}", near.join(", ")));
    };
    if group_of(arg) != group {
        return Err(format!("'{key}' belongs to [{}]", group_of(arg)));
    }
    let flag = matches!(arg.get_action(), ArgAction::SetTrue);
    let optional = arg.get_num_args().is_some_and(|number| number.min_values() == 0);
    let words = match value.get_ref() {
        DeValue::Boolean(on) if flag || optional => on.then(|| format!("--{long}")).into_iter().collect(),
        _ if flag => return Err(format!("'{key}' is true or false")),
        DeValue::Array(all) if matches!(arg.get_action(), ArgAction::Append) => all
            .iter()
            .map(|one| Ok(format!("--{long}={}", word(one)?)))
            .collect::<Result<Vec<_>, String>>()?,
        _ => vec![format!("--{long}={}", word(value)?)],
    };
    Ok(Given { long, line: 0, words: words.into_iter().map(OsString::from).collect() })
}

/// A value as the command line takes it.
fn word(value: &Spanned<DeValue<'_>>) -> Result<String, String> {
    match value.get_ref() {
        DeValue::String(text) => Ok(text.to_string()),
        DeValue::Integer(number) => Ok(number.to_string()),
        DeValue::Float(number) => Ok(number.to_string()),
        other => Err(format!("expected a text or a number, not {}", other.type_str())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command;

    /// Options of `meniscus run --config FILE ARGUMENTS` with a file of this `text`.
    fn run(name: &str, text: &str, arguments: &[&str]) -> Result<ArgMatches, String> {
        let file = std::env::temp_dir().join(format!("meniscus-options-{}-{name}.toml", std::process::id()));
        std::fs::write(&file, text).expect("written");
        let words: Vec<OsString> = ["meniscus", "run", "--config"]
            .map(OsString::from)
            .into_iter()
            .chain([file.clone().into()])
            .chain(arguments.iter().map(OsString::from))
            .collect();
        let program = command();
        let matches = program.clone().try_get_matches_from(&words).expect("a command line");
        let done = with_file(&program, matches, &words).map_err(|error| error.to_string());
        std::fs::remove_file(&file).expect("removed");
        done
    }

    #[test]
    fn every_option_of_the_verb_can_stand_in_the_file() {
        let text = "[images]\nsource = \"usb\"\nseed = 3\n[publishing]\nfield_hz = 2.5\n\
                    publish = [\"udp:127.0.0.1:9000\", \"unix:/tmp/x\"]\n[time]\nservice = true\npatient = false\n";
        let matches = run("whole", text, &["--seed", "4", "--json"]).expect("good");
        let (_, own) = matches.subcommand().expect("run");
        assert_eq!(own.get_one::<PathBuf>("source").expect("given"), Path::new("usb"));
        assert_eq!(
            own.get_many::<meniscus_service::publish::Destination>("publish").expect("given").len(),
            2
        );
        assert_eq!(own.get_one::<f64>("field_hz"), Some(&2.5));
        assert!(own.get_flag("service") && own.get_flag("json") && !own.get_flag("patient"));
        assert_eq!(own.get_one::<u64>("seed"), Some(&4), "the command line goes before the file");
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line() {
        for (name, text, words) in [
            ("key", "[images]\nsource = \"usb\"\nsetpu = \"x\"\n", &["line 3", "'setpu'", "setup"][..]),
            ("group", "\n[camera]\nsource = \"usb\"\n", &["line 2", "'camera'", "images"]),
            ("place", "[time]\nsource = \"usb\"\n", &["line 2", "'source' belongs to [images]"]),
            ("value", "[publishing]\npublish = [\"udp:nowhere\"]\n", &["line 2", "udp:nowhere"]),
            ("flag", "[time]\nservice = \"yes\"\n", &["line 2", "true or false"]),
            ("kind", "[images]\nseed = 1979-05-27\n", &["line 2", "a text or a number"]),
            ("top", "source = \"usb\"\n", &["line 1", "'source'", "groups"]),
            ("toml", "[images\nsource = 1\n", &["line 1"]),
            ("both", "[time]\nservice = true\nseconds = 3\n", &["--service", "cannot be used with"]),
            ("itself", "[configuration]\nconfig = \"x\"\n", &["line 1", "configuration"]),
        ] {
            let why = run(name, text, &[]).expect_err(name);
            assert!(words.iter().all(|word| why.contains(word)), "{name}: {why}");
        }
    }
}
