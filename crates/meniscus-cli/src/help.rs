//! Layout of the help texts: verbs by what they are for, examples behind the first paragraph.

use clap::Command;
use clap::builder::Resettable;
use std::fmt::Write;

/// Groups of the verbs, in the order in which `meniscus --help` shows them.
const GROUPS: [(&str, &[&str]); 7] = [
    ("Start here", &["run", "doctor"]),
    ("Your camera", &["setup", "record", "dump"]),
    ("Your liquid", &["learn", "simulate", "train", "correct", "recognise", "insert"]),
    ("Your data", &["discover", "render", "export", "generic"]),
    ("Your robot", &["plan", "tag"]),
    ("Your board", &["flash", "service", "quantize"]),
    ("Studies", &["evaluate", "sweep", "bench", "deadline", "camera", "people"]),
];

/// Other verbs.
const REST: (&str, &[&str]) = ("More", &["manual", "help"]);

/// Three commands to begin with, and what each does.
const EXAMPLES: [(&str, &str); 3] = [
    ("meniscus run --view", "watch a simulated glass in the browser"),
    ("meniscus doctor", "check your camera and this machine"),
    ("meniscus run --source usb", "watch the glass before a RealSense D435"),
];

/// Answer to `meniscus` without arguments.
pub(super) fn start() -> String {
    let mut text = String::from("meniscus needs a verb. Start with one of these:\n");
    examples(&mut text);
    text + "\n`meniscus --help` lists all verbs, `meniscus VERB --help` explains one.\n"
}

/// Returns the command line with its help laid out.
pub(super) fn laid_out(program: Command) -> Command {
    let template = top(&program);
    program.mut_subcommands(verb).help_template(template)
}

/// Moves the examples of a verb behind the first paragraph of its help; negative numbers are values, not flags.
fn verb(command: Command) -> Command {
    let text =
        |styled: Option<&clap::builder::StyledStr>| styled.map(ToString::to_string).unwrap_or_default();
    let examples = text(command.get_after_help());
    let about = text(command.get_long_about().or(command.get_about()));
    let command = command.mut_subcommands(verb).allow_negative_numbers(true);
    if examples.is_empty() {
        return command;
    }
    let (first, rest) = about.split_once("\n\n").unwrap_or((&about, ""));
    let long = format!("{first}\n\n{examples}\n\n{rest}");
    command.long_about(long.trim_end().to_owned()).after_help(Resettable::Reset)
}

/// Template of `meniscus --help`.
fn top(program: &Command) -> String {
    let mut text = String::from("{about-with-newline}\n{usage-heading} {usage}\n\nExamples:\n");
    examples(&mut text);
    for (title, verbs) in GROUPS.iter().chain([&REST]) {
        text += &format!("\n{title}:\n");
        for name in *verbs {
            let known = program.get_subcommands().find(|command| command.get_name() == *name);
            let about = known.and_then(Command::get_about).map(ToString::to_string);
            let about = about.unwrap_or_else(|| String::from("Print the help of a verb"));
            // A `String` takes every line.
            let _written = writeln!(text, "  {name:10} {about}");
        }
    }
    text + "\nOptions:\n{options}\n\n`meniscus VERB --help` explains a verb and shows examples."
}

/// Appends the three examples, one a line.
fn examples(text: &mut String) {
    for (command, what) in EXAMPLES {
        // A `String` takes every line.
        let _written = writeln!(text, "  {command:26} {what}");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_verb_is_in_one_group() {
        let program = crate::command();
        let mut listed: Vec<&str> =
            GROUPS.iter().chain([&REST]).flat_map(|(_, verbs)| verbs.iter().copied()).collect();
        listed.sort_unstable();
        let mut verbs: Vec<&str> = program.get_subcommands().map(Command::get_name).chain(["help"]).collect();
        verbs.sort_unstable();
        verbs.dedup();
        assert_eq!(listed, verbs);
    }

    /// Every command below `command`, itself first.
    #[cfg(all(feature = "train", feature = "studies"))]
    fn all(command: &Command) -> Vec<&Command> {
        let below = command.get_subcommands().filter(|verb| verb.get_name() != "help").flat_map(all);
        std::iter::once(command).chain(below).collect()
    }

    /// Text that is wrapped by hand is wrapped again by a narrow terminal, and leaves single words on lines.
    #[cfg(all(feature = "train", feature = "studies"))]
    #[test]
    fn help_fits_80_columns_and_has_examples() {
        let mut program = crate::command().term_width(80);
        program.build();
        for command in all(&program) {
            let name = command.get_bin_name().unwrap_or_default().to_owned();
            let about = command.get_about().map(ToString::to_string).unwrap_or_default();
            assert!(
                name == "meniscus" || about.chars().count() <= 66,
                "{name}: the first line is long: {about}"
            );
            let long = command.clone().render_long_help().to_string();
            for line in long.lines().filter(|line| !line.contains("Usage:") && !line.contains("[aliases")) {
                assert!(line.chars().count() <= 80, "{name}: {line}");
            }
            let has_verbs = command.get_subcommands().any(|verb| verb.get_name() != "help");
            assert!(has_verbs || long.contains("Example"), "{name} has no example");
            let texts = command
                .get_arguments()
                .filter_map(|argument| argument.get_long_help().or(argument.get_help()));
            let texts =
                texts.map(ToString::to_string).chain(command.get_long_about().map(ToString::to_string));
            for text in texts {
                let flowing = |pair: &[&str]| {
                    let words = |line: &str| {
                        line.starts_with(|first: char| !first.is_whitespace()) && !line.ends_with(':')
                    };
                    words(pair[0]) && words(pair[1])
                };
                let lines: Vec<&str> = text.lines().collect();
                assert!(!lines.windows(2).any(flowing), "{name}: wrapped by hand: {text}");
            }
        }
    }

    #[test]
    fn the_first_thing_that_is_shown_says_where_to_start() {
        let (help, start) = (crate::command().render_long_help().to_string(), start());
        for text in [&help, &start] {
            assert!(EXAMPLES.iter().all(|(command, _)| text.contains(command)), "{text}");
        }
        assert!(help.find("Start here").is_some_and(|at| at < help.find("Studies").unwrap_or(0)), "{help}");
    }
}
