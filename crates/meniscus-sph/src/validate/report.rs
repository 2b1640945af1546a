//! The table of the validation as a report, with the decays behind it.

use super::plots::expected;
use super::{Fit, Held, Outcome, Ringing};
use meniscus_report::plot::PictureError;
use meniscus_report::{Chart, Mark, Report, Series};

/// Returns the report: machine, checks, decays with their plots, effects. The picture of a decay also lies in the file
/// `picture(index)` beside it (see [`super::decay_png`]).
///
/// # Errors
/// [`PictureError`], when a decay cannot be drawn.
pub fn report(
    outcome: &Outcome,
    command: &str,
    picture: impl Fn(usize) -> String,
) -> Result<Report, PictureError> {
    let mut report = Report::new("The simulator against theory", command);
    report.prose(&format!("On {}.", machine()));
    report.checks(&outcome.checks);
    report.heading("The first mode");
    report.prose(
        "Started at 0.05 m/s and fitted from 0.05 s on. Theory is linear: the inviscid dispersion relation, or a Ritz \
         solution of the linearised Navier-Stokes equations (contact line pinned where walls do not slip, free where they \
         do). mode2_frequency_error is at 5 mm, mode2_frequency_error_fine at 3.5 mm.",
    );
    let rows: Vec<_> = outcome.ringings.iter().map(decay_row).collect();
    report.table(&["case", "frequency, Hz", "theory", "error, %", "decay, 1/s", "theory"], &rows);
    for (index, ringing) in outcome.ringings.iter().enumerate() {
        add_decay(&mut report, ringing, &picture(index))?;
    }
    if !outcome.held.is_empty() {
        report.heading("Effects at 5 mm");
        let rows: Vec<_> = outcome.held.iter().map(|(name, held)| effect_row(name, held)).collect();
        report.table(&["effect", "measured", "value", "theory", "deviation, %"], &rows);
    }
    Ok(report)
}

fn decay_row(ringing: &Ringing) -> Vec<String> {
    let (fit, theory) = (ringing.fit.tone, ringing.theory);
    vec![
        ringing.name.clone(),
        format!("{:.3}", fit.hz),
        format!("{:.3}", theory.hz),
        format!("{:+.2}", ringing.frequency_error()),
        format!("{:.3}", fit.decay),
        format!("{:.3}", theory.decay),
    ]
}

fn effect_row(name: &str, held: &Held) -> Vec<String> {
    vec![
        name.into(),
        held.what.into(),
        format!("{:.4}", held.measured),
        format!("{:.4}", held.theory),
        format!("{:+.1}", held.error()),
    ]
}

/// Adds what the simulator did, what was fitted to it, and what theory expects.
fn add_decay(report: &mut Report, ringing: &Ringing, file: &str) -> Result<(), PictureError> {
    let (fit, theory) = (ringing.fit.tone, ringing.theory);
    let over =
        |curve: &Fit| -> Vec<(f64, f64)> { ringing.series.iter().map(|(t, _)| (*t, curve.at(*t))).collect() };
    let (fitted, expected) = (over(&ringing.fit), over(&expected(ringing)));
    let caption = format!(
        "{}: {:.3} Hz and {:.3} /s measured, {:.3} Hz and {:.3} /s by theory.",
        ringing.name, fit.hz, fit.decay, theory.hz, theory.decay
    );
    let chart = Chart {
        caption: &caption,
        x: "time, s",
        y: "modal momentum, 1 at the start",
        series: &[
            Series { name: "simulator", points: &ringing.series, mark: Mark::Dots, colour: 0 },
            Series { name: "theory", points: &expected, mark: Mark::Line, colour: 2 },
            Series { name: "fit", points: &fitted, mark: Mark::Line, colour: 1 },
        ],
    };
    report.chart_beside(&chart, file)
}

/// Processor and operating system, as far as the system tells.
fn machine() -> String {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let cpuinfo = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = cpuinfo.lines().find_map(|line| line.strip_prefix("model name")?.split_once(": "));
    let model = model.map_or("a processor of unknown name", |(_, name)| name);
    format!("{model} ({threads} threads, {} {})", std::env::consts::ARCH, std::env::consts::OS)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::validate::Tone;
    use meniscus_report::checks::Check;

    #[test]
    fn every_form_has_what_was_missed_and_the_decay() {
        let checks = vec![Check::at_most("rest_noise", 3.5, "mm/s", 2.0)];
        let fit = Fit { tone: Tone { hz: 3.5, decay: 0.2 }, amplitude: [1.0, 0.0] };
        let theory = Tone { hz: 3.6, decay: 0.0 };
        let series = (0..50).map(|i| 0.01 * f64::from(i)).map(|t| (t, fit.at(t))).collect();
        let ringing = Ringing { name: "mercury".into(), series, fit, theory, cost: 1.0 };
        let outcome = Outcome { checks, ringings: vec![ringing], held: Vec::new() };
        let report = report(&outcome, "try", |i| format!("{i}.png")).expect("a decay can be drawn");
        let page = report.markdown();
        for part in [
            "`try`",
            "| rest_noise | 3.5000e0 | mm/s | <= 2 | MISSED |",
            "| mercury | 3.500 | 3.600 | -2.78 | 0.200 | 0.000 |",
            "](0.png)",
        ] {
            assert!(page.contains(part), "{part} is missing in {page}");
        }
        assert!(report.html().contains("<svg") && !report.html().contains("0.png"));
        assert_eq!(report.json()["checks"][0]["ok"], false);
    }
}
