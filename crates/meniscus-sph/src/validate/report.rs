//! The table as a page of Markdown, and as one HTML file.

use super::Outcome;
use super::plots::expected;
use meniscus_report::html::{Chart, Mark, Report, Series};
use meniscus_report::plot::PictureError;

/// The page: program and machine, the table, and the decays with their pictures, whose files are
/// named `picture(index)`.
#[must_use]
pub fn markdown(outcome: &Outcome, command: &str, picture: impl Fn(usize) -> String) -> String {
    let mut page = format!(
        "# The simulator against theory\n\nmeniscus {}, `{command}`, on {}.\n\n| check | value | unit | target | |\n\
         |---|---|---|---|---|\n",
        env!("CARGO_PKG_VERSION"),
        machine()
    );
    for check in &outcome.checks {
        let value = check.value.map_or("not measured".into(), |value| format!("{value:.4e}"));
        let verdict = if check.ok { "ok" } else { "MISSED" };
        page += &format!("| {} | {value} | {} | {} | {verdict} |\n", check.name, check.unit, check.target);
    }
    page += "\nFirst mode, started at 0.05 m/s and fitted from 0.05 s on. Theory is linear: the inviscid dispersion \
             relation, or a Ritz solution of the linearised Navier-Stokes equations (contact line pinned where walls \
             do not slip, free where they do). `mode2_frequency_error` is at 5 mm, `mode2_frequency_error_fine` at \
             3.5 mm.\n\n\
             | case | frequency, Hz | theory | error | decay, 1/s | theory |\n|---|---|---|---|---|---|\n";
    for ringing in &outcome.ringings {
        let (fit, theory) = (ringing.fit.tone, ringing.theory);
        page += &format!(
            "| {} | {:.3} | {:.3} | {:+.2} % | {:.3} | {:.3} |\n",
            ringing.name,
            fit.hz,
            theory.hz,
            ringing.frequency_error(),
            fit.decay,
            theory.decay
        );
    }
    if !outcome.held.is_empty() {
        page += "\nEffects at 5 mm:\n\n| effect | measured | value | theory | deviation |\n|---|---|---|---|---|\n";
    }
    for (name, held) in &outcome.held {
        let (what, measured, theory) = (held.what, held.measured, held.theory);
        page += &format!("| {name} | {what} | {measured:.4} | {theory:.4} | {:+.1} % |\n", held.error());
    }
    for (index, ringing) in outcome.ringings.iter().enumerate() {
        page += &format!("\n![{}]({})\n", ringing.name, picture(index));
    }
    page
}

/// The same as one HTML file, with the decays in it.
///
/// # Errors
/// [`PictureError`], when a decay cannot be drawn.
pub fn html(outcome: &Outcome, command: &str) -> Result<String, PictureError> {
    let mut report = Report::new("The simulator against theory", command);
    report.prose(&format!("On {}.", machine()));
    report.checks(&outcome.checks);
    report.heading("The first mode");
    report.prose(
        "Started at 0.05 m/s and fitted from 0.05 s on. Theory is linear: the inviscid dispersion relation, or a Ritz \
         solution of the linearised Navier-Stokes equations.",
    );
    for ringing in &outcome.ringings {
        let (fit, theory) = (ringing.fit.tone, ringing.theory);
        let over = |curve: &super::Fit| -> Vec<(f64, f64)> {
            ringing.series.iter().map(|(t, _)| (*t, curve.at(*t))).collect()
        };
        let (fitted, expected) = (over(&ringing.fit), over(&expected(ringing)));
        let caption = format!(
            "{}: {:.3} Hz and {:.3} /s measured, {:.3} Hz and {:.3} /s by theory.",
            ringing.name, fit.hz, fit.decay, theory.hz, theory.decay
        );
        report.chart(&Chart {
            caption: &caption,
            x: "time, s",
            y: "modal momentum, 1 at the start",
            series: &[
                Series { name: "simulator", points: &ringing.series, mark: Mark::Dots, colour: 0 },
                Series { name: "theory", points: &expected, mark: Mark::Line, colour: 2 },
                Series { name: "fit", points: &fitted, mark: Mark::Line, colour: 1 },
            ],
        })?;
    }
    if !outcome.held.is_empty() {
        report.heading("Effects at 5 mm");
        let row = |(name, held): &(&str, super::Held)| {
            vec![
                String::from(*name),
                String::from(held.what),
                format!("{:.4}", held.measured),
                format!("{:.4}", held.theory),
                format!("{:+.1}", held.error()),
            ]
        };
        let rows: Vec<_> = outcome.held.iter().map(row).collect();
        report.table(&["effect", "measured", "value", "theory", "deviation, %"], &rows);
    }
    Ok(report.html())
}

/// Processor and operating system, as far as the system tells.
fn machine() -> String {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let told = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = told.lines().find_map(|line| line.strip_prefix("model name")?.split_once(": "));
    let model = model.map_or("a processor of unknown name", |(_, name)| name);
    format!("{model} ({threads} threads, {} {})", std::env::consts::ARCH, std::env::consts::OS)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::validate::{Fit, Ringing, Tone};
    use meniscus_report::checks::Check;

    #[test]
    fn the_page_says_what_was_missed_and_by_how_much() {
        let checks = vec![Check::at_most("rest_noise", 3.5, "mm/s", 2.0)];
        let fit = Fit { tone: Tone { hz: 3.5, decay: 0.2 }, amplitude: [1.0, 0.0] };
        let theory = Tone { hz: 3.6, decay: 0.0 };
        let ringing = Ringing { name: "mercury".into(), series: Vec::new(), fit, theory, cost: 1.0 };
        let page = markdown(&Outcome { checks, ringings: vec![ringing], held: Vec::new() }, "try", |i| {
            format!("{i}.png")
        });
        for part in
            ["`try`", "| rest_noise | 3.5000e0 | mm/s | <= 2 | MISSED |", "| -2.78 % |", "![mercury](0.png)"]
        {
            assert!(page.contains(part), "{part} is missing in {page}");
        }
    }
}
