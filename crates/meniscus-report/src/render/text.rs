//! A report for a terminal.

use crate::block::{Block, Figure, Table};
use crate::checks;

/// Returns the report without its drawings.
pub(crate) fn text(title: &str, command: &str, blocks: &[Block]) -> String {
    let mut out = format!("{title}\n{command}\n");
    for part in blocks {
        out.push('\n');
        out.push_str(&block(part));
    }
    out
}

fn block(block: &Block) -> String {
    match block {
        Block::Heading(text) | Block::Prose(text) | Block::Answer(text) => format!("{text}\n"),
        Block::Table(table) => self::table(table),
        Block::Checks(checks) => checks::table(checks),
        Block::Figure(Figure { file: Some(file), caption, .. }) => format!("{caption}: {file}\n"),
        Block::Figure(Figure { caption, .. }) => format!("{caption} (in the HTML page)\n"),
    }
}

/// Columns as wide as their widest cell; the first to the left, numbers to the right.
fn table(table: &Table) -> String {
    let rows = || std::iter::once(&table.head).chain(&table.rows);
    let width = |column: usize| {
        rows().filter_map(|row| row.get(column)).map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let line = |row: &Vec<String>| {
        let cell = |(column, cell): (usize, &String)| match column {
            0 => format!("  {cell:width$}", width = width(0)),
            _ => format!("  {cell:>width$}", width = width(column)),
        };
        let line: String = row.iter().enumerate().map(cell).collect();
        format!("{}\n", line.trim_end())
    };
    rows().map(line).collect()
}
