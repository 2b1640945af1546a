//! Kinds of files by their content, so that a file at the wrong option is named for what it is.

use anyhow::{bail, ensure};
use meniscus_platform::files::{Links, open_regular};
use std::io::Read;
use std::path::Path;

/// First bytes that are looked at: a safetensors header with its metadata is within them.
const HEAD: u64 = 64 * 1024;

/// Endings of the kinds of files that the program writes.
const ENDINGS: [&str; 8] = ["safetensors", "blob", "mcap", "csv", "toml", "json", "png", "html"];

/// Kind of a file or folder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// A camera's recording: MCAP, a ROS bag, or a folder of images with their times.
    Camera,
    /// A recording of the simulator.
    Simulated,
    /// Estimates of a run.
    Estimates,
    /// A weight blob.
    Model,
    /// A folder with the slots of `meniscus flash`.
    Slots,
    /// A settings file of `meniscus setup`.
    Setup,
    /// A note of `meniscus recognise learn`.
    Note,
    /// Arrays of numpy.
    Arrays,
    /// A picture.
    Picture,
    /// A table.
    Table,
    /// Other text.
    Text,
    /// No bytes.
    Empty,
    /// Some other folder.
    Folder,
    /// Anything else.
    Other,
}

impl Kind {
    /// Returns the kind of what lies at `path`; `None` where nothing can be read.
    pub(super) fn of(path: &Path) -> Option<Self> {
        if path.is_dir() {
            return Some(match path {
                _ if path.join("frames.csv").exists() || path.join("metadata.yaml").exists() => Self::Camera,
                _ if path.join("slot-a.blob").exists() || path.join("slot-b.blob").exists() => Self::Slots,
                _ => Self::Folder,
            });
        }
        let mut head = Vec::new();
        open_regular(path, Links::Followed).ok()?.take(HEAD).read_to_end(&mut head).ok()?;
        let table = path.extension().is_some_and(|extension| extension == "csv");
        Some(Self::of_bytes(&head, table))
    }

    fn of_bytes(head: &[u8], table: bool) -> Self {
        let starts = |magic: &[u8]| head.starts_with(magic);
        let text = || {
            let sample = &head[..head.len().min(4096)];
            let cut = |error: std::str::Utf8Error| error.error_len().is_none();
            let control = sample.iter().any(|byte| *byte < b' ' && !byte.is_ascii_whitespace());
            !control && std::str::from_utf8(sample).map_or_else(cut, |_| true)
        };
        let has = |word: &str| head.windows(word.len()).any(|window| window == word.as_bytes());
        match head {
            [] => Self::Empty,
            _ if starts(b"\x89MCAP0\r\n") || starts(b"#ROSBAG V") || starts(b"SQLite format 3\0") => {
                Self::Camera
            }
            _ if starts(&meniscus::blob::MAGIC) => Self::Model,
            _ if starts(b"\x89PNG") || starts(b"\xff\xd8\xff") => Self::Picture,
            _ if starts(b"PK\x03\x04") || starts(b"\x93NUMPY") => Self::Arrays,
            _ if head.get(8) == Some(&b'{') && has("meniscus estimates") => Self::Estimates,
            _ if head.get(8) == Some(&b'{') && has("meniscus recording") => Self::Simulated,
            _ if !text() => Self::Other,
            _ if table => Self::Table,
            _ if has("[view]") && has("[glass]") => Self::Setup,
            _ if starts(b"{") && has("\"liquid\"") && has("\"calibration\"") => Self::Note,
            _ => Self::Text,
        }
    }

    /// Name of the kind, and what takes it.
    pub(super) fn what(self) -> &'static str {
        match self {
            Self::Camera => "a camera's recording (`meniscus run --source` plays it)",
            Self::Simulated => "a recording of the simulator (`meniscus run --source` takes it)",
            Self::Estimates => "the estimates of a run (--estimates), which no verb reads",
            Self::Model => "a model blob (--model takes it)",
            Self::Slots => "a folder of `meniscus flash` (`meniscus run --model` takes it)",
            Self::Setup => "a settings file of `meniscus setup` (--setup takes it)",
            Self::Note => "a note of a liquid (--among takes it)",
            Self::Arrays => "a file of numpy (`meniscus generic` takes it)",
            Self::Picture => "a picture",
            Self::Table => "a table",
            Self::Text => "a text file",
            Self::Empty => "an empty file",
            Self::Folder => "some other folder",
            Self::Other => "a file of no known kind",
        }
    }
}

impl Kind {
    /// Remedy for a person who gave a file of another kind.
    fn remedy(self) -> &'static str {
        match self {
            Self::Camera => {
                "give what `meniscus record` writes: .mcap, or a folder of images with frames.csv"
            }
            Self::Simulated => "give what `meniscus simulate` writes",
            Self::Model => "give shipped, or a blob of `meniscus train`, `correct` or `learn`",
            Self::Slots => "`meniscus flash BLOB --to FOLDER` fills one",
            Self::Setup => "give what `meniscus setup` writes",
            Self::Note => "give what `meniscus recognise learn` writes",
            Self::Arrays => "give what numpy.savez writes",
            _ => "see --help",
        }
    }
}

/// Refuses what lies at `path` where it is certainly something else than `wanted`, which is `described`. Bytes of no known
/// kind pass: their reader says what is wrong with them.
pub(super) fn expect(path: &Path, wanted: Kind, described: &str) -> anyhow::Result<()> {
    expect_or(path, wanted, described, wanted.remedy())
}

/// Refuses as [`expect`] does, with another remedy.
pub(super) fn expect_or(path: &Path, wanted: Kind, described: &str, remedy: &str) -> anyhow::Result<()> {
    match Kind::of(path) {
        Some(kind) if kind != wanted && kind != Kind::Other => {
            bail!("{} is not {described}: it is {}; {remedy}", path.display(), kind.what())
        }
        _ => Ok(()),
    }
}

/// Refuses what lies at `path` as [`expect`] does, but lets text pass, whose reader names the faulty line.
pub(super) fn expect_text(path: &Path, wanted: Kind, described: &str) -> anyhow::Result<()> {
    match Kind::of(path) {
        Some(Kind::Text | Kind::Table | Kind::Empty) => Ok(()),
        _ => expect(path, wanted, described),
    }
}

/// Refuses a name with the ending of another kind of file than `ending`.
pub(super) fn check_ending(path: &Path, ending: &str) -> anyhow::Result<()> {
    let given = path.extension().and_then(|given| given.to_str()).unwrap_or(ending);
    ensure!(
        given == ending || !ENDINGS.contains(&given),
        "{} ends in .{given}, and a .{ending} file is written: name it {}",
        path.display(),
        path.with_extension(ending).display()
    );
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ending_of_another_kind_is_refused() {
        check_ending(Path::new("a.blob"), "blob").expect("its own");
        check_ending(Path::new("a.v2"), "blob").expect("none of ours");
        check_ending(Path::new("a"), "blob").expect("none");
        let why = check_ending(Path::new("a.safetensors"), "blob").expect_err("refused").to_string();
        assert_eq!(why, "a.safetensors ends in .safetensors, and a .blob file is written: name it a.blob");
    }

    #[test]
    fn files_are_known_by_their_content() {
        let repository = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
        for (path, kind) in [
            ("models/glycerine.blob", Kind::Model),
            ("recordings/glycerine-unseen.safetensors", Kind::Simulated),
            ("README.md", Kind::Text),
            ("docs", Kind::Folder),
            ("docs/run.png", Kind::Picture),
        ] {
            assert_eq!(Kind::of(&repository.join(path)), Some(kind), "{path}");
        }
        assert_eq!(Kind::of(Path::new("nowhere")), None);
        for (bytes, kind) in [
            (&b"\x89MCAP0\r\n123"[..], Kind::Camera),
            (b"#ROSBAG V2.0\n", Kind::Camera),
            (b"SQLite format 3\0abc", Kind::Camera),
            (b"PK\x03\x04", Kind::Arrays),
            (b"", Kind::Empty),
            (b"made_by = 'x'\n[glass]\nradius_mm = 35\n[view]\n", Kind::Setup),
            (b"plain words\n", Kind::Text),
            (&[7; 100], Kind::Other),
            (&[0xfe; 100], Kind::Other),
        ] {
            assert_eq!(Kind::of_bytes(bytes, false), kind, "{bytes:?}");
        }
    }
}
