//! Note of a liquid, `NAME.liquid.json`: its first mode in a glass.

use meniscus::identify::{Calibration, KnownLiquid, Tone};
use meniscus_platform::files::{FileError, read_text};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Version of the note that is written and read.
const VERSION: u32 = 1;

/// Liquids that can be asked at a time.
pub const MOST: usize = 16;

/// End of a note's name.
const ENDING: &str = ".liquid.json";

/// Largest difference between the measures of two glasses that count as the same, m: the accuracy of a calliper and a
/// ruler in a glass, as for models. It moves the frequency by 1.4 %.
const SAME_M: f64 = 1e-3;

/// Glass in which a liquid was learnt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GlassSize {
    /// Inner radius, m.
    pub radius_m: f64,
    /// Height of the liquid at rest, m.
    pub fill_m: f64,
}

/// First mode of a liquid in a glass, with its calibration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Note {
    /// Version of this format, 1.
    pub version: u32,
    /// Name of the liquid.
    pub liquid: String,
    /// Inner radius of the glass, m.
    pub radius_m: f64,
    /// Height of the liquid at rest, m.
    pub fill_m: f64,
    /// Its first mode.
    pub tone: Tone,
    /// Residual statistics of that mode.
    pub calibration: Calibration,
    /// The recordings that say so.
    pub recordings: Vec<String>,
    /// The command that made it.
    pub command: String,
}

/// Why a note could not be had.
#[derive(Debug)]
pub enum NoteError {
    /// A file could not be read.
    File(FileError),
    /// The text is no note.
    Malformed(PathBuf, String),
    /// A number of the note makes no sense.
    Range(PathBuf, &'static str, f64),
    /// A folder without a note.
    Empty(PathBuf),
    /// Two notes of one liquid.
    Twice(String),
    /// More liquids than can be asked.
    TooMany(usize),
    /// A note of another glass than the one that is looked at.
    OtherGlass(String, [f64; 2], [f64; 2]),
}

impl std::fmt::Display for NoteError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let how = "`meniscus recognise learn` makes notes from recordings of a liquid";
        match self {
            Self::File(error) => write!(f, "{error}"),
            Self::Malformed(path, why) => {
                write!(f, "{} is no note of a liquid: {why}; {how}", path.display())
            }
            Self::Range(path, field, value) => {
                write!(f, "{}: {field} = {value} is out of range; {how}", path.display())
            }
            Self::Empty(folder) => write!(f, "{} holds no *{ENDING}; {how}", folder.display()),
            Self::Twice(liquid) => write!(f, "{liquid} is given twice: one note a liquid"),
            Self::TooMany(count) => write!(f, "{count} liquids are too many: {MOST} can be asked at a time"),
            Self::OtherGlass(liquid, [radius, fill], [radius_here, fill_here]) => write!(
                f,
                "{liquid} was learnt in a glass of {:.1} mm radius filled to {:.1} mm, this one has {:.1} and {:.1} mm: \
                 learn it in this glass",
                1e3 * radius,
                1e3 * fill,
                1e3 * radius_here,
                1e3 * fill_here
            ),
        }
    }
}

impl std::error::Error for NoteError {}

/// Names and what is known, apart.
#[must_use]
pub fn split(notes: &[Note]) -> (Vec<String>, Vec<KnownLiquid>) {
    let known = |note: &Note| KnownLiquid { tone: note.tone, calibration: note.calibration };
    notes.iter().map(|note| (note.liquid.clone(), known(note))).unzip()
}

impl Note {
    /// A note of what was learnt now.
    #[must_use]
    pub fn new(
        liquid: &str,
        glass: GlassSize,
        known: KnownLiquid,
        recordings: Vec<String>,
        command: &str,
    ) -> Self {
        let GlassSize { radius_m, fill_m } = glass;
        let KnownLiquid { tone, calibration } = known;
        let (liquid, command) = (liquid.into(), command.into());
        Self { version: VERSION, liquid, radius_m, fill_m, tone, calibration, recordings, command }
    }

    /// The note at `path`.
    ///
    /// # Errors
    /// [`NoteError`].
    pub fn read(path: &Path) -> Result<Self, NoteError> {
        let text = read_text(path)
            .map_err(|cause| NoteError::File(FileError { path: path.into(), doing: "read", cause }))?;
        Self::parse(path, &text)
    }

    /// The note in `text`; `origin` names it in errors.
    ///
    /// # Errors
    /// [`NoteError`].
    pub fn parse(origin: &Path, text: &str) -> Result<Self, NoteError> {
        let malformed = |why: String| NoteError::Malformed(origin.into(), why);
        let note: Self = serde_json::from_str(text).map_err(|error| malformed(format!("{error}")))?;
        if note.version != VERSION {
            return Err(malformed(format!(
                "its version is {}, this program reads {VERSION}: learn it again with `meniscus recognise learn`",
                note.version
            )));
        }
        let (tone, calibration) = (&note.tone, &note.calibration);
        let (above, any) = (f64::MIN_POSITIVE..=1e6, 0.0..=1e6);
        let fields = [
            ("radius_m", note.radius_m, above.clone()),
            ("fill_m", note.fill_m, above.clone()),
            ("frequency", tone.frequency, above.clone()),
            ("decay", tone.decay, any.clone()),
            ("yielding", tone.yielding, any.clone()),
            ("breaking", tone.breaking, any),
            ("softening", tone.softening, -1.0..=1.0),
            ("lever", tone.lever, above.clone()),
            ("scale", calibration.scale, above.clone()),
            ("scatter", calibration.scatter, above.clone()),
            ("numbers", calibration.numbers, above),
        ];
        match fields.into_iter().find(|(_, value, range)| !range.contains(value)) {
            Some((field, value, _)) => Err(NoteError::Range(origin.into(), field, value)),
            None => Ok(note),
        }
    }

    /// The note in a file, or every note in a folder, by name.
    ///
    /// # Errors
    /// [`NoteError`] of the first that is wrong, or of a folder that holds none.
    pub fn all_of(path: &Path) -> Result<Vec<Self>, NoteError> {
        if !path.is_dir() {
            return Ok(vec![Self::read(path)?]);
        }
        let failed = |cause| NoteError::File(FileError { path: path.into(), doing: "list", cause });
        let mut files = Vec::new();
        for entry in std::fs::read_dir(path).map_err(failed)? {
            let file = entry.map_err(failed)?.path();
            if file.file_name().is_some_and(|name| name.to_string_lossy().ends_with(ENDING)) {
                files.push(file);
            }
        }
        if files.is_empty() {
            return Err(NoteError::Empty(path.into()));
        }
        files.sort();
        files.iter().map(|file| Self::read(file)).collect()
    }

    /// Whether all of `notes` can be asked about one glass.
    ///
    /// # Errors
    /// [`NoteError`]: too many, one twice, or one of another glass.
    pub fn agree(notes: &[Self], glass: GlassSize) -> Result<(), NoteError> {
        if notes.len() > MOST {
            return Err(NoteError::TooMany(notes.len()));
        }
        for (index, note) in notes.iter().enumerate() {
            if notes.iter().take(index).any(|other| other.liquid == note.liquid) {
                return Err(NoteError::Twice(note.liquid.clone()));
            }
            let off = (note.radius_m - glass.radius_m).abs().max((note.fill_m - glass.fill_m).abs());
            if off.is_nan() || off > SAME_M {
                let (own, here) = ([note.radius_m, note.fill_m], [glass.radius_m, glass.fill_m]);
                return Err(NoteError::OtherGlass(note.liquid.clone(), own, here));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus_platform::files::write_whole;

    const GLASS: GlassSize = GlassSize { radius_m: 0.035, fill_m: 0.07 };

    fn note(liquid: &str) -> Note {
        let tone =
            Tone { frequency: 22.0, decay: 1.0, yielding: 0.0, breaking: 0.1, softening: 0.02, lever: 1.5 };
        let calibration = Calibration { scale: 0.1, scatter: 0.2, numbers: 0.1 };
        Note::new(liquid, GLASS, KnownLiquid { tone, calibration }, Vec::new(), "by hand")
    }

    #[test]
    fn notes_come_back_from_their_folder_and_nonsense_is_refused() {
        let folder = std::env::temp_dir().join(format!("meniscus-notes-{}", std::process::id()));
        let keep = |note: &Note| {
            let text = serde_json::to_vec(note).expect("plain numbers");
            write_whole(&folder.join(format!("{}{ENDING}", note.liquid)), &text).expect("writable");
        };
        std::fs::create_dir_all(&folder).expect("a folder");
        let empty = Note::all_of(&folder).expect_err("nothing there");
        assert!(format!("{empty}").contains("holds no *.liquid.json"), "{empty}");
        keep(&note("water"));
        keep(&note("honey"));
        let all = Note::all_of(&folder).expect("two");
        assert_eq!(all, [note("honey"), note("water")]);
        assert_eq!(split(&all).0, ["honey", "water"]);
        let mut odd = note("tar");
        odd.calibration.scatter = -1.0;
        keep(&odd);
        let wrong = Note::all_of(&folder).expect_err("a scatter below zero");
        assert!(format!("{wrong}").contains("scatter = -1 is out of range"), "{wrong}");
        let malformed = Note::parse(Path::new("x.liquid.json"), "{}").expect_err("empty");
        assert!(format!("{malformed}").contains("x.liquid.json is no note"), "{malformed}");
        assert!(std::fs::remove_dir_all(&folder).is_ok());
    }

    #[test]
    fn liquids_of_another_glass_or_named_twice_are_refused() {
        let refused = |notes: &[Note]| format!("{}", Note::agree(notes, GLASS).expect_err("refused"));
        assert!(Note::agree(&[note("a"), note("b")], GLASS).is_ok());
        assert!(refused(&[note("a"), note("b"), note("a")]).contains("a is given twice"));
        let other = Note { radius_m: 0.04, ..note("a") };
        assert!(
            refused(&[other]).contains("40.0 mm radius filled to 70.0 mm, this one has 35.0 and 70.0 mm")
        );
        let many: Vec<Note> = (0..17).map(|k| note(&format!("{k}"))).collect();
        assert!(refused(&many).contains("17 liquids are too many"));
    }
}
