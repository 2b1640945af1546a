//! The liquids that verbs ask about: those in the program, notes, and folders of notes.

use crate::kind::{Kind, expect_text};
use meniscus_service::identify::{GlassSize, Note};
use std::path::Path;

/// Returns the notes that `paths` name, all of this glass.
pub(super) fn among(paths: &[String], glass: GlassSize) -> anyhow::Result<Vec<Note>> {
    let mut notes = Vec::new();
    for path in paths {
        if path == "shipped" {
            for (name, text) in meniscus_shipped::LIQUIDS {
                notes.push(Note::parse(Path::new(name), text)?);
            }
        } else {
            if !Path::new(path).is_dir() {
                expect_text(Path::new(path), Kind::Note, "a note of a liquid")?;
            }
            notes.extend(Note::all_of(Path::new(path))?);
        }
    }
    Note::agree(&notes, glass)?;
    Ok(notes)
}
