//! The tutorial's commands, run chapter by chapter without a camera, and its answers compared with those of the program.
//!
//! Chapters 2 and 3 take some seconds. `cargo xtask tutorial` sets MENISCUS_TUTORIAL=all and runs every chapter, which takes
//! many minutes; `MENISCUS_TUTORIAL=2,5,6,8` runs these. Numbers differ from machine to machine, so an answer is compared line by line with each number replaced by
//! `#`.

use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Command;

/// Chapters that take some seconds.
const QUICK: [usize; 2] = [2, 3];
/// Chapters with commands. Chapter 1 has none.
const ALL: std::ops::RangeInclusive<usize> = 2..=8;
/// Verbs that reach for a camera unless they are given a source.
const CAMERA: [&str; 3] = ["doctor", "setup", "record"];

/// Fence of a chapter.
#[derive(Debug, PartialEq, Eq)]
struct Block {
    chapter: usize,
    language: String,
    text: String,
}

/// The fences of the page with their chapters.
fn blocks(page: &str) -> Vec<Block> {
    let (mut chapter, mut blocks, mut open) = (0, Vec::new(), None::<Block>);
    for line in page.lines() {
        let fence = line.strip_prefix("```");
        match (open.take(), fence) {
            (Some(block), Some(_)) => blocks.push(block),
            (Some(mut block), None) => {
                block.text += line;
                block.text.push('\n');
                open = Some(block);
            }
            (None, Some(language)) => {
                open = Some(Block { chapter, language: language.into(), text: String::new() });
            }
            (None, None) => {
                let number = line.strip_prefix("## ").and_then(|title| title.split('.').next());
                chapter = number.and_then(|number| number.parse().ok()).unwrap_or(chapter);
            }
        }
    }
    blocks
}

/// A script without the commands that need a camera.
fn without_camera(script: &str) -> String {
    let needs = |line: &&str| {
        let mut words = line.split_whitespace();
        let verb = (words.next() == Some("meniscus")).then(|| words.next()).flatten();
        let camera = verb.is_some_and(|verb| CAMERA.contains(&verb)) && !line.contains("--source");
        camera || line.contains("one.mcap")
    };
    script.lines().filter(|line| !needs(line)).fold(String::new(), |text, line| text + line + "\n")
}

/// A line with its numbers replaced by `#` and its blanks by one.
fn masked(line: &str) -> String {
    let word = |word: &str| {
        let core = word.trim_matches(|c: char| "()[]:;,%".contains(c));
        let is_number = core.trim_start_matches(['-', '+', '~']).starts_with(|c: char| c.is_ascii_digit());
        if is_number { word.replacen(core, "#", 1) } else { word.to_owned() }
    };
    line.split_whitespace().map(word).collect::<Vec<_>>().join(" ")
}

/// Lines of an expected answer that the program did not print. `...` stands for any lines, `[...]` for the rest of one.
fn missing(expected: &str, printed: &str) -> Vec<String> {
    let printed: Vec<String> = printed.lines().map(masked).collect();
    let whole = printed.join(" ");
    let is_there = |line: &str| {
        let line = masked(line.split("[...]").next().unwrap_or(line));
        line == "..." || line.is_empty() || printed.contains(&line) || whole.contains(&line)
    };
    expected.lines().filter(|line| !is_there(line)).map(str::to_owned).collect()
}

/// Runs the scripts of one chapter in `folder`; returns what is not as the page says.
fn faults_of(chapter: usize, blocks: &[Block], folder: &Path) -> Vec<String> {
    let (mut faults, mut printed) = (Vec::new(), String::new());
    for block in blocks.iter().filter(|block| block.chapter == chapter) {
        match block.language.as_str() {
            "sh" => {
                let script = without_camera(&block.text);
                let output = Command::new("bash")
                    .args(["-c", &script])
                    .current_dir(folder)
                    .env("PATH", path_with(folder))
                    .output()
                    .expect("bash");
                printed = String::from_utf8_lossy(&output.stdout).into_owned();
                printed += &String::from_utf8_lossy(&output.stderr);
            }
            "text" => {
                let lines = missing(&block.text, &printed);
                if !lines.is_empty() {
                    faults.push(format!("chapter {chapter}: {lines:#?} is not in:\n{printed}"));
                }
            }
            "toml" => {
                let name =
                    block.text.lines().next().and_then(|line| line.strip_prefix("# ")).expect("a name");
                fs::write(folder.join(name), &block.text).expect("written");
            }
            other => panic!("a block of {other}"),
        }
    }
    faults
}

/// PATH with the program under test as `meniscus` before everything else.
fn path_with(folder: &Path) -> String {
    let path = std::env::var("PATH").unwrap_or_default();
    format!("{}:{path}", folder.join("bin").display())
}

#[test]
fn the_commands_of_the_tutorial_answer_as_it_says() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/tutorial.md");
    let blocks = blocks(&fs::read_to_string(page).expect("docs/tutorial.md"));
    let scripts = |chapter: usize| blocks.iter().any(|b| b.chapter == chapter && b.language == "sh");
    assert!(ALL.into_iter().all(scripts), "a chapter without a command");
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("tutorial");
    let _old = fs::remove_dir_all(&folder);
    fs::create_dir_all(folder.join("bin")).expect("a folder");
    symlink(env!("CARGO_BIN_EXE_meniscus-under-test"), folder.join("bin/meniscus")).expect("a link");
    let chapters: Vec<usize> = match std::env::var("MENISCUS_TUTORIAL").as_deref() {
        Ok("all") => ALL.collect(),
        Ok(list) => list.split(',').map(|chapter| chapter.parse().expect("chapters, as 2,5,6")).collect(),
        Err(_) => QUICK.to_vec(),
    };
    let run = |chapter| {
        eprintln!("chapter {chapter}");
        faults_of(chapter, &blocks, &folder)
    };
    let faults: Vec<String> = chapters.into_iter().flat_map(run).collect();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn another_answer_is_found() {
    let page =
        "## 3. Look (5 min)\n```sh\nmeniscus doctor\nmeniscus run\n```\n\n```text\na 1.5 mm ok\n...\n```\n";
    let blocks = blocks(page);
    assert_eq!(
        blocks.iter().map(|b| (b.chapter, b.language.as_str())).collect::<Vec<_>>(),
        [(3, "sh"), (3, "text")]
    );
    assert_eq!(without_camera(&blocks[0].text), "meniscus run\n");
    assert!(missing(&blocks[1].text, "x\n  a   2.25  mm ok\n").is_empty());
    assert_eq!(missing(&blocks[1].text, "a 2.25 mm MISSED\n"), ["a 1.5 mm ok"]);
    assert_eq!(masked("50 turns: 16 filling, (90 %: 2.2 to 6.5)"), "# turns: # filling, (# %: # to #)");
}
