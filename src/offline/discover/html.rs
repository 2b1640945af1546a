//! The page of a discovery: HTML that stands alone, with its plots in it.

use super::verdict::Decision;
use super::workflow::Discovery;
use crate::offline::prelude::*;
use std::fmt::Write;

const STYLE: &str = "body{font:16px/1.5 sans-serif;max-width:60em;margin:2em auto;padding:0 1em;color:#222}\
table{border-collapse:collapse;margin:1em 0}td,th{padding:.2em .7em;border-bottom:1px solid #ddd;text-align:right}\
td:first-child,th:first-child{text-align:left}.v{font-size:1.3em;background:#eef4fb;padding:1em;border-left:6px solid #2b6cb0}\
small{color:#666}svg{max-width:100%}";

/// The page.
#[must_use]
pub fn page(discovery: &Discovery) -> String {
    let verdict = &discovery.verdict;
    let mut out = format!(
        "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><title>Discovery: {}</title><style>{STYLE}</style>\n\
         <h1>Discovery</h1>\n<p class=\"v\"><b>{}.</b> {}</p>\n",
        verdict.decision.word(),
        verdict.decision.word(),
        verdict.sentence()
    );
    // Writing into a string cannot fail.
    let _ = writeln!(
        out,
        "<p>Fitted: {}. Sealed: {}. References: {} glasses of a known liquid{}.</p>",
        discovery.fitted.join(", "),
        discovery.sealed.as_deref().unwrap_or("none (fewer than four recordings)"),
        discovery.calibration.groups,
        if discovery.calibration.groups < 2 {
            " &ndash; <b>the verdict is much weaker without them</b>"
        } else {
            ""
        }
    );
    ranking(&mut out, discovery);
    parameters(&mut out, discovery);
    sealed(&mut out, discovery);
    if let Some(question) = &discovery.question {
        let _ = writeln!(
            out,
            "<h2>What would settle it</h2><p>Record {}: it parts {} from {} by {:.1} times the noise ({} is enough); it \
             costs {:.0} s and nothing else. Looked at:</p><table><tr><th>motion</th><th>parts by</th></tr>",
            question.motion,
            question.between[0],
            question.between[1],
            question.separation,
            super::ask::ENOUGH,
            question.seconds
        );
        for (motion, parted) in &question.all {
            let _ = writeln!(out, "<tr><td>{motion}</td><td>{parted:.1}</td></tr>");
        }
        out.push_str("</table>\n");
    }
    map(&mut out, discovery);
    matrix(&mut out, discovery);
    out.push_str("</html>\n");
    out
}

fn ranking(out: &mut String, discovery: &Discovery) {
    let verdict = &discovery.verdict;
    let _ = writeln!(
        out,
        "<h2>Ranking</h2><p>Gain in BIC over no effect. Believed from {:.0} and from what clean glasses show of the same \
         effect (red tick); the second has to stay {:.0} behind, {:.0} in the same class. The first won {:.0} % of the \
         bootstrap; {} of {} recordings are foretold better when left out; misfit {:.2} without, {:.2} with, at most \
         {:.2}.</p>",
        discovery.limits.gain,
        super::verdict::APART,
        super::verdict::TWINS,
        100.0 * verdict.inclusion,
        verdict.held_out.0,
        verdict.held_out.1,
        verdict.plain.chi2(verdict.count),
        verdict.chi2,
        discovery.limits.chi2
    );
    let singles =
        verdict.ranking.iter().take(8).map(|c| (c, c.gain - c.fall + discovery.limits.of(c.last())));
    let pairs = verdict.pairs.iter().take(3);
    let pairs = pairs.map(|c| (c, c.gain - c.fall + discovery.limits.of(c.last())));
    let lines: Vec<_> = singles.chain(pairs).collect();
    let most = lines.iter().map(|(c, needed)| c.gain.max(*needed)).fold(1.0, f64::max);
    let height = 26 * lines.len();
    let _ = writeln!(out, "<svg viewBox=\"0 0 800 {height}\" width=\"800\" font-size=\"14\">");
    for (i, (line, needed)) in lines.iter().enumerate() {
        let (y, width) = (26 * i, 430.0 * (line.gain / most).max(0.0));
        let tick = 285.0 + 430.0 * (needed / most).max(0.0);
        let said = verdict.decision != Decision::None
            && (line.names == verdict.names
                || verdict.decision == Decision::Tied
                    && line.names.iter().all(|n| verdict.names.contains(n)));
        let colour = if said { "#2b6cb0" } else { "#a0aec0" };
        let _ = writeln!(
            out,
            "<text x=\"275\" y=\"{}\" text-anchor=\"end\">{}</text><rect x=\"285\" y=\"{}\" width=\"{width:.1}\" height=\"18\" \
             fill=\"{colour}\"/><line x1=\"{tick:.1}\" x2=\"{tick:.1}\" y1=\"{}\" y2=\"{}\" stroke=\"#c53030\" \
             stroke-width=\"2\"/><text x=\"{:.1}\" y=\"{}\">{:.1}</text>",
            y + 17,
            line.names.join(" + "),
            y + 3,
            y + 1,
            y + 23,
            292.0 + width.max(tick - 285.0),
            y + 17,
            line.gain
        );
    }
    out.push_str("</svg>\n");
}

fn parameters(out: &mut String, discovery: &Discovery) {
    if discovery.verdict.decision == Decision::None || discovery.estimates.is_empty() {
        return;
    }
    out.push_str("<h2>Parameters</h2><table><tr><th>effect</th><th>parameter</th><th>value</th><th>90 % interval</th><th>unit</th></tr>\n");
    for e in &discovery.estimates {
        let _ = writeln!(
            out,
            "<tr><td>{}</td><td>{}</td><td>{:.4}</td><td>{:.4} to {:.4}</td><td>{}</td></tr>",
            e.effect, e.parameter, e.value, e.interval.0, e.interval.1, e.unit
        );
    }
    out.push_str("</table>\n");
}

fn sealed(out: &mut String, discovery: &Discovery) {
    let Some(gap) = discovery.gap else { return };
    let _ = writeln!(
        out,
        "<h2>The sealed recording</h2><p>Root mean square error of the surface, noise ({:.3} mm) subtracted. It took no part \
         in anything above.</p><table><tr><th>model</th><th>mm</th></tr>",
        1e3 * gap.noise
    );
    for (name, value) in [
        ("untouched", gap.untouched),
        ("nuisances fitted again", gap.refitted),
        ("black-box correction", gap.black_box),
        ("with the effect", gap.effect),
    ] {
        let _ = writeln!(out, "<tr><td>{name}</td><td>{:.3}</td></tr>", 1e3 * value);
    }
    out.push_str("</table>\n");
    out.push_str(&curves_svg(&discovery.curves));
}

/// Measured, untouched and with the effect over time.
fn curves_svg(curves: &[[f64; 4]]) -> String {
    let end = curves.last().map_or(1.0, |row| row[0].max(1e-3));
    let most =
        curves.iter().flat_map(|r| &r[1..]).filter(|z| z.is_finite()).fold(1e-6_f64, |m, z| m.max(z.abs()));
    let at = |t: f64, z: f64| (50.0 + 730.0 * t / end, 150.0 - 130.0 * z / most);
    let mut out = String::from("<svg viewBox=\"0 0 800 310\" width=\"800\" font-size=\"13\">\n");
    let _ = writeln!(
        out,
        "<line x1=\"50\" y1=\"150\" x2=\"780\" y2=\"150\" stroke=\"#ccc\"/><text x=\"4\" y=\"24\">{:.1} mm</text>\
         <text x=\"4\" y=\"284\">{:.1}</text><text x=\"720\" y=\"168\">{end:.1} s</text>",
        1e3 * most,
        -1e3 * most
    );
    for row in curves.iter().filter(|row| row[1].is_finite()) {
        let (x, y) = at(row[0], row[1]);
        let _ = write!(out, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"2\" fill=\"#888\"/>");
    }
    for (column, colour) in [(2, "#dd6b20"), (3, "#2b6cb0")] {
        let points: Vec<String> =
            curves.iter().map(|row| at(row[0], row[column])).map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
        let _ = writeln!(
            out,
            "<polyline fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.5\" points=\"{}\"/>",
            points.join(" ")
        );
    }
    out.push_str(
        "<text x=\"60\" y=\"304\" fill=\"#888\">measured</text><text x=\"160\" y=\"304\" fill=\"#dd6b20\">untouched</text>\
         <text x=\"260\" y=\"304\" fill=\"#2b6cb0\">with the effect</text></svg>\n",
    );
    out
}

fn map(out: &mut String, discovery: &Discovery) {
    out.push_str(
        "<h2>Where they disagree</h2><p>Misfit of the model without an effect, 1 where it is right; p of so large a one \
         anywhere by chance; in phase is stiffness or scale, in quadrature is damping or time.</p>\
         <table><tr><th>channel</th><th>window</th><th>misfit</th><th>p</th><th>rms, mm</th><th>in phase</th>\
         <th>in quadrature</th></tr>\n",
    );
    for cell in &discovery.map {
        let heat = (30.0 * (cell.chi2 - 1.0)).clamp(0.0, 60.0);
        let _ = writeln!(
            out,
            "<tr style=\"background:hsl(15,90%,{:.0}%)\"><td>{}</td><td>{}</td><td>{:.2}</td><td>{}</td><td>{:.3}</td>\
             <td>{:+.2}</td><td>{:+.2}</td></tr>",
            100.0 - 0.5 * heat,
            cell.channel,
            cell.window,
            cell.chi2,
            if cell.p < 1e-3 { "&lt; 0.001".into() } else { format!("{:.3}", cell.p) },
            1e3 * cell.rms_m,
            cell.phase[0],
            cell.phase[1]
        );
    }
    out.push_str("</table>\n");
}

fn matrix(out: &mut String, discovery: &Discovery) {
    let (names, length, cosines) = &discovery.isolability;
    let twins: Vec<String> = (0..names.len())
        .flat_map(|i| (0..i).map(move |j| (i, j)))
        .filter(|(i, j)| {
            let apart = length[*i].min(length[*j]) * (1.0 - cosines[*i][*j].powi(2)).max(0.0).sqrt();
            apart < super::ask::ENOUGH
        })
        .map(|(i, j)| format!("{} ~ {}", names[j], names[i]))
        .collect();
    let _ = writeln!(
        out,
        "<h2>What these recordings can tell apart</h2><p>Cosines of the signatures at typical size, with what the baseline \
         can do taken out (red +1, blue -1), and their length over the noise. Not to be told apart at that size: {}.</p>",
        if twins.is_empty() { "none".into() } else { twins.join(", ") }
    );
    let cell = 24;
    let side = 190 + cell * names.len();
    // The last name leans out over the last column.
    let width = side + 70;
    let _ = writeln!(out, "<svg viewBox=\"0 0 {width} {side}\" width=\"{width}\" font-size=\"12\">");
    for (i, name) in names.iter().enumerate() {
        let y = 180 + cell * i;
        let _ = writeln!(
            out,
            "<text x=\"178\" y=\"{}\" text-anchor=\"end\">{name} {:.0}</text><text transform=\"translate({},174) rotate(-60)\">{name}</text>",
            y + 16,
            length[i],
            180 + cell * i + 12
        );
        for (j, cosine) in cosines[i].iter().enumerate() {
            let (r, b) =
                if *cosine > 0.0 { (255.0, 255.0 * (1.0 - cosine)) } else { (255.0 * (1.0 + cosine), 255.0) };
            let g = 255.0 * (1.0 - cosine.abs());
            let _ = write!(
                out,
                "<rect x=\"{}\" y=\"{y}\" width=\"23\" height=\"23\" fill=\"rgb({r:.0},{g:.0},{b:.0})\"/>",
                180 + cell * j
            );
        }
    }
    out.push_str("</svg>\n");
}
