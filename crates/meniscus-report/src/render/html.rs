//! One HTML file that stands alone: what made it, prose, tables, checks and plots, nothing from elsewhere.
//!
//! It reads on a screen and in print; lines differ in colour (Okabe and Ito 2008) and have their name in the legend.

use super::value;
use crate::block::{Block, Figure, Table};
use crate::checks::Check;
use maud::{DOCTYPE, Markup, PreEscaped, html};

const STYLE: &str = "body{font:16px/1.5 sans-serif;max-width:60em;margin:2em auto;padding:0 1em;color:#222}\
h1{margin-bottom:.2em}table{border-collapse:collapse;margin:1em 0}\
td,th{padding:.2em .7em;border-bottom:1px solid #ddd;text-align:right}td:first-child,th:first-child{text-align:left}\
tr.missed td:last-child{font-weight:bold;color:#a33f00}pre{background:#f4f4f4;padding:.6em;white-space:pre-wrap}\
.answer{font-size:1.2em;background:#eef4fb;padding:.8em;border-left:6px solid #0072b2}\
figure{margin:1em 0}figcaption,footer{color:#555;font-size:.9em}svg{max-width:100%;height:auto}\
@media print{body{margin:0;max-width:none;font-size:11pt}figure,tr{break-inside:avoid}h2{break-after:avoid}}";

/// Returns the page.
pub(crate) fn html(title: &str, command: &str, blocks: &[Block]) -> String {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width";
                title { (title) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                h1 { (title) }
                pre { (command) }
                @for part in blocks { (block(part)) "\n" }
                footer { "meniscus " (env!("CARGO_PKG_VERSION")) }
            }
        }
    };
    page.into_string()
}

fn block(block: &Block) -> Markup {
    match block {
        Block::Heading(text) => html! { h2 { (text) } },
        Block::Prose(text) => html! { p { (text) } },
        Block::Answer(text) => html! { p.answer { (text) } },
        Block::Table(table) => self::table(table),
        Block::Checks(checks) => self::checks(checks),
        // Without a drawing of its own a page that stands alone cannot show it.
        Block::Figure(Figure { svg: None, .. }) => html! {},
        Block::Figure(Figure { svg: Some(svg), caption, .. }) => html! {
            figure {
                (PreEscaped(svg))
                figcaption { (caption) }
            }
        },
    }
}

fn table(table: &Table) -> Markup {
    html! {
        table {
            tr { @for cell in &table.head { th { (cell) } } }
            @for row in &table.rows {
                tr { @for cell in row { td { (cell) } } }
            }
        }
    }
}

fn checks(checks: &[Check]) -> Markup {
    html! {
        table {
            tr { th { "check" } th { "value" } th { "unit" } th { "target" } th { "verdict" } }
            @for check in checks {
                tr.missed[check.missed()] {
                    td { (check.name) }
                    td { (value(check)) }
                    td { (check.unit) }
                    td { (check.target) }
                    td { (check.verdict().to_lowercase()) }
                }
            }
        }
    }
}
