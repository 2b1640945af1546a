//! Part of the page on sizes by simulation.

use crate::sizing::outcome::{SizedCandidate, Sizing};
use crate::workflow;
use meniscus_report::Report;

/// Adds the sizes by simulation, or why there are none.
pub(super) fn sizing(report: &mut Report, outcome: &workflow::Report) {
    match &outcome.sizing {
        None => {}
        Some(Err(error)) => {
            report.heading("Sizes by simulation");
            report.prose(&format!("There are none: {error}. The sizes are those of the reduced model."));
        }
        Some(Ok(sizing)) => {
            report.heading("Sizes by simulation");
            report.prose(&sizing.sentence());
            sizes(report, sizing);
            spacings(report, sizing);
            scores(report, sizing);
        }
    }
}

fn sizes(report: &mut Report, sizing: &Sizing) {
    let mut rows: Vec<Vec<String>> = Vec::new();
    for candidate in &sizing.candidates {
        for p in &candidate.parameters {
            rows.push(vec![
                format!("{} {}", p.effect, p.parameter),
                format!("{:.4}", p.reduced),
                format!("{:.4}", p.value),
                format!("{:.4} to {:.4}", p.interval.0, p.interval.1),
                p.unit.into(),
            ]);
        }
        if let Some((factor, (least, largest))) = candidate.viscosity {
            let name = format!("viscosity beside {}, factor", candidate.names.join(" + "));
            let interval = format!("{least:.4} to {largest:.4}");
            rows.push(vec![name, "1".into(), format!("{factor:.4}"), interval, "1".into()]);
        }
    }
    report.table(&["parameter", "reduced model", "simulator", "90 % interval", "unit"], &rows);
    for unsized_one in &sizing.not_sized {
        report.prose(&format!("{} was not sized: {}.", unsized_one.names.join(" + "), unsized_one.reason));
    }
}

fn spacings(report: &mut Report, sizing: &Sizing) {
    let row = |candidate: &SizedCandidate| -> Vec<Vec<String>> {
        let name = candidate.names.join(" + ");
        let of = |r: &crate::sizing::outcome::SpacingResult| {
            let sizes: Vec<String> = r.sizes.iter().map(|size| format!("{size:.4}")).collect();
            vec![
                name.clone(),
                format!("{:.2}", 1e3 * r.spacing_m),
                format!("{:.4}", r.value),
                sizes.join(", "),
                format!("{:.2}", r.misfit),
            ]
        };
        candidate.spacings.iter().map(of).collect()
    };
    let rows: Vec<Vec<String>> = sizing.candidates.iter().flat_map(row).collect();
    report.table(&["effect", "spacing, mm", "best size", "sizes that were simulated", "misfit"], &rows);
}

fn scores(report: &mut Report, sizing: &Sizing) {
    report.prose(
        "Squares of the residual over the noise on recordings that the size was not fitted to: each of the fit left out in \
         turn, and the held-out one. The noise holds that of the camera and 2 % of the signal.",
    );
    let mut rows: Vec<Vec<String>> = Vec::new();
    for candidate in &sizing.candidates {
        for score in &candidate.scores.each {
            let per_number = |squares: f64| format!("{:.2}", squares / score.numbers.max(1) as f64);
            rows.push(vec![
                candidate.names.join(" + "),
                score.recording.clone(),
                per_number(score.absent),
                per_number(score.squares),
            ]);
        }
    }
    report.table(&["effect", "recording", "without, per number", "with, per number"], &rows);
    let ratios: Vec<String> = sizing
        .candidates
        .iter()
        .map(|c| format!("{} {:.2}", c.names.join(" + "), c.scores.decisive_ratio()))
        .collect();
    report.prose(&format!("Ratio of squares from which a difference is no chance: {}.", ratios.join(", ")));
}
