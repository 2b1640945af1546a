//! One report as one HTML file that stands alone: what made it, prose, tables, checks and plots, nothing from elsewhere.
//!
//! It reads on a screen and in print; lines are told apart by colour (Okabe and Ito 2008) and by their name in the
//! legend. Text is escaped here: callers hand over plain words.

mod chart;

pub use chart::{Chart, Mark, Series};

use crate::checks::Check;
use crate::plot::PictureError;
use std::fmt::Write;

const STYLE: &str = "body{font:16px/1.5 sans-serif;max-width:60em;margin:2em auto;padding:0 1em;color:#222}\
h1{margin-bottom:.2em}table{border-collapse:collapse;margin:1em 0}\
td,th{padding:.2em .7em;border-bottom:1px solid #ddd;text-align:right}td:first-child,th:first-child{text-align:left}\
tr.missed td:last-child{font-weight:bold;color:#a33f00}pre{background:#f4f4f4;padding:.6em;white-space:pre-wrap}\
.answer{font-size:1.2em;background:#eef4fb;padding:.8em;border-left:6px solid #0072b2}\
figure{margin:1em 0}figcaption,footer{color:#555;font-size:.9em}svg{max-width:100%;height:auto}\
@media print{body{margin:0;max-width:none;font-size:11pt}figure,tr{break-inside:avoid}h2{break-after:avoid}}";

/// A report in the making.
#[derive(Clone, Debug)]
pub struct Report {
    title: String,
    command: String,
    body: String,
}

impl Report {
    /// A report that `command` makes again.
    #[must_use]
    pub fn new(title: &str, command: &str) -> Self {
        Self { title: title.into(), command: command.into(), body: String::new() }
    }

    /// A heading.
    pub fn heading(&mut self, text: &str) {
        self.put(&format!("<h2>{}</h2>", escaped(text)));
    }

    /// A paragraph.
    pub fn prose(&mut self, text: &str) {
        self.put(&format!("<p>{}</p>", escaped(text)));
    }

    /// What came out, in a sentence that stands apart.
    pub fn answer(&mut self, text: &str) {
        self.put(&format!("<p class=\"answer\">{}</p>", escaped(text)));
    }

    /// A drawing that is no plot, as an `svg` element, with its caption.
    pub fn drawing(&mut self, svg: &str, caption: &str) {
        self.put(&format!("<figure>{svg}<figcaption>{}</figcaption></figure>", escaped(caption)));
    }

    /// A table; the first column stands to the left.
    pub fn table(&mut self, head: &[&str], rows: &[Vec<String>]) {
        let cells = |tag: &str, texts: &mut dyn Iterator<Item = &str>| -> String {
            texts.map(|text| format!("<{tag}>{}</{tag}>", escaped(text))).collect()
        };
        let mut table = format!("<table><tr>{}</tr>", cells("th", &mut head.iter().copied()));
        for row in rows {
            // Writing into a string cannot fail.
            let _ = write!(table, "<tr>{}</tr>", cells("td", &mut row.iter().map(String::as_str)));
        }
        self.put(&(table + "</table>"));
    }

    /// The checks with their verdicts.
    pub fn checks(&mut self, checks: &[Check]) {
        let mut table = String::from(
            "<table><tr><th>check</th><th>value</th><th>unit</th><th>target</th><th>verdict</th></tr>",
        );
        for check in checks {
            let value = check.value.map_or("not measured".into(), |value| format!("{value:.4e}"));
            let (class, verdict) = if check.ok { ("", "ok") } else { (" class=\"missed\"", "missed") };
            let _ = write!(
                table,
                "<tr{class}><td>{}</td><td>{value}</td><td>{}</td><td>{}</td><td>{verdict}</td></tr>",
                escaped(&check.name),
                escaped(check.unit),
                escaped(&check.target)
            );
        }
        self.put(&(table + "</table>"));
    }

    /// A plot with its caption.
    ///
    /// # Errors
    /// [`PictureError`], when the chart has no range to draw.
    pub fn chart(&mut self, chart: &Chart<'_>) -> Result<(), PictureError> {
        self.drawing(&chart.svg()?, chart.caption);
        Ok(())
    }

    /// The page.
    #[must_use]
    pub fn html(&self) -> String {
        let (title, command) = (escaped(&self.title), escaped(&self.command));
        format!(
            "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" \
             content=\"width=device-width\"><title>{title}</title><style>{STYLE}</style></head><body>\n\
             <h1>{title}</h1>\n<pre>{command}</pre>\n{}<footer>meniscus {}</footer>\n</body></html>\n",
            self.body,
            env!("CARGO_PKG_VERSION")
        )
    }

    fn put(&mut self, html: &str) {
        self.body.push_str(html);
        self.body.push('\n');
    }
}

/// Text with the five characters of HTML spelt out.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for sign in text.chars() {
        match sign {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            sign => out.push(sign),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_stands_alone_and_escapes_what_it_is_told() {
        let mut report = Report::new("<script>", "meniscus x --y 'z'");
        report.heading("a & b");
        report.table(&["one", "two"], &[vec!["<td>".into(), "2".into()]]);
        report.checks(&[Check::at_most("drift", 2.0, "mm", 1.0), Check::informational("n", f64::NAN, "1")]);
        let curve =
            Series { name: "before <1>", points: &[(0.0, 1.0), (1.0, 3.0)], mark: Mark::Line, colour: 0 };
        let chart = Chart { caption: "c", x: "t, s", y: "error, %", series: &[curve] };
        report.chart(&chart).expect("it has a range");
        let html = report.html();
        assert!(html.contains("&lt;script&gt;") && !html.contains("<script"), "{html}");
        assert!(
            html.contains("--y &#39;z&#39;") && html.contains("a &amp; b") && html.contains("&lt;td&gt;")
        );
        assert!(html.contains("class=\"missed\"") && html.contains("not measured"));
        assert!(
            html.contains("<svg") && html.contains("<polyline") && html.contains("before &lt;1&gt;"),
            "{html}"
        );
        assert!(
            !html.contains("http://")
                || html.matches("http://").count() == html.matches("http://www.w3.org").count()
        );
        assert!(!html.contains("src=") && !html.contains("href="));
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
