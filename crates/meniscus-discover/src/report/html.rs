//! HTML page of a discovery.

use super::drawings::{disagreement, likeness, ranking};
use super::intervals::intervals;
use super::law_page::law;
use super::sizing_page::sizing;
use super::words::{distinction, map_in_words};
use crate::findings::size_error::SizeError;
use crate::findings::suggest::Separation;
use crate::findings::{Estimate, Findings};
use crate::fitting::localise::{Cell, largest};
use crate::workflow;
use crate::workflow::clocks::AlignedClock;
use crate::workflow::insertion::ClosedGap;
use crate::workflow::references::ReferenceOrigin;
use meniscus_report::plot::PictureError;
use meniscus_report::{Chart, Mark, Report, Series};

/// Returns the page of `outcome`, which `command` makes again.
///
/// # Errors
/// [`PictureError`], when the held-out recording has no number to draw.
pub fn page(outcome: &workflow::Report, command: &str) -> Result<String, PictureError> {
    let findings = &outcome.findings;
    let mut report = Report::new(&format!("Discovery: {}", outcome.word()), command);
    report.answer(&outcome.sentence());
    report.prose(&format!(
        "Fitted: {}. Held out: {}. References: {} glasses of {}{}.",
        findings.split.fitted.iter().map(|r| r.name.as_str()).collect::<Vec<_>>().join(", "),
        findings.split.held_out.as_ref().map_or("none (fewer than four recordings)", |r| r.name.as_str()),
        findings.calibration.groups,
        if outcome.origin == ReferenceOrigin::Simulator { "the simulator" } else { "a known liquid" },
        match findings.calibration.groups {
            0 => "; the verdict is much weaker without them",
            1 => "; a single one says nothing of how clean glasses differ",
            _ => "",
        }
    ));
    for refusal in outcome.clocks.iter().filter_map(AlignedClock::refusal) {
        report.prose(&format!("Left out: {refusal}."));
    }
    law(&mut report, outcome)?;
    ranked(&mut report, findings);
    sizing(&mut report, outcome);
    parameters(&mut report, findings);
    held_out(&mut report, findings)?;
    other_models(&mut report, &outcome.insertion.closed);
    suggestion(&mut report, findings);
    map(&mut report, findings);
    matrix(&mut report, findings);
    Ok(report.html())
}

fn ranked(report: &mut Report, findings: &Findings) {
    let (verdict, search) = (&findings.assessment.verdict, &findings.assessment.search);
    report.heading("Ranking");
    // Nothing won where no effect is significant.
    let firmness = verdict.claim().map_or(String::new(), |claim| {
        format!(
            " The first won {:.0} % of the bootstrap; {} of {} recordings are predicted better when they are left out \
             of the fit.",
            100.0 * claim.inclusion,
            claim.held_out.better,
            claim.held_out.recordings
        )
    });
    report.prose(&format!(
        "Gain in BIC over no effect. Significant from {:.0} and from what clean glasses show of the same effect; the second \
         has to stay {:.0} behind, {:.0} in the same class.{firmness} Misfit {:.2} without, {:.2} with; at most \
         {:.2} beside an effect, {:.2} where none is significant.",
        findings.limits.gain,
        findings.rules.min_gap_other_class,
        findings.rules.min_gap_same_class,
        search.plain.chi2(search.count),
        verdict.misfit(),
        findings.limits.chi2,
        findings.limits.clean_chi2
    ));
    report.drawing(
        &ranking(findings),
        "Blue: effects of the verdict. Orange mark: gain that each has to reach.",
    );
}

fn parameters(report: &mut Report, findings: &Findings) {
    if findings.estimates.is_empty() {
        return;
    }
    report.heading("Parameters of the reduced model");
    let row = |e: &Estimate| -> Vec<String> {
        let (least, largest) = e.interval;
        let interval = format!("{least:.4} to {largest:.4}");
        vec![e.effect.into(), e.parameter.into(), format!("{:.4}", e.value), interval, e.unit.into()]
    };
    let rows: Vec<_> = findings.estimates.iter().chain(&findings.rivals).map(row).collect();
    report.table(&["effect", "parameter", "value", "90 % interval", "unit"], &rows);
    if !findings.rivals.is_empty() {
        report.prose("The verdict is tied: each effect has the size that it has if it alone is missing.");
    }
    report.drawing(
        &intervals(&findings.estimates),
        "Blue: size. Grey: 90 % interval. Orange mark: the effect is absent.",
    );
    for estimate in findings.estimates.iter().filter(|e| e.size_error != SizeError::EXACT) {
        report.prose(&format!(
            "The size of {} comes from a formula. True sizes were up to {:.2} times the one found, in every simulator that was \
             tried: the interval holds that.",
            estimate.effect, estimate.size_error.largest
        ));
    }
}

fn held_out(report: &mut Report, findings: &Findings) -> Result<(), PictureError> {
    let Some(measured) = &findings.gap else { return Ok(()) };
    let gap = measured.gap;
    report.heading("The held-out recording");
    report.prose(&format!(
        "Root mean square error of the surface, noise ({:.3} mm) subtracted. It took no part in anything above.",
        1e3 * gap.noise
    ));
    let rows = [
        ("untouched", gap.untouched),
        ("nuisances fitted again", gap.refitted),
        ("black-box correction", gap.black_box),
        ("with the effect", gap.effect),
    ];
    let rows: Vec<_> = rows.map(|(name, m)| vec![name.into(), format!("{:.3}", 1e3 * m)]).into();
    report.table(&["model", "mm"], &rows);
    let column = |which: usize| -> Vec<(f64, f64)> {
        measured.curves.iter().map(|row| (row[0], 1e3 * row[which])).collect()
    };
    let [measured, untouched, effect] = [1, 2, 3].map(column);
    let series = [
        Series { name: "measured", points: &measured, mark: Mark::Dots, colour: 0 },
        Series { name: "untouched", points: &untouched, mark: Mark::Line, colour: 2 },
        Series { name: "with the effect", points: &effect, mark: Mark::Line, colour: 1 },
    ];
    let caption = "Slope of the surface, or its highest point: measured, and as the models predict it.";
    report.chart(&Chart { caption, x: "t, s", y: "mm", series: &series })?;
    let left = |model: &[(f64, f64)]| -> Vec<(f64, f64)> {
        measured.iter().zip(model).map(|((t, seen), (_, expected))| (*t, seen - expected)).collect()
    };
    let (before, after) = (left(&untouched), left(&effect));
    let series = [
        Series { name: "untouched", points: &before, mark: Mark::Line, colour: 2 },
        Series { name: "with the effect", points: &after, mark: Mark::Line, colour: 1 },
    ];
    let caption = "Residual: measured less predicted.";
    report.chart(&Chart { caption, x: "t, s", y: "mm", series: &series })
}

fn other_models(report: &mut Report, closed: &[ClosedGap]) {
    if closed.is_empty() {
        return;
    }
    report.heading("The same effect in other models");
    report.prose(
        "Error of the surface on the held-out recording, noise subtracted. The models start from rest and get the motion \
         alone; none of their numbers was fitted to a recording here.",
    );
    let mm = |m: f64| format!("{:.3}", 1e3 * m);
    let row = |c: &ClosedGap| -> Vec<String> { vec![c.model.into(), mm(c.untouched_m), mm(c.effect_m)] };
    let rows: Vec<_> = closed.iter().map(row).collect();
    report.table(&["model", "untouched, mm", "with the effect, mm"], &rows);
}

fn suggestion(report: &mut Report, findings: &Findings) {
    let Some(suggestion) = &findings.suggestion else { return };
    report.heading("Suggested recording");
    let [one, two] = &suggestion.between;
    report.prose(&if suggestion.hopeful() {
        format!(
            "Record {}: it separates {one} from {two} by {:.1} times the noise ({} is enough) and takes {:.0} s. Motions that \
             were considered:",
            suggestion.motion, suggestion.separation, findings.rules.decisive_separation, suggestion.seconds
        )
    } else {
        format!("No motion that was considered separates {one} from {two}: both predict the same. Motions that were considered:")
    });
    let row = |s: &Separation| vec![s.motion.clone(), format!("{:.1}", s.separation)];
    let rows: Vec<_> = suggestion.considered.iter().map(row).collect();
    report.table(&["motion", "separation, signal over noise"], &rows);
}

fn map(report: &mut Report, findings: &Findings) {
    report.heading("Map of the discrepancy");
    report.prose(
        "Misfit of the model without an effect, 1 where it is right; p of so large a one anywhere by chance; in phase is \
         stiffness or scale, in quadrature is damping or time.",
    );
    if let Some(cell) = largest(&findings.map) {
        report.prose(&map_in_words(findings, cell));
    }
    report.drawing(
        &disagreement(&findings.map),
        "Misfit by channel and part of the motion; the darker the worse.",
    );
    let row = |cell: &Cell| -> Vec<String> {
        let p = if cell.p < 1e-3 { "< 0.001".into() } else { format!("{:.3}", cell.p) };
        let [phase, quadrature] = cell.phase.map(|part| format!("{part:+.2}"));
        let rms = format!("{:.3}", 1e3 * cell.rms_m);
        vec![cell.channel.into(), cell.window.into(), format!("{:.2}", cell.chi2), p, rms, phase, quadrature]
    };
    let rows: Vec<_> = findings.map.iter().map(row).collect();
    report.table(&["channel", "window", "misfit", "p", "rms, mm", "in phase", "in quadrature"], &rows);
}

fn matrix(report: &mut Report, findings: &Findings) {
    let isolability = &findings.isolability;
    report.heading("Effects that these recordings can distinguish");
    report.prose(&format!(
        "Cosines of the signatures at typical size, without the part that the baseline can reproduce, and their length over \
         the noise. {}",
        distinction(isolability, findings.rules.decisive_separation)
    ));
    let drawing = likeness(&isolability.names, &isolability.lengths, &isolability.cosines);
    report.drawing(&drawing, "Orange: alike (+1). Blue: opposed (-1).");
}
