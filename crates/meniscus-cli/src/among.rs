//! The liquids that verbs ask about: those in the program, notes, and folders of notes.

use meniscus_service::identify::{Note, NoteError};
use std::path::Path;

/// The notes that `paths` name, all of one glass of this radius and fill (m).
pub(super) fn among(paths: &[String], glass: (f64, f64)) -> Result<Vec<Note>, NoteError> {
    let mut notes = Vec::new();
    for path in paths {
        if path == "shipped" {
            for (name, text) in meniscus_shipped::LIQUIDS {
                notes.push(Note::parse(Path::new(name), text)?);
            }
        } else {
            notes.extend(Note::all_of(Path::new(path))?);
        }
    }
    Note::agree(&notes, glass)?;
    Ok(notes)
}
