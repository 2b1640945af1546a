//! Sentences of the page that depend on more than one finding.

use crate::decision::verdict::Verdict;
use crate::findings::Findings;
use crate::findings::isolability::Isolability;
use crate::fitting::localise::Cell;

/// Largest probability at which a misfit is no chance.
const NO_CHANCE: f64 = 0.01;

/// Returns what the largest `cell` of the map means beside the verdict.
pub(super) fn map_in_words(findings: &Findings, cell: &Cell) -> String {
    let nothing = matches!(findings.assessment.verdict, Verdict::None { .. });
    format!(
        "The largest is the {} during {}, {:.1}; {}",
        cell.channel,
        cell.window,
        cell.chi2,
        beside(cell, findings.limits.cell, nothing)
    )
}

/// Returns the rest of that sentence for a `limit` of clean glasses, where the verdict may be that `nothing` is missing.
fn beside(cell: &Cell, limit: f64, nothing: bool) -> String {
    let within = if !limit.is_finite() {
        String::from("no reference says how large that of a clean glass may be.")
    } else if cell.chi2 <= limit {
        format!("that of a clean glass may reach {limit:.1}.")
    } else {
        format!("more than the {limit:.1} that a clean glass may reach.")
    };
    if nothing && cell.p < NO_CHANCE {
        return within
            + " It is no chance: it is an error of the plain model, as large as clean glasses show, and no effect.";
    }
    within
}

/// Returns which effects are too small to be seen, and which of the others are alike; `decisive` is the separation that
/// decides, signal over noise.
pub(super) fn distinction(isolability: &Isolability, decisive: f64) -> String {
    let Isolability { names, lengths, cosines } = isolability;
    let (visible, hidden): (Vec<usize>, Vec<usize>) = (0..names.len()).partition(|i| lengths[*i] >= decisive);
    let listed = |all: Vec<String>| if all.is_empty() { String::from("none") } else { all.join(", ") };
    let pairs = visible.iter().flat_map(|i| visible.iter().filter(move |j| *j < i).map(move |j| (*i, *j)));
    let alike = pairs.filter(|(i, j)| {
        lengths[*i].min(lengths[*j]) * (1.0 - cosines[*i][*j].powi(2)).max(0.0).sqrt() < decisive
    });
    let alike = listed(alike.map(|(i, j)| format!("{} ~ {}", names[j], names[i])).collect());
    let hidden = listed(hidden.into_iter().map(|i| String::from(names[i])).collect());
    format!("Too small to be seen at that size: {hidden}. Seen, and not distinguished: {alike}.")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn effects_that_are_not_seen_are_not_called_alike() {
        // The first two point across one another and are short; the last two are alike and long.
        let isolability = Isolability {
            names: vec!["foam", "swirl", "viscosity", "wall_slip"],
            lengths: vec![1.0, 2.0, 90.0, 80.0],
            cosines: vec![
                vec![1.0, 0.0, 0.1, 0.1],
                vec![0.0, 1.0, 0.1, 0.1],
                vec![0.1, 0.1, 1.0, 0.9999],
                vec![0.1, 0.1, 0.9999, 1.0],
            ],
        };
        assert_eq!(
            distinction(&isolability, 5.0),
            "Too small to be seen at that size: foam, swirl. Seen, and not distinguished: viscosity ~ wall_slip."
        );
    }

    #[test]
    fn a_misfit_that_is_no_chance_does_not_stand_without_a_word_where_nothing_is_missing() {
        let cell = Cell {
            channel: "slope",
            window: "forced",
            count: 300,
            chi2: 1.8,
            p: 1e-5,
            rms_m: 1e-4,
            phase: [0.0; 2],
        };
        assert!(beside(&cell, 2.5, true).contains("It is no chance"));
        assert!(!beside(&cell, 2.5, false).contains("no chance"));
        assert!(beside(&cell, 1.5, false).contains("more than the 1.5"));
        assert!(beside(&cell, f64::INFINITY, false).contains("no reference"));
    }
}
