//! A report as Markdown, for a page of the documentation or a commit.

use super::value;
use crate::block::{Block, Figure};
use crate::checks::Check;

/// Returns the page.
pub(crate) fn markdown(title: &str, command: &str, blocks: &[Block]) -> String {
    let mut page = format!("# {title}\n\nmeniscus {}, `{command}`\n", env!("CARGO_PKG_VERSION"));
    for part in blocks {
        page.push('\n');
        page.push_str(&block(part));
    }
    page
}

fn block(block: &Block) -> String {
    match block {
        Block::Heading(text) => format!("## {text}\n"),
        Block::Prose(text) => format!("{text}\n"),
        Block::Answer(text) => format!("> {text}\n"),
        Block::Table(table) => {
            let numbers = "---:|".repeat(table.head.len().saturating_sub(1));
            let body: String = table.rows.iter().map(|cells| row(cells)).collect();
            format!("{}|---|{numbers}\n{body}", row(&table.head))
        }
        Block::Checks(checks) => {
            let body: String = checks.iter().map(check).collect();
            format!("| check | value | unit | target | |\n|---|---:|---|---|---|\n{body}")
        }
        Block::Figure(Figure { file: Some(file), caption, .. }) => format!("![{caption}]({file})\n"),
        Block::Figure(Figure { caption, .. }) => format!("Figure, in the HTML page: {caption}\n"),
    }
}

fn check(check: &Check) -> String {
    row(&[&check.name, value(check).as_str(), check.unit, check.target.as_str(), check.verdict()])
}

/// A row of a table; a bar in a cell would end it.
fn row(cells: &[impl AsRef<str>]) -> String {
    let cells: Vec<String> = cells.iter().map(|cell| cell.as_ref().replace('|', "\\|")).collect();
    format!("| {} |\n", cells.join(" | "))
}
