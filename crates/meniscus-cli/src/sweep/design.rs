//! Design of a sweep: a command with names in braces, and the values of the names.

use anyhow::{Context, bail, ensure};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use toml::{Table, Value};

/// Name that stands for the folder of a part.
pub(super) const OUT: &str = "out";

/// Most parts of a sweep.
const MOST_PARTS: usize = 100_000;

/// Values of a part by name, as they go into the command.
pub(super) type Values = BTreeMap<String, String>;

/// Design of a sweep.
pub(super) struct Design {
    /// File that it was read from.
    pub(super) path: PathBuf,
    /// Words of the command, with names in braces.
    pub(super) words: Vec<String>,
    /// Values of each part.
    pub(super) parts: Vec<Values>,
    /// Checks that are not merged.
    pub(super) leave_out: Vec<String>,
    /// Whether the command continues what it finds in its folder.
    pub(super) resumes: bool,
}

impl Design {
    /// Reads the design in the file `path`.
    pub(super) fn read(path: &Path) -> anyhow::Result<Self> {
        let text = std::fs::read_to_string(path).with_context(|| {
            format!(
                "{} cannot be read: name a design, as `meniscus sweep make --help` shows it",
                path.display()
            )
        })?;
        Self::parse(path, &text).with_context(|| format!("{} is no design", path.display()))
    }

    fn parse(path: &Path, text: &str) -> anyhow::Result<Self> {
        let mut table: Table =
            text.parse().map_err(|error: toml::de::Error| anyhow::anyhow!("{}", error.to_string().trim()))?;
        let words = match table.remove("command") {
            Some(Value::String(line)) => line.split_whitespace().map(str::to_owned).collect(),
            Some(Value::Array(words)) => {
                words.iter().map(|word| text_of("command", word)).collect::<Result<_, _>>()?
            }
            _ => bail!("it has no `command`: write command = \"simulate --liquid {{liquid}} ...\""),
        };
        let leave_out = match table.remove("leave_out") {
            None => Vec::new(),
            Some(Value::Array(names)) => {
                names.iter().map(|name| text_of("leave_out", name)).collect::<Result<_, _>>()?
            }
            Some(_) => bail!("`leave_out` is a list of names of checks"),
        };
        let resumes = match table.remove("resumes") {
            None => false,
            Some(Value::Boolean(resumes)) => resumes,
            Some(_) => bail!("`resumes` is true or false"),
        };
        let parts = match (table.remove("vary"), table.remove("part")) {
            (Some(Value::Table(vary)), None) => product(&vary)?,
            (None, Some(Value::Array(parts))) => parts.iter().map(one).collect::<Result<_, _>>()?,
            (Some(_), Some(_)) => bail!("it has `vary` and `part`: give one of them"),
            _ => bail!(
                "it has no values: write a table [vary] with a list for each name, or a [[part]] for each part"
            ),
        };
        if let Some(other) = table.keys().next() {
            bail!("`{other}` is not known: a design has command, vary or part, leave_out and resumes");
        }
        let design = Self { path: path.into(), words, parts, leave_out, resumes };
        design.check_names()?;
        Ok(design)
    }

    /// Every name of the command has a value in every part, and every value a place in the command.
    fn check_names(&self) -> anyhow::Result<()> {
        ensure!(!self.parts.is_empty(), "it has no parts: a list of values is empty");
        let line = self.words.join(" ");
        for (number, values) in self.parts.iter().enumerate() {
            let number = number + 1;
            ensure!(!values.contains_key(OUT), "`{OUT}` is the folder of a part and takes no values");
            if let Some(unused) = values.keys().find(|name| !line.contains(&format!("{{{name}}}"))) {
                bail!(
                    "`{unused}` of part {number} stands nowhere in the command: write {{{unused}}} where it belongs"
                );
            }
            for word in &self.words {
                filled(word, values, OUT).with_context(|| format!("part {number}"))?;
            }
        }
        Ok(())
    }

    /// The words of the command for `values`, with `out` as the folder of the part.
    pub(super) fn command(&self, values: &Values, out: &str) -> anyhow::Result<Vec<String>> {
        self.words.iter().map(|word| filled(word, values, out)).collect()
    }
}

/// Puts the values in the place of the names in `word`.
pub(super) fn filled(word: &str, values: &Values, out: &str) -> anyhow::Result<String> {
    let mut text = String::new();
    let mut rest = word;
    while let Some((before, after)) = rest.split_once('{') {
        let (name, behind) =
            after.split_once('}').with_context(|| format!("'{word}' has a brace without its end"))?;
        let value = if name == OUT { Some(out) } else { values.get(name).map(String::as_str) };
        text += before;
        text += value.with_context(|| format!("{{{name}}} in '{word}' has no value"))?;
        rest = behind;
    }
    Ok(text + rest)
}

/// All combinations of the lists of `vary`, by name; the last name changes first.
fn product(vary: &Table) -> anyhow::Result<Vec<Values>> {
    let mut parts = vec![Values::new()];
    for (name, list) in vary {
        let Value::Array(list) = list else {
            bail!("`{name}` of [vary] is no list: write {name} = [1, 2, 3]")
        };
        let list: Vec<String> = list.iter().map(|value| text_of(name, value)).collect::<Result<_, _>>()?;
        ensure!(
            parts.len() * list.len() <= MOST_PARTS,
            "it has more than {MOST_PARTS} parts: make several sweeps"
        );
        let with = |values: &Values, value: &String| {
            let mut values = values.clone();
            values.insert(name.clone(), value.clone());
            values
        };
        parts = parts.iter().flat_map(|values| list.iter().map(move |value| with(values, value))).collect();
    }
    Ok(parts)
}

/// The values of one `[[part]]`.
fn one(part: &Value) -> anyhow::Result<Values> {
    let Value::Table(part) = part else { bail!("`part` is a list of tables: write [[part]]") };
    part.iter().map(|(name, value)| Ok((name.clone(), text_of(name, value)?))).collect()
}

/// A value as a word of the command.
fn text_of(name: &str, value: &Value) -> anyhow::Result<String> {
    Ok(match value {
        Value::String(text) => text.clone(),
        Value::Integer(number) => number.to_string(),
        Value::Float(number) => number.to_string(),
        Value::Boolean(yes) => yes.to_string(),
        other => bail!("`{name}` holds {}, which is no text and no number", other.type_str()),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn design(text: &str) -> anyhow::Result<Design> {
        Design::parse(Path::new("design.toml"), text)
    }

    #[test]
    fn every_combination_is_a_part_and_the_last_name_changes_first() {
        let text = "command = 'simulate --liquid {liquid} --motion strokes:{seed} --out {out}/x'\n\
                    [vary]\nliquid = ['water', 'honey']\nseed = [1, 2]";
        let design = design(text).expect("a design");
        let line = |part: &Values| design.command(part, "d").expect("a command").join(" ");
        let lines: Vec<String> = design.parts.iter().map(line).collect();
        assert_eq!(lines.len(), 4);
        assert_eq!(lines[1], "simulate --liquid water --motion strokes:2 --out d/x");
        assert_eq!(lines[2], "simulate --liquid honey --motion strokes:1 --out d/x");
    }

    #[test]
    fn parts_may_be_named_one_by_one_and_words_may_have_spaces() {
        let text = "command = ['simulate', '--out', '{out}/a {name}']\nresumes = true\n[[part]]\nname = 1.5";
        let design = design(text).expect("a design");
        assert!(design.resumes);
        assert_eq!(design.command(&design.parts[0], "d").expect("a command")[2], "d/a 1.5");
    }

    #[test]
    fn faults_are_named() {
        for (text, word) in [
            ("[vary]\nx = [1]", "no `command`"),
            ("command = 'a {x}'", "no values"),
            ("command = 'a {x}'\n[vary]\nx = 3", "is no list"),
            ("command = 'a {x}'\n[vary]\nx = []", "no parts"),
            ("command = 'a {y}'\n[vary]\nx = [1]", "`x` of part 1 stands nowhere"),
            ("command = 'a {x} {y}'\n[vary]\nx = [1]", "{y}"),
            ("command = 'a {x'\n[vary]\nx = [1]", "x"),
            ("command = 'a {x}'\nspeed = 1\n[vary]\nx = [1]", "`speed` is not known"),
            ("command = 'a {out}'\n[vary]\nout = [1]", "folder of a part"),
            ("command = ", "line 1"),
        ] {
            let fault = format!("{:#}", design(text).err().unwrap_or_else(|| panic!("{text} is refused")));
            assert!(fault.contains(word), "`{word}` is missing in: {fault}");
        }
    }
}
