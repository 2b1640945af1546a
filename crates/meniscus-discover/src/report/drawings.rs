//! Drawings of a discovery: bars of gains with their thresholds, and two matrices.

use crate::decision::rank::Candidate;
use crate::decision::verdict::Verdict;
use crate::findings::Findings;
use crate::fitting::localise::Cell;
use meniscus_report::plot::{BLUE, GREY, ORANGE};
use plotters::style::RGBColor;
use std::fmt::Write;

/// Height of a bar with its room, width of the longest, and where bars begin.
const ROW: usize = 26;
const LONGEST: f64 = 430.0;
const BARS: f64 = 285.0;

/// Side of a square of the matrices.
const CELL: usize = 24;

/// Returns the bars of single effects and pairs by gain, with the gain that each has to reach.
pub(super) fn ranking(findings: &Findings) -> String {
    let (verdict, search) = (&findings.assessment.verdict, &findings.assessment.search);
    let lines: Vec<_> = search
        .ranking
        .iter()
        .take(8)
        .chain(search.pairs.iter().take(3))
        .map(|line| (line, needed(findings, line)))
        .collect();
    let most = lines.iter().map(|(line, needed)| line.gain.max(*needed)).fold(1.0, f64::max);
    let mut out = opened(800, ROW * lines.len(), 14);
    for (i, (line, needed)) in lines.iter().enumerate() {
        let (y, width) = (ROW * i, LONGEST * (line.gain / most).max(0.0));
        let tick = BARS + LONGEST * (needed / most).max(0.0);
        let names = verdict.names();
        let claimed = match verdict {
            Verdict::None { .. } => false,
            Verdict::Ambiguous(_) => line.names.iter().all(|name| names.contains(name)),
            Verdict::Identified(_) | Verdict::Unknown(_) => line.names == names,
        };
        // Writing into a string cannot fail.
        let _ = writeln!(
            out,
            "<text x=\"275\" y=\"{}\" text-anchor=\"end\">{}</text><rect x=\"{BARS}\" y=\"{}\" width=\"{width:.1}\" \
             height=\"18\" fill=\"{}\"/><line x1=\"{tick:.1}\" x2=\"{tick:.1}\" y1=\"{}\" y2=\"{}\" stroke=\"{}\" \
             stroke-width=\"3\"/><text x=\"{:.1}\" y=\"{}\">{:.0}</text>",
            y + 17,
            line.names.join(" + "),
            y + 3,
            mixed(if claimed { BLUE } else { GREY }, 1.0),
            y + 1,
            y + 23,
            mixed(ORANGE, 1.0),
            BARS + 7.0 + width.max(tick - BARS),
            y + 17,
            line.gain
        );
    }
    out + "</svg>"
}

/// Returns the gain that `line` has to reach. Once an effect is significant the others compete under a covariance for which
/// no bound was learnt.
fn needed(findings: &Findings, line: &Candidate) -> f64 {
    if findings.assessment.verdict.claim().is_some() {
        return findings.limits.gain;
    }
    (line.gain - line.fall + findings.limits.of(line.last())).max(findings.limits.gain)
}

/// Returns the misfit by channel and window, darker from one upwards.
pub(super) fn disagreement(map: &[Cell]) -> String {
    let once = |name: &dyn Fn(&Cell) -> &'static str| {
        let mut names: Vec<&'static str> = Vec::new();
        for cell in map {
            if !names.contains(&name(cell)) {
                names.push(name(cell));
            }
        }
        names
    };
    let (channels, windows) = (once(&|cell| cell.channel), once(&|cell| cell.window));
    const WIDE: usize = 130;
    let mut out = opened(90 + WIDE * windows.len(), 24 + ROW * channels.len(), 14);
    for (j, window) in windows.iter().enumerate() {
        let _ = write!(out, "<text x=\"{}\" y=\"16\">{window}</text>", 96 + WIDE * j);
    }
    for (i, channel) in channels.iter().enumerate() {
        let _ = write!(out, "<text x=\"82\" y=\"{}\" text-anchor=\"end\">{channel}</text>", 41 + ROW * i);
    }
    for cell in map {
        let place = |names: &[&str], name: &str| names.iter().position(|n| *n == name).unwrap_or(0);
        let (i, j) = (place(&channels, cell.channel), place(&windows, cell.window));
        // Twice the misfit is one step darker, ten steps in all; a light one keeps its dark letters.
        let dark = (cell.chi2.max(1.0).log2() / 10.0).min(1.0);
        let ink = if dark > 0.5 { "#fff" } else { "#222" };
        let _ = writeln!(
            out,
            "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"24\" fill=\"{}\"/><text x=\"{}\" y=\"{}\" \
             fill=\"{ink}\">{:.2}</text>",
            90 + WIDE * j,
            24 + ROW * i,
            WIDE - 2,
            mixed(BLUE, 0.08 + 0.92 * dark),
            98 + WIDE * j,
            41 + ROW * i,
            cell.chi2
        );
    }
    out + "</svg>"
}

/// Returns the cosines of the signatures, with their lengths beside the names.
pub(super) fn likeness(names: &[&'static str], length: &[f64], cosines: &[Vec<f64>]) -> String {
    let side = 190 + CELL * names.len();
    // The last name leans out over the last column.
    let mut out = opened(side + 70, side, 12);
    for (i, name) in names.iter().enumerate() {
        let y = 180 + CELL * i;
        let _ = writeln!(
            out,
            "<text x=\"178\" y=\"{}\" text-anchor=\"end\">{name} {:.0}</text><text transform=\"translate({},174) \
             rotate(-60)\">{name}</text>",
            y + 16,
            length[i],
            y + 12
        );
        for (j, cosine) in cosines[i].iter().enumerate() {
            let fill = mixed(if *cosine > 0.0 { ORANGE } else { BLUE }, cosine.abs().min(1.0));
            let x = 180 + CELL * j;
            let _ = write!(out, "<rect x=\"{x}\" y=\"{y}\" width=\"23\" height=\"23\" fill=\"{fill}\"/>");
        }
    }
    out + "</svg>"
}

pub(super) fn opened(width: usize, height: usize, letters: usize) -> String {
    format!("<svg viewBox=\"0 0 {width} {height}\" width=\"{width}\" font-size=\"{letters}\">\n")
}

/// Returns white mixed with `part` of `colour`.
pub(super) fn mixed(colour: RGBColor, part: f64) -> String {
    let RGBColor(r, g, b) = colour;
    let [r, g, b] = [r, g, b].map(|to| part.mul_add(f64::from(to) - 255.0, 255.0));
    format!("rgb({r:.0},{g:.0},{b:.0})")
}
