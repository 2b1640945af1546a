//! The book is held to its word: links lead somewhere, pictures have their command, commands have their flags.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
}

/// README.md and every page below docs/.
fn pages() -> Vec<(PathBuf, String)> {
    let mut paths = vec![root().join("README.md")];
    paths.extend(
        below(&root().join("docs")).into_iter().filter(|path| path.extension().is_some_and(|e| e == "md")),
    );
    let read = |path: PathBuf| {
        let text = fs::read_to_string(&path).expect("a page");
        (path, text)
    };
    paths.into_iter().map(read).collect()
}

/// Every file below a folder, in order.
fn below(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).expect("a folder").flatten() {
        let path = entry.path();
        if path.is_dir() { files.extend(below(&path)) } else { files.push(path) }
    }
    files.sort();
    files
}

/// Lines of a page with whether they are inside of a fence, and the fence's language.
fn lines(text: &str) -> Vec<(&str, Option<&str>)> {
    let mut fence = None;
    let mut all = Vec::new();
    for line in text.lines() {
        match (line.trim_start().strip_prefix("```"), fence) {
            (Some(language), None) => fence = Some(language.trim()),
            (Some(_), Some(_)) => fence = None,
            (None, _) => all.push((line, fence)),
        }
    }
    all
}

/// Targets of the links in a page, outside of fences.
fn links(text: &str) -> Vec<String> {
    let prose: Vec<&str> =
        lines(text).into_iter().filter(|(_, fence)| fence.is_none()).map(|(line, _)| line).collect();
    let prose = prose.join("\n");
    let targets = prose.match_indices("](").filter_map(|(at, _)| prose[at + 2..].split(')').next());
    targets.map(str::to_owned).collect()
}

/// Returns the path behind a relative link; `None` for another link.
fn target<'l>(page: &Path, link: &'l str) -> Option<(PathBuf, &'l str)> {
    let elsewhere = ["http://", "https://", "mailto:", "#"].iter().any(|start| link.starts_with(start));
    let path = link.split('#').next().unwrap_or(link);
    (!elsewhere).then(|| (page.parent().expect("a folder").join(path), link))
}

/// Commands of a page: the lines of its `sh` fences, continued ones joined, and what stands between backticks.
fn commands(text: &str) -> Vec<String> {
    let mut all = Vec::new();
    let mut joined = String::new();
    for (line, fence) in lines(text) {
        if fence.is_some_and(|language| language == "sh") {
            joined += line.trim_end().trim_end_matches('\\');
            if !line.trim_end().ends_with('\\') {
                all.push(std::mem::take(&mut joined));
            }
        } else if fence.is_none() {
            all.extend(line.split('`').skip(1).step_by(2).map(str::to_owned));
        }
    }
    let parts = |line: &String| -> Vec<String> {
        let code = line.split(" #").next().unwrap_or("");
        let ends = |c| matches!(c, ';' | '|' | '&' | '$' | '(' | ')');
        code.split(ends).map(|part| part.trim().to_owned()).collect()
    };
    all.iter().flat_map(parts).collect()
}

/// The words behind `meniscus` in a command, if it is one.
fn words(command: &str) -> Option<Vec<&str>> {
    let assignment = |word: &&str| word.contains('=') && !word.starts_with('-');
    let mut words = command.split_whitespace().skip_while(assignment);
    let first = words.next()?;
    let is_cargo = first == "cargo" && words.next()? == "run";
    // An example is a program of its own.
    if is_cargo && command.contains(" --example ") {
        return None;
    }
    if is_cargo {
        return Some(words.skip_while(|word| *word != "--").skip(1).collect());
    }
    let is_ours = first == "meniscus" || first.ends_with("/meniscus");
    is_ours.then(|| words.collect())
}

/// Whether a command makes something: one of ours, or a test that draws.
fn makes(command: &str) -> bool {
    let by_program = words(command).is_some_and(|words| !words.is_empty());
    by_program || command.contains("_PICTURE=") || command.contains("--example stages")
}

/// Help texts of verbs, from `meniscus ... --help`.
struct Helps(BTreeMap<Vec<String>, Option<String>>);

impl Helps {
    fn of(&mut self, verbs: &[&str]) -> Option<&str> {
        let key: Vec<String> = verbs.iter().map(|verb| (*verb).to_owned()).collect();
        let ask = || {
            let output = Command::new(env!("CARGO_BIN_EXE_meniscus-under-test"))
                .args(verbs)
                .arg("--help")
                .output()
                .expect("it starts");
            output.status.success().then(|| String::from_utf8_lossy(&output.stdout).into_owned())
        };
        self.0.entry(key).or_insert_with(ask).as_deref()
    }

    /// Returns the fault of a command, if it has one.
    fn wrong(&mut self, words: &[&str]) -> Option<String> {
        let verb = words.first().filter(|word| !word.starts_with('-'))?;
        let Some(help) = self.of(&[verb]).map(str::to_owned) else {
            return Some(format!("there is no verb '{verb}'"));
        };
        // A second verb, as in `camera study`: if the help of the first one lists it.
        let listed = |word: &&&str| help.lines().any(|line| line.starts_with(&format!("  {word} ")));
        let second =
            words.get(1).filter(|word| word.starts_with(|c: char| c.is_ascii_lowercase())).filter(listed);
        let help = match second {
            Some(second) => self.of(&[verb, second]).unwrap_or_default().to_owned(),
            None => help,
        };
        let known: BTreeSet<&str> = help.split(|c: char| !(c.is_ascii_alphanumeric() || c == '-')).collect();
        let flags = words.iter().filter(|word| word.starts_with("--") && word.len() > 2);
        let unknown =
            flags.map(|word| word.split('=').next().unwrap_or(word)).find(|flag| !known.contains(flag))?;
        Some(format!("'meniscus {verb}' has no {unknown}"))
    }
}

#[test]
fn every_link_leads_somewhere() {
    let mut dead = Vec::new();
    for (page, text) in pages() {
        let all = links(&text);
        let missing = all.iter().filter_map(|link| target(&page, link)).filter(|(path, _)| !path.exists());
        dead.extend(missing.map(|(_, link)| format!("{}: {link}", page.display())));
    }
    assert!(dead.is_empty(), "{dead:#?}");
}

/// Paths of sources between backticks, from the root of the repository.
fn sources(text: &str) -> Vec<&str> {
    let spans = text.split('`').skip(1).step_by(2);
    let starts = [
        "src/",
        "crates/",
        "tests/",
        "benches/",
        "examples/",
        "hil/",
        "firmware-config/",
        "liquids/",
        "models/",
    ];
    spans
        .filter(|span| starts.iter().any(|start| span.starts_with(start)) && !span.contains([' ', '*', '{']))
        .collect()
}

#[test]
fn every_source_that_a_page_names_exists() {
    let mut gone = Vec::new();
    let mut all = pages();
    for name in ["ARCHITECTURE.md", "CONTRIBUTING.md", "firmware-config/SPEC.md"] {
        let path = root().join(name);
        let text = fs::read_to_string(&path).expect(name);
        all.push((path, text));
    }
    for (page, text) in &all {
        // The table of crates names files below their crate: `cargo xtask house` knows those crates.
        let in_a_crate = |source: &str| source.starts_with("src/") && page.ends_with("ARCHITECTURE.md");
        let there = |source: &str| in_a_crate(source) || root().join(source).exists();
        let missing = sources(text).into_iter().filter(|source| !there(source));
        gone.extend(missing.map(|source| format!("{}: {source}", page.display())));
    }
    assert!(gone.is_empty(), "{gone:#?}");
    assert_eq!(sources("`src/a.rs` `meniscus run` `crates/b c`"), ["src/a.rs"]);
}

#[test]
fn every_picture_has_a_page_that_names_the_command_that_makes_it() {
    let mut bare = Vec::new();
    let docs = root().join("docs").canonicalize().expect("the book");
    let pictures = below(&docs).into_iter().filter(|path| {
        path.extension().is_some_and(|e| ["png", "svg", "gif", "jpg"].iter().any(|kind| e == *kind))
    });
    for picture in pictures {
        let named = pages().iter().any(|(page, text)| {
            let all = links(text);
            let shown = all.iter().filter_map(|link| target(page, link));
            let shows = shown.filter_map(|(path, _)| path.canonicalize().ok()).any(|path| path == picture);
            shows && commands(text).iter().any(|command| makes(command))
        });
        if !named {
            bare.push(picture);
        }
    }
    assert!(bare.is_empty(), "no page shows these and names their command: {bare:#?}");
}

#[test]
fn every_command_has_its_verb_and_its_flags() {
    let mut helps = Helps(BTreeMap::new());
    let (mut wrong, mut count) = (Vec::new(), 0);
    for (page, text) in pages() {
        for command in commands(&text) {
            let Some(words) = words(&command) else { continue };
            count += 1;
            if let Some(what) = helps.wrong(&words) {
                wrong.push(format!("{}: `{command}`: {what}", page.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert!(count > 40, "only {count} commands were found");
}

/// Returns the command behind the alias `cargo view`.
fn alias(config: &str) -> Option<&str> {
    config.lines().find_map(|line| line.strip_prefix("view = \"")?.strip_suffix('"'))
}

#[test]
fn the_short_way_is_shown_and_is_a_command_of_this_program() {
    let read = |path: &str| fs::read_to_string(root().join(path)).expect("a file");
    for page in ["README.md", "docs/page.md"] {
        assert!(commands(&read(page)).iter().any(|command| command == "cargo view"), "{page}");
    }
    assert!(
        read("crates/meniscus-cli/src/people/clean_clone.rs")
            .contains("const COMMAND: &str = \"cargo view\";")
    );
    let config = read(".cargo/config.toml");
    let command = format!("cargo {}", alias(&config).expect("the alias"));
    let words = words(&command).expect("a command of this program");
    assert_eq!(words, ["run", "--view"]);
    assert_eq!(Helps(BTreeMap::new()).wrong(&words), None);
    assert_eq!(alias("[alias]\nviews = \"run\"\n"), None);
}

#[test]
fn the_checks_can_fail() {
    let page = Path::new("docs/page.md");
    let text = "[a](b.md) ![c](d/e.png#f) [g](https://h.i)\n```sh\n[j](k)\nmeniscus run --view \\\n  --seconds 3 # --no\n```\n";
    assert_eq!(links(text), ["b.md", "d/e.png#f", "https://h.i"]);
    let of = |link| target(page, link).map(|(path, _)| path);
    assert_eq!(of("d/e.png#f"), Some(PathBuf::from("docs/d/e.png")));
    assert_eq!(of("https://h.i"), None);
    let all = commands(text);
    assert!(all.contains(&String::from("meniscus run --view   --seconds 3")), "{all:?}");
    let mut helps = Helps(BTreeMap::new());
    let mut wrong = |command: &str| helps.wrong(&words(command).expect("a command"));
    assert_eq!(wrong("cargo run --release -- run --view"), None);
    assert_eq!(wrong("meniscus camera study --scenes 40"), None);
    assert_eq!(wrong("meniscus correct --recordings x --out y"), None);
    assert!(wrong("meniscus run --vieew").is_some_and(|what| what.contains("--vieew")));
    assert!(wrong("meniscus camera study --view").is_some_and(|what| what.contains("--view")));
    assert!(wrong("meniscus correct --recordigns x").is_some());
    assert!(wrong("meniscus rnu").is_some_and(|what| what.contains("no verb")));
    assert_eq!(words("hil/run gate"), None);
    assert_eq!(words("cargo run --release -p meniscus-examples --example see -- a"), None);
    assert!(makes("MENISCUS_PAGE_PICTURE=docs/page.png cargo test --release") && makes("meniscus render"));
    assert!(!makes("cargo test --release") && !makes("meniscus") && !makes("src/lib.rs"));
}
