//! Page of the study: checks, then every trial.

use super::bench::Judged;
use super::plans::{Answer, Family};
use super::run::JudgedTrial;
use super::tally::{StudyTally, class_right, right};
use meniscus_report::checks::Check;
use std::fmt::Write;

/// The families in the order of the page.
const TITLES: [(Family, &str); 7] = [
    (Family::Hidden, "One effect hidden"),
    (Family::Fresh, "One effect hidden, in a glass that was not looked at while rules were made"),
    (Family::Asked, "Ambiguous trials with the recordings that were suggested"),
    (Family::Without, "The true effect taken out of the library"),
    (Family::Pair, "Two effects at once"),
    (Family::Clean, "Nothing hidden"),
    (Family::Noise, "Nothing hidden, noise misjudged by half"),
];

/// Returns the page of `study`, which `command` makes again.
#[must_use]
pub fn markdown(study: &StudyTally, checks: &[Check], command: &str) -> String {
    let mut out = format!("# The study of discovery\n\nMade by `{command}`.");
    // Writing into a string cannot fail.
    if !study.is_whole() {
        out.push_str(" **Not all planned trials are judged:**");
    }
    out.push_str("\n\n| trials | judged | planned |\n|---|---|---|\n");
    for (family, title) in TITLES {
        let planned = study.planned.get(&family).copied().unwrap_or(0);
        let _ = writeln!(out, "| {title} | {} | {planned} |", study.of(family).count());
    }
    out.push_str("\n| check | value | target | |\n|---|---|---|---|\n");
    for check in checks {
        let value = check.value.map_or("not measured".into(), |v| format!("{v:.3} {}", check.unit));
        let mark = match (check.value, check.ok) {
            (None, _) => "",
            (_, true) => "met",
            (_, false) => "**missed**",
        };
        let mark = if check.target == "told" { "" } else { mark };
        let _ = writeln!(out, "| `{}` | {value} | {} | {mark} |", check.name, check.target);
    }
    out.push_str("\n![what was hidden and what was said](confusion.png)\n");
    // Curves of one size are none.
    if study.of(Family::Hidden).any(|(answer, _)| answer.size != 1.0) {
        out.push_str("\n![gain by size](detection.png)\n");
    }
    for (family, title) in TITLES {
        let lines: Vec<&JudgedTrial> = study.of(family).collect();
        if lines.is_empty() {
            continue;
        }
        let planned = study.planned.get(&family).copied().unwrap_or(0);
        let _ = writeln!(out, "\n## {title}\n\n{} of {planned} planned.\n", lines.len());
        if matches!(family, Family::Clean | Family::Noise) {
            blank(&mut out, &lines);
            continue;
        }
        out.push_str(
            "| truth | size | verdict | said | class | gain | needed | misfit without, with | estimate (90 %) | gap, mm: \
             untouched, refitted, black box, effect, oracle |\n|---|---|---|---|---|---|---|---|---|---|\n",
        );
        for (answer, judged) in lines {
            row(&mut out, answer, judged);
        }
    }
    for result in study.beside.measured.iter().flatten() {
        let [before, after] = result.means_mm();
        let _ = writeln!(
            out,
            "\n## Measured water: {}\n\n{} Mean error {before:.2} mm before, {after:.2} mm after.\n\n| run | before, mm | after, mm |\n|---|---|---|",
            result.title, result.sentence
        );
        for (name, before, after) in &result.runs {
            let _ = writeln!(out, "| {name} | {:.2} | {:.2} |", 1e3 * before, 1e3 * after);
        }
    }
    out
}

/// Trials with nothing hidden, one line a glass.
fn blank(out: &mut String, lines: &[&JudgedTrial]) {
    out.push_str("| glass | trials | none | tied | unknown | named | said | largest gain |\n|---|---|---|---|---|---|---|---|\n");
    let mut glasses: Vec<&str> = lines.iter().map(|(answer, _)| answer.glass.as_str()).collect();
    glasses.sort_unstable();
    glasses.dedup();
    for glass in glasses {
        let mine: Vec<&Judged> = lines.iter().filter(|(a, _)| a.glass == glass).map(|(_, j)| j).collect();
        let of = |word: &str| mine.iter().filter(|j| j.verdict == word).count();
        let mut said: Vec<&str> =
            mine.iter().filter(|j| j.verdict != "none").flat_map(|j| &j.names).map(String::as_str).collect();
        said.sort_unstable();
        said.dedup();
        let most = mine.iter().filter_map(|j| j.best.as_ref()).max_by(|a, b| a.1.total_cmp(&b.1));
        let most = most.map_or(String::new(), |(name, gain)| format!("{gain:.0} ({name})"));
        // Writing into a string cannot fail.
        let _ = writeln!(
            out,
            "| {glass} | {} | {} | {} | {} | {} | {} | {most} |",
            mine.len(),
            of("none"),
            of("tied"),
            of("unknown"),
            of("named"),
            said.join(", ")
        );
    }
}

fn row(out: &mut String, answer: &Answer, judged: &Judged) {
    let truth: Vec<String> =
        answer.effects.iter().map(|(name, value)| format!("{name} {value:.3}")).collect();
    let estimate = judged
        .estimate
        .as_ref()
        .map_or(String::new(), |(name, v, a, b)| format!("{name} {v:.4} ({a:.4} to {b:.4})"));
    let gap = judged.gap_mm.map_or(String::new(), |g| g.map(|v| format!("{v:.2}")).join(", "));
    let oracle = judged.oracle_mm.map_or(String::new(), |mm| format!(", {mm:.2}"));
    let mark = match judged.verdict.as_str() {
        _ if right(answer, judged) => "**named**",
        "named" if class_right(answer, judged) == Some(true) => "named, of its class",
        "named" => "named, wrong",
        other => other,
    };
    // Writing into a string cannot fail.
    let _ = writeln!(
        out,
        "| {} | {} | {mark} | {} | {} | {:.0} | {} | {:.2}, {:.2} | {estimate} | {gap}{oracle} |",
        truth.join(" + "),
        answer.size,
        judged.names.join(", "),
        judged.class.as_deref().unwrap_or(""),
        judged.gain,
        judged.bound.map_or(String::new(), |bound| format!("{bound:.0}")),
        judged.misfit[0],
        judged.misfit[1]
    );
}
