//! Each effect against its theory over the spacing: whether its deviation falls with the particles.

use super::{COARSE_M, EFFECT_TARGET, FINE_M, STANDARD_M, effects};
use crate::Error;
use meniscus::reduced::effects::LIBRARY;
use meniscus_report::Report;
use meniscus_report::checks::Check;

/// The spacings, from coarse to fine, m.
const SPACINGS_M: [f64; 3] = [COARSE_M, STANDARD_M, FINE_M];

/// Roughly the part of the work that each spacing takes: particles by the third power, steps by the first.
const SHARES: [f64; 3] = [0.05, 0.19, 0.76];

/// Deviations of one figure of an effect.
#[derive(Clone, Debug, PartialEq)]
pub struct Converging {
    /// Name of the effect.
    pub effect: &'static str,
    /// Name of the measured figure.
    pub what: &'static str,
    /// Signed deviation from theory at 7, 5 and 3.5 mm, per cent.
    pub deviations: [f64; 3],
}

/// Holds every effect against its theory at 7, 5 and 3.5 mm; `watch` gets the part that is done, from 0 to 1, and the name of the case.
///
/// # Errors
/// When a case cannot be simulated to its end.
pub fn convergence(mut watch: impl FnMut(f64, &str)) -> Result<Vec<Converging>, Error> {
    let laws: Vec<_> =
        LIBRARY.iter().filter_map(|effect| Some((effect.name, effect.simulator.law()?))).collect();
    let mut rows = Vec::new();
    let mut done = 0.0;
    for (name, law) in &laws {
        let mut held = Vec::new();
        for (spacing, share) in SPACINGS_M.into_iter().zip(SHARES) {
            watch(done, &format!("{name}, {:.1} mm", 1e3 * spacing));
            held.push(effects::effect(*law, spacing)?);
            done += share / laws.len() as f64;
        }
        let figures = held[0].iter().enumerate().map(|(index, first)| Converging {
            effect: name,
            what: first.what,
            deviations: std::array::from_fn(|spacing| held[spacing][index].error()),
        });
        rows.extend(figures);
    }
    Ok(rows)
}

/// Returns the checks of `rows`: the largest deviation of each effect at each spacing, with a target at the finest.
fn convergence_checks(rows: &[Converging]) -> Vec<Check> {
    let mut checks: Vec<Check> = Vec::new();
    for effect in rows.chunk_by(|a, b| a.effect == b.effect) {
        // Not a number stays one, so that what could not be compared is not passed over.
        let worse = |a: f64, b: f64| if a >= b || a.is_nan() { a } else { b };
        let largest = |at: usize| effect.iter().map(|row| row.deviations[at].abs()).fold(0.0, worse);
        let name = effect[0].effect;
        checks.extend([
            Check::informational(format!("effect_{name}_7mm"), largest(0), "%"),
            Check::informational(format!("effect_{name}_5mm"), largest(1), "%"),
            Check::at_most(format!("effect_{name}_3_5mm"), largest(2), "%", EFFECT_TARGET),
        ]);
    }
    checks
}

/// Returns the report of `rows`: checks and a table.
#[must_use]
pub fn convergence_report(rows: &[Converging], command: &str) -> Report {
    let mut report = Report::new("The simulator's effects over the spacing", command);
    report.checks(&convergence_checks(rows));
    report.heading("Deviation from theory, %");
    let table: Vec<Vec<String>> = rows
        .iter()
        .map(|row| {
            let deviations = row.deviations.map(|deviation| format!("{deviation:+.1}"));
            [row.effect.into(), row.what.into()].into_iter().chain(deviations).collect()
        })
        .collect();
    report.table(&["effect", "measured", "7 mm", "5 mm", "3.5 mm"], &table);
    report
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_effect_has_its_worst_figure_at_each_spacing() {
        let row = |effect, what, deviations| Converging { effect, what, deviations };
        let rows = [
            row("foam", "exponent", [-9.0, 2.0, 1.0]),
            row("foam", "added decay", [3.0, -4.0, -0.5]),
            row("fill", "ratio", [1.0, f64::NAN, 9.0]),
        ];
        let checks = convergence_checks(&rows);
        let values: Vec<_> = checks.iter().map(|check| check.value).collect();
        assert_eq!(values, [Some(9.0), Some(4.0), Some(1.0), Some(1.0), None, Some(9.0)]);
        let missed: Vec<_> = checks.iter().map(Check::missed).collect();
        assert_eq!(missed, [false, false, false, false, false, true]);
        let page = convergence_report(&rows, "try").markdown();
        assert!(page.contains("| foam | exponent | -9.0 | +2.0 | +1.0 |"), "{page}");
    }
}
