//! The page of a discovery, on the report that every command shares.

use super::drawings::{disagreement, likeness, ranking};
use super::verdict::Decision;
use super::workflow::Discovery;
use crate::insert::Closed;
use meniscus_report::html::{Chart, Mark, Report, Series};
use meniscus_report::plot::PictureError;

/// The page, which `command` makes again; `closed` are the other models that the effect was put into.
///
/// # Errors
/// [`PictureError`], when the sealed recording has no number to draw.
pub fn page(discovery: &Discovery, closed: &[Closed], command: &str) -> Result<String, PictureError> {
    let verdict = &discovery.verdict;
    let mut report = Report::new(&format!("Discovery: {}", verdict.decision.word()), command);
    report.answer(&verdict.sentence());
    report.prose(&format!(
        "Fitted: {}. Sealed: {}. References: {} glasses of a known liquid{}.",
        discovery.split.fitted.iter().map(|r| r.name.as_str()).collect::<Vec<_>>().join(", "),
        discovery.split.held_out.as_ref().map_or("none (fewer than four recordings)", |r| r.name.as_str()),
        discovery.calibration.groups,
        if discovery.calibration.groups < 2 { "; the verdict is much weaker without them" } else { "" }
    ));
    ranked(&mut report, discovery);
    parameters(&mut report, discovery);
    sealed(&mut report, discovery)?;
    others(&mut report, closed);
    question(&mut report, discovery);
    map(&mut report, discovery);
    matrix(&mut report, discovery);
    Ok(report.html())
}

fn ranked(report: &mut Report, discovery: &Discovery) {
    let verdict = &discovery.verdict;
    report.heading("Ranking");
    // Nothing won where nothing is believed.
    let firmness = if verdict.held_out.1 > 0 {
        format!(
            " The first won {:.0} % of the bootstrap; {} of {} recordings are foretold better when they are left out of \
             the fit.",
            100.0 * verdict.inclusion,
            verdict.held_out.0,
            verdict.held_out.1
        )
    } else {
        String::new()
    };
    report.prose(&format!(
        "Gain in BIC over no effect. Believed from {:.0} and from what clean glasses show of the same effect; the second \
         has to stay {:.0} behind, {:.0} in the same class.{firmness} Misfit {:.2} without, {:.2} with; at most \
         {:.2} beside an effect, {:.2} where none is believed.",
        discovery.limits.gain,
        discovery.rules.min_gap_other_class,
        discovery.rules.min_gap_same_class,
        verdict.plain.chi2(verdict.count),
        verdict.chi2,
        discovery.limits.chi2,
        discovery.limits.clean_chi2
    ));
    report.drawing(&ranking(discovery), "Blue: what is said. Orange mark: what it has to reach.");
}

fn parameters(report: &mut Report, discovery: &Discovery) {
    if discovery.verdict.decision == Decision::None || discovery.estimates.is_empty() {
        return;
    }
    report.heading("Parameters");
    let row = |e: &super::workflow::Estimate| -> Vec<String> {
        let (least, largest) = e.interval;
        let interval = format!("{least:.4} to {largest:.4}");
        vec![e.effect.into(), e.parameter.into(), format!("{:.4}", e.value), interval, e.unit.into()]
    };
    let rows: Vec<_> = discovery.estimates.iter().map(row).collect();
    report.table(&["effect", "parameter", "value", "90 % interval", "unit"], &rows);
}

fn sealed(report: &mut Report, discovery: &Discovery) -> Result<(), PictureError> {
    let Some(gap) = discovery.gap else { return Ok(()) };
    report.heading("The sealed recording");
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
        discovery.curves.iter().map(|row| (row[0], 1e3 * row[which])).collect()
    };
    let [measured, untouched, effect] = [1, 2, 3].map(column);
    let series = [
        Series { name: "measured", points: &measured, mark: Mark::Dots, colour: 0 },
        Series { name: "untouched", points: &untouched, mark: Mark::Line, colour: 2 },
        Series { name: "with the effect", points: &effect, mark: Mark::Line, colour: 1 },
    ];
    let caption =
        "What is seen most of (slope of the surface, or its highest point), and what the models say.";
    report.chart(&Chart { caption, x: "t, s", y: "mm", series: &series })
}

fn others(report: &mut Report, closed: &[Closed]) {
    if closed.is_empty() {
        return;
    }
    report.heading("The same effect in other models");
    report.prose(
        "The sealed recording from rest, its motion known and nothing else: error of the surface, noise subtracted. No \
         number of these models was fitted to any recording here.",
    );
    let mm = |m: f64| format!("{:.3}", 1e3 * m);
    let row = |c: &Closed| -> Vec<String> { vec![c.model.into(), mm(c.untouched_m), mm(c.effect_m)] };
    let rows: Vec<_> = closed.iter().map(row).collect();
    report.table(&["model", "untouched, mm", "with the effect, mm"], &rows);
}

fn question(report: &mut Report, discovery: &Discovery) {
    let Some(question) = &discovery.question else { return };
    report.heading("What would settle it");
    let [one, two] = &question.between;
    report.prose(&if question.hopeful() {
        format!(
            "Record {}: it parts {one} from {two} by {:.1} times the noise ({} is enough); it costs {:.0} s and nothing \
             else. Looked at:",
            question.motion, question.separation, discovery.rules.decisive_separation, question.seconds
        )
    } else {
        format!("No motion that was looked at parts {one} from {two}: to these recordings both do the same. Looked at:")
    });
    let rows: Vec<_> = question
        .all
        .iter()
        .map(|(motion, parted)| vec![motion.to_string(), format!("{parted:.1}")])
        .collect();
    report.table(&["motion", "parts by"], &rows);
}

fn map(report: &mut Report, discovery: &Discovery) {
    report.heading("Where they disagree");
    report.prose(
        "Misfit of the model without an effect, 1 where it is right; p of so large a one anywhere by chance; in phase is \
         stiffness or scale, in quadrature is damping or time.",
    );
    report.drawing(
        &disagreement(&discovery.map),
        "Misfit by channel and part of the motion; the darker the worse.",
    );
    let row = |cell: &super::localise::Cell| -> Vec<String> {
        let p = if cell.p < 1e-3 { "< 0.001".into() } else { format!("{:.3}", cell.p) };
        let [phase, quadrature] = cell.phase.map(|part| format!("{part:+.2}"));
        let rms = format!("{:.3}", 1e3 * cell.rms_m);
        vec![cell.channel.into(), cell.window.into(), format!("{:.2}", cell.chi2), p, rms, phase, quadrature]
    };
    let rows: Vec<_> = discovery.map.iter().map(row).collect();
    report.table(&["channel", "window", "misfit", "p", "rms, mm", "in phase", "in quadrature"], &rows);
}

fn matrix(report: &mut Report, discovery: &Discovery) {
    let (names, length, cosines) = &discovery.isolability;
    let twins: Vec<String> = (0..names.len())
        .flat_map(|i| (0..i).map(move |j| (i, j)))
        .filter(|(i, j)| {
            let apart = length[*i].min(length[*j]) * (1.0 - cosines[*i][*j].powi(2)).max(0.0).sqrt();
            apart < discovery.rules.decisive_separation
        })
        .map(|(i, j)| format!("{} ~ {}", names[j], names[i]))
        .collect();
    report.heading("What these recordings can tell apart");
    report.prose(&format!(
        "Cosines of the signatures at typical size, with what the baseline can do taken out, and their length over the \
         noise. Not to be told apart at that size: {}.",
        if twins.is_empty() { "none".into() } else { twins.join(", ") }
    ));
    report.drawing(&likeness(names, length, cosines), "Orange: alike (+1). Blue: opposed (-1).");
}
