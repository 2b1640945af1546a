//! The study as a page.

use super::Outcome;
use super::judge::Row;
use meniscus_report::checks::table;

/// Markdown: the table, the checks, what is not covered.
#[must_use]
pub fn markdown(outcome: &Outcome, command: &str) -> String {
    let mut page = format!("# The surface seen by a rendered camera\n\n`{command}`\n\n{}\n", Row::HEAD);
    page += "|---|---|---|---|---|---|---|---|---|---|---|---|\n";
    for row in &outcome.rows {
        page += &row.line();
        page.push('\n');
    }
    page += "\nErrors are of the points that were seen, against the true contact line. `inside` is the share \
             inside the stated interval, `+- mm` its mean half width.\n\n![errors](errors.png)\n\n![scenes](scenes.png)\n";
    page += &format!("\n```text\n{}```\n", table(&outcome.checks));
    if let Err(why) = &outcome.golden {
        page += &format!("\n{why}.\n");
    }
    for trouble in &outcome.unrecovered {
        page += &format!("\nNot as it must be: {trouble}\n");
    }
    page + "\nAll of this is rendered. Not in any figure: refraction by the glass, the meniscus that climbs its \
            wall, the smear of stereo matching at steps in depth, and a camera that stands elsewhere than told.\n"
}
