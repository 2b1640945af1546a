//! Parts of a report, whatever its form.

use crate::checks::Check;

/// A table; the first column is the name of a row.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Table {
    pub(crate) head: Vec<String>,
    pub(crate) rows: Vec<Vec<String>>,
}

/// A picture.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Figure {
    pub(crate) caption: String,
    /// As an `svg` element, for a page that stands alone.
    pub(crate) svg: Option<String>,
    /// As a file beside the report, for a form that can only refer to it.
    pub(crate) file: Option<String>,
}

/// One part of a report.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Block {
    Heading(String),
    Prose(String),
    Answer(String),
    Table(Table),
    Checks(Vec<Check>),
    Figure(Figure),
}
