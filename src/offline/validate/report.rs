//! The table as a page of Markdown.

use super::Outcome;
use crate::offline::prelude::*;

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
             do not slip, free where they do).\n\n\
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
        page += "\nEffects at 7 mm:\n\n| effect | measured | value | theory | deviation |\n|---|---|---|---|---|\n";
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
    use crate::host::checks::Check;
    use crate::offline::validate::{Fit, Ringing, Tone};

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
