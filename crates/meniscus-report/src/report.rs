//! The content of a report, block by block, whatever its form.

use crate::block::{Block, Figure, Table};
use crate::chart::Chart;
use crate::checks::Check;
use crate::plot::PictureError;
use crate::render;
use serde_json::{Value, json};

/// Report of a study in the making. Text is plain: each form escapes what it has to.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    title: String,
    command: String,
    blocks: Vec<Block>,
}

impl Report {
    /// Starts a report that `command` makes again.
    #[must_use]
    pub fn new(title: &str, command: &str) -> Self {
        Self { title: title.into(), command: command.into(), blocks: Vec::new() }
    }

    /// Adds a heading.
    pub fn heading(&mut self, text: &str) {
        self.blocks.push(Block::Heading(text.into()));
    }

    /// Adds a paragraph.
    pub fn prose(&mut self, text: &str) {
        self.blocks.push(Block::Prose(text.into()));
    }

    /// Adds the result in a sentence that stands apart.
    pub fn answer(&mut self, text: &str) {
        self.blocks.push(Block::Answer(text.into()));
    }

    /// Adds a table; the first column stands to the left, as it names its row.
    pub fn table(&mut self, head: &[&str], rows: &[Vec<String>]) {
        let head = head.iter().map(|text| String::from(*text)).collect();
        self.blocks.push(Block::Table(Table { head, rows: rows.to_vec() }));
    }

    /// Adds checks with their verdicts.
    pub fn checks(&mut self, checks: &[Check]) {
        self.blocks.push(Block::Checks(checks.to_vec()));
    }

    /// Adds a plot with its caption.
    ///
    /// # Errors
    /// [`PictureError`], when the chart has no range to draw.
    pub fn chart(&mut self, chart: &Chart<'_>) -> Result<(), PictureError> {
        self.drawing(&chart.svg()?, chart.caption);
        Ok(())
    }

    /// Adds a plot that also lies in `file` beside the report: HTML has the plot, Markdown a link to the file.
    ///
    /// # Errors
    /// [`PictureError`], when the chart has no range to draw.
    pub fn chart_beside(&mut self, chart: &Chart<'_>, file: &str) -> Result<(), PictureError> {
        self.figure(chart.caption, Some(chart.svg()?), Some(file.into()));
        Ok(())
    }

    /// Adds a drawing that is no plot, as an `svg` element, with its caption.
    pub fn drawing(&mut self, svg: &str, caption: &str) {
        self.figure(caption, Some(svg.into()), None);
    }

    /// Adds a picture that lies in `file` beside the report. HTML leaves it out, because that page stands alone.
    pub fn picture(&mut self, file: &str, caption: &str) {
        self.figure(caption, None, Some(file.into()));
    }

    fn figure(&mut self, caption: &str, svg: Option<String>, file: Option<String>) {
        self.blocks.push(Block::Figure(Figure { caption: caption.into(), svg, file }));
    }

    /// Returns the checks of all blocks as the JSON object that every verifying command prints: `checks`, an array of
    /// `name`, `value`, `unit`, `target` and `ok`.
    #[must_use]
    pub fn json(&self) -> Value {
        let checks = self.blocks.iter().filter_map(|block| match block {
            Block::Checks(checks) => Some(checks),
            _ => None,
        });
        json!({ "checks": checks.flatten().collect::<Vec<_>>() })
    }

    /// Returns the report for a terminal, without its pictures.
    #[must_use]
    pub fn text(&self) -> String {
        render::text(&self.title, &self.command, &self.blocks)
    }

    /// Returns the report as Markdown, with links to the pictures that lie beside it.
    #[must_use]
    pub fn markdown(&self) -> String {
        render::markdown(&self.title, &self.command, &self.blocks)
    }

    /// Returns the report as one HTML file that needs no other.
    #[must_use]
    pub fn html(&self) -> String {
        render::html(&self.title, &self.command, &self.blocks)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Mark, Series};

    fn report() -> Report {
        let mut report = Report::new("<script>", "meniscus x --y 'z'");
        report.heading("a & b");
        report.prose("one | two");
        report.answer("it holds");
        report.table(&["one", "two|2"], &[vec!["<td>".into(), "2".into()]]);
        report.checks(&[Check::at_most("drift", 2.0, "mm", 1.0), Check::informational("n", f64::NAN, "1")]);
        let points = [(0.0, 1.0), (1.0, 3.0)];
        let series = [Series { name: "before <1>", points: &points, mark: Mark::Line, colour: 0 }];
        let chart = Chart { caption: "c", x: "t, s", y: "error, %", series: &series };
        report.chart(&chart).expect("it has a range");
        report.chart_beside(&chart, "c.png").expect("it has a range");
        report.picture("only.png", "a photograph");
        report
    }

    #[test]
    fn a_page_stands_alone_and_escapes_its_text() {
        let html = report().html();
        assert!(html.starts_with("<!DOCTYPE html>"));
        assert!(html.contains("&lt;script&gt;") && !html.contains("<script"), "{html}");
        assert!(html.contains("--y 'z'") && html.contains("a &amp; b") && html.contains("&lt;td&gt;"));
        assert!(html.contains("<tr class=\"missed\">") && html.contains("not measured"));
        assert_eq!(html.matches("<svg").count(), 2);
        assert!(html.contains("<polyline") && html.contains("before &lt;1&gt;"), "{html}");
        assert_eq!(html.matches("http://").count(), html.matches("http://www.w3.org").count());
        assert!(!html.contains("src=") && !html.contains("href=") && !html.contains("only.png"));
    }

    #[test]
    fn markdown_has_every_block_and_keeps_its_columns() {
        let page = report().markdown();
        for part in [
            "# <script>\n",
            "`meniscus x --y 'z'`",
            "\n## a & b\n",
            "\none | two\n",
            "\n> it holds\n",
            "| one | two\\|2 |\n|---|---:|\n| <td> | 2 |\n",
            "| drift | 2.0000e0 | mm | <= 1 | MISSED |",
            "| n | not measured | 1 | informational |  |",
            "\n![c](c.png)\n",
            "\n![a photograph](only.png)\n",
        ] {
            assert!(page.contains(part), "{part:?} is missing in {page}");
        }
        assert!(!page.contains("<svg"));
    }

    #[test]
    fn text_is_aligned_and_json_has_the_checks_alone() {
        let text = report().text();
        assert!(text.contains("  one   two|2\n  <td>      2\n"), "{text}");
        assert!(text.contains("  drift") && text.contains("MISSED"));
        let json = report().json();
        assert_eq!(json["checks"].as_array().map(Vec::len), Some(2));
        assert_eq!(
            json["checks"][0],
            json!({ "name": "drift", "value": 2.0, "unit": "mm", "target": "<= 1", "ok": false })
        );
        assert!(json["checks"][1]["value"].is_null());
    }

    #[test]
    fn a_chart_of_nothing_is_refused_and_one_value_is_drawn() {
        let chart = |points| {
            let series = [Series { name: "n", points, mark: Mark::Dots, colour: 1 }];
            Chart { caption: "c", x: "x", y: "y", series: &series }.svg().map(|svg| svg.contains("<circle"))
        };
        assert!(chart(&[]).is_err() && chart(&[(f64::NAN, 1.0)]).is_err());
        assert!(chart(&[(1.0, 1.0)]).is_ok_and(|drawn| drawn));
    }
}
