//! Printed report of a discovery, and the command that makes it again.

use super::Wanted;
use meniscus_discover::findings::Estimate;
use meniscus_discover::fitting::fit_cache::FitCache;
use meniscus_discover::workflow::Report;
use meniscus_discover::workflow::clocks::AlignedClock;
use meniscus_discover::workflow::insertion::FLASHED;
use meniscus_discover::workflow::report::REDUCED;

/// Prints to standard error what could not be done.
pub(super) fn warn(arguments: &Wanted, report: &Report, cache: &FitCache) {
    for refusal in report.clocks.iter().filter_map(AlignedClock::refusal) {
        eprintln!("left out: {refusal}");
    }
    if report.fits.unwritten > 0 {
        eprintln!("{} fits could not be kept in {}", report.fits.unwritten, cache.folder().display());
    }
    if report.insertion.nothing_to_insert {
        eprintln!("no effect was identified, so nothing was inserted into another model");
    }
    for skipped in &report.insertion.skipped {
        let file = arguments.model.as_deref().filter(|_| skipped.model == FLASHED);
        let file = file.map_or(String::new(), |file| format!(" ({file})"));
        eprintln!("not inserted into {}{file}: {}", skipped.model, skipped.reason);
    }
}

/// Returns the command that makes the report again.
pub(super) fn command(arguments: &Wanted) -> String {
    let mut out = format!("meniscus discover --recordings {}", arguments.recordings.display());
    if let Some(reference) = &arguments.reference {
        out += &format!(" --reference {}", reference.display());
    }
    if arguments.no_references {
        out += " --no-references";
    }
    if let Some(model) = &arguments.model {
        out += &format!(" --model {model}");
    }
    if let Some(simulator) = &arguments.simulator {
        out += &format!(" --simulator '{}'", simulator.replace('\'', "'\\''"));
        out += &format!(" --simulator-seconds {}", arguments.simulator_seconds);
    }
    if arguments.simulate {
        out += " --simulate";
    }
    if arguments.quick {
        out += " --quick";
    } else {
        out += &format!(" --packings {} --rivals {}", arguments.packings, arguments.rivals);
    }
    if arguments.simulate || !arguments.quick {
        out += &format!(" --spacing-mm {}", arguments.spacing_mm);
    }
    if !arguments.library.is_empty() {
        out += &format!(" --library {}", arguments.library.join(","));
    }
    out + &format!(" --seed {} --out {}", arguments.seed, arguments.out.display())
}

/// Prints the report to standard output.
pub(super) fn print(report: &Report) {
    let findings = &report.findings;
    println!("{}", report.sentence());
    for p in report.final_sizes() {
        println!(
            "  {} {}: {:.4} {} (90 %: {:.4} to {:.4}) by the {}",
            p.effect, p.parameter, p.value, p.unit, p.interval.0, p.interval.1, p.by
        );
    }
    for e in report.rival_sizes() {
        println!("  or {} by the {REDUCED}", size(e));
    }
    sizes(report);
    if let Some(gap) = findings.gap.as_ref().map(|measured| measured.gap) {
        println!(
            "  held-out recording: {:.3} mm untouched, {:.3} mm with nuisances fitted again, {:.3} mm with a black box, \
             {:.3} mm with the effect",
            1e3 * gap.untouched,
            1e3 * gap.refitted,
            1e3 * gap.black_box,
            1e3 * gap.effect
        );
    }
    if let Some(suggestion) = &findings.suggestion {
        let [one, two] = &suggestion.between;
        if suggestion.hopeful() {
            println!(
                "  to decide, record {}: it separates them by {:.1} times the noise",
                suggestion.motion, suggestion.separation
            );
        } else {
            println!("  no motion that was considered separates {one} from {two}");
        }
    }
    law(report);
    for closed in &report.insertion.closed {
        println!(
            "  {}: {:.3} mm untouched, {:.3} mm with the effect",
            closed.model,
            1e3 * closed.untouched_m,
            1e3 * closed.effect_m
        );
    }
    if let Some(sizing) = report.sizes() {
        let (taken, made) = sizing.simulations;
        println!(
            "simulations: {taken} taken from an earlier round or run, {made} made, {:.0} s",
            sizing.seconds
        );
    }
    if report.fits.reused > 0 {
        println!("fits: {} taken from an earlier run, {} made", report.fits.reused, report.fits.computed);
    }
}

/// Prints what a drawn law closes of the gap, and the recording that would help.
fn law(report: &Report) {
    let Some(drawn) = report.drawn() else { return };
    if let Some(gap) = &drawn.gap {
        println!("  held-out recording with the drawn law: {:.3} mm", 1e3 * gap.law_m);
    }
    match &drawn.suggestion {
        Some(suggestion) if suggestion.hopeful() => {
            let [one, two] = &suggestion.between;
            println!(
                "  to learn more, record {}: it separates {one} from {two} by {:.1} times the noise",
                suggestion.motion, suggestion.separation
            );
        }
        Some(suggestion) => {
            println!("  no motion that was considered separates {}", suggestion.between.join(" from "));
        }
        None => {}
    }
    println!("  curves and bands: report.html, and \"law\" in verdict.json");
}

/// Returns a size with its interval.
fn size(e: &Estimate) -> String {
    let (least, largest) = e.interval;
    format!("{} {}: {:.4} {} (90 %: {least:.4} to {largest:.4})", e.effect, e.parameter, e.value, e.unit)
}

/// Prints the sizes of the reduced model and of the rivals beside those of the simulator.
fn sizes(report: &Report) {
    let Some(sizing) = report.sizes() else { return };
    for e in &report.findings.estimates {
        println!("  the reduced model: {}", size(e));
    }
    for candidate in &sizing.candidates {
        let names = candidate.names.join(" + ");
        let per_spacing: Vec<String> = candidate
            .spacings
            .iter()
            .map(|r| format!("{:.4} at {:.1} mm", r.value, 1e3 * r.spacing_m))
            .collect();
        let Some(p) = candidate.parameters.first() else { continue };
        let ratio = candidate.scores.squares() / candidate.scores.absent();
        println!(
            "  the simulator: {names} {} {}; {:.0} % of the squares without it are left",
            per_spacing.join(", "),
            p.unit,
            100.0 * ratio
        );
    }
    for candidate in &sizing.not_sized {
        println!("  not sized: {} ({})", candidate.names.join(" + "), candidate.reason);
    }
}
