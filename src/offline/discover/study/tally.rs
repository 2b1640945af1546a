//! What the study showed: checks, tables, pictures.

use super::cases::{HIDDEN, SIZES};
use super::measured::Asked;
use super::run::{Answer, Family, Judged};
use crate::effects::find;
use crate::host::checks::Check;
use crate::host::view::plot::{BLUE, FONT, GREY, ORANGE, PictureError, prepare_font};
use crate::offline::prelude::*;
use plotters::prelude::*;
use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::Path;

/// A trial with its answer.
pub type Line = (Answer, Judged);

/// Everything that was measured.
#[derive(Clone, Debug, Default)]
pub struct Study {
    /// Trials.
    pub lines: Vec<Line>,
    /// Measured water, where the data are there.
    pub measured: Option<Vec<Asked>>,
    /// Share of intervals that held the truth, of draws from the model itself, and how many were drawn.
    pub coverage: Option<(f64, usize)>,
    /// Seconds of one discovery on three recordings of 10 s.
    pub long_s: Option<f64>,
}

impl Study {
    fn of(&self, family: Family) -> impl Iterator<Item = &Line> {
        self.lines.iter().filter(move |(answer, _)| answer.family == family)
    }

    fn reference(&self) -> impl Iterator<Item = &Line> {
        self.of(Family::Hidden).filter(|(answer, _)| answer.size == 1.0)
    }
}

/// Whether a name was said, and it is the truth.
#[must_use]
pub fn right(answer: &Answer, judged: &Judged) -> bool {
    judged.verdict == "named"
        && judged.names.len() == answer.effects.len()
        && answer.effects.iter().all(|(name, _)| judged.names.contains(name))
}

/// Whether something was said with confidence (a name, or a class) and the class is that of the truth.
fn class_right(answer: &Answer, judged: &Judged) -> Option<bool> {
    let truth = answer.effects.first().and_then(|(name, _)| find(name)).map(|entry| entry.class.words())?;
    let said = judged.class.as_deref()?;
    matches!(judged.verdict.as_str(), "named" | "tied").then_some(said == truth)
}

fn share(hits: usize, of: usize) -> f64 {
    if of == 0 { f64::NAN } else { hits as f64 / of as f64 }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.retain(|v| v.is_finite());
    values.sort_by(f64::total_cmp);
    if values.is_empty() { f64::NAN } else { values[values.len() / 2] }
}

/// Names of a confident wrong class or name where the truth was not in the library.
fn wrong_without(study: &Study) -> usize {
    let wrong = |(answer, judged): &&Line| {
        let named = judged.verdict == "named";
        let class = class_right(answer, judged);
        class == Some(false) || (named && class.is_none())
    };
    study.of(Family::Without).filter(wrong).count()
}

/// The checks of the issue.
#[must_use]
pub fn checks(study: &Study) -> Vec<Check> {
    let reference: Vec<&Line> = study.reference().collect();
    let classes: Vec<bool> = reference.iter().filter_map(|(a, j)| class_right(a, j)).collect();
    let named: Vec<&&Line> = reference.iter().filter(|(_, j)| j.verdict == "named").collect();
    let rights: Vec<&&Line> = reference.iter().filter(|(a, j)| right(a, j)).collect();
    let cleans: Vec<&Line> = study.of(Family::Clean).collect();
    let false_names = cleans.iter().filter(|(_, j)| j.verdict == "named").count();
    let asked: Vec<&Line> = study.of(Family::Asked).collect();
    let after = rights.len() + asked.iter().filter(|(a, j)| right(a, j)).count();
    let shrink = rights.iter().filter_map(|(_, j)| j.gap_mm).map(|g| 1.0 - g[3] / g[0]).collect();
    let over = rights.iter().filter_map(|(_, j)| j.gap_mm).map(|g| g[3] / g[4]).collect();
    let pairs: Vec<&Line> = study.of(Family::Pair).collect();
    let honest = pairs.iter().filter(|(a, j)| right(a, j) || j.verdict == "unknown").count();
    let noise = study.of(Family::Noise).filter(|(_, j)| j.verdict == "named").count();
    let seconds = study.lines.iter().map(|(_, j)| j.seconds).fold(f64::NAN, f64::max);
    let mut out = vec![
        Check::at_least(
            "class_right",
            share(classes.iter().filter(|r| **r).count(), classes.len()),
            "share",
            0.97,
        ),
        Check::told("class_stated", share(classes.len(), reference.len()), "share"),
        Check::at_least("decided_share", share(rights.len(), reference.len()), "share", 0.60),
        Check::at_least(
            "decided_share_after_asking",
            if asked.is_empty() { f64::NAN } else { share(after, reference.len()) },
            "share",
            0.80,
        ),
        Check::at_least("right_of_decided", share(rights.len(), named.len()), "share", 0.95),
        Check::at_most(
            "false_names",
            if cleans.is_empty() { f64::NAN } else { false_names as f64 },
            "trials",
            1.0,
        ),
        Check::at_least("clean_trials", cleans.len() as f64, "trials", 118.0),
        Check::at_least(
            "clean_glasses",
            cleans.iter().map(|(a, _)| &a.glass).collect::<BTreeSet<_>>().len() as f64,
            "glasses",
            12.0,
        ),
        Check::at_most("noise_false_names", noise as f64, "trials", 0.0),
        Check::exactly(
            "wrong_confident_out_of_library",
            if study.of(Family::Without).count() == 0 { f64::NAN } else { wrong_without(study) as f64 },
            "trials",
            0.0,
        ),
        Check::at_least("two_effects_right_or_unknown", share(honest, pairs.len()), "share", 0.9),
        Check::at_least("gap_shrink_median", median(shrink), "share", 0.60),
        Check::at_most("gap_over_oracle", median(over), "ratio", 1.25),
        Check::at_least("interval_coverage", study.coverage.map_or(f64::NAN, |c| c.0), "share", 0.85),
    ];
    let held: Vec<bool> = rights
        .iter()
        .filter_map(|(a, j)| j.estimate.as_ref().map(|e| e.2 <= a.effects[0].1 && a.effects[0].1 <= e.3))
        .collect();
    out.push(Check::told(
        "interval_coverage_other_simulator",
        share(held.iter().filter(|h| **h).count(), held.len()),
        "share",
    ));
    if let Some(measured) = &study.measured {
        let [tilt, vertical, control] = [0, 1, 2].map(|i| measured.get(i));
        let means = |asked: Option<&Asked>| asked.map_or([f64::NAN; 2], Asked::means_mm);
        let free = |asked: Option<&Asked>| {
            let names = asked.map(|a| a.discovery.verdict.names.contains(&"vertical_acceleration"));
            names.map_or(f64::NAN, |named| f64::from(u8::from(!named)))
        };
        out.push(Check::told("antisloshing_tilt_before", means(tilt)[0], "mm"));
        out.push(Check::at_most("antisloshing_tilt_after", means(tilt)[1], "mm", 3.5));
        out.push(Check::told("antisloshing_vertical_before", means(vertical)[0], "mm"));
        out.push(Check::at_most("antisloshing_vertical_after", means(vertical)[1], "mm", 4.0));
        out.push(Check::exactly("antisloshing_control_none", free(control), "yes", 1.0));
    }
    out.push(Check::told("seconds_per_short_discovery", seconds, "s"));
    out.push(Check::at_most("seconds_per_discovery", study.long_s.unwrap_or(f64::NAN), "s", 180.0));
    out
}

/// The page: checks, then every trial.
#[must_use]
pub fn markdown(study: &Study, checks: &[Check], command: &str) -> String {
    let mut out = format!("Made by `{command}`.\n\n| check | value | target | |\n|---|---|---|---|\n");
    for check in checks {
        let value = check.value.map_or("not measured".into(), |v| format!("{v:.3} {}", check.unit));
        // Writing into a string cannot fail.
        let _ = writeln!(
            out,
            "| `{}` | {value} | {} | {} |",
            check.name,
            check.target,
            if check.ok { "" } else { "**missed**" }
        );
    }
    for (family, title) in [
        (Family::Hidden, "One effect hidden"),
        (Family::Asked, "The same with the recordings that were asked for"),
        (Family::Without, "The truth taken out of the library"),
        (Family::Pair, "Two effects at once"),
        (Family::Clean, "Nothing hidden"),
        (Family::Noise, "Nothing hidden, noise misjudged by half"),
    ] {
        let lines: Vec<&Line> = study.of(family).collect();
        if lines.is_empty() {
            continue;
        }
        let _ = writeln!(
            out,
            "\n## {title}\n\n| truth | size | verdict | said | class | gain | misfit | estimate (90 %) | gap, mm: untouched, \
             refitted, black box, effect, oracle |\n|---|---|---|---|---|---|---|---|---|"
        );
        for (answer, judged) in lines {
            row(&mut out, answer, judged);
        }
    }
    if let Some(measured) = &study.measured {
        for asked in measured {
            let [before, after] = asked.means_mm();
            let _ = writeln!(
                out,
                "\n## Measured water: {}\n\n{} Mean error {before:.2} mm before, {after:.2} mm after.\n\n| run | before, mm | after, mm |\n|---|---|---|",
                asked.title,
                asked.discovery.verdict.sentence()
            );
            for (name, before, after) in &asked.runs {
                let _ = writeln!(out, "| {name} | {:.2} | {:.2} |", 1e3 * before, 1e3 * after);
            }
        }
    }
    out
}

fn row(out: &mut String, answer: &Answer, judged: &Judged) {
    let truth: Vec<String> =
        answer.effects.iter().map(|(name, value)| format!("{name} {value:.3}")).collect();
    let truth = if truth.is_empty() { format!("none ({})", answer.glass) } else { truth.join(" + ") };
    let estimate = judged
        .estimate
        .as_ref()
        .map_or(String::new(), |(name, v, a, b)| format!("{name} {v:.3} ({a:.3} to {b:.3})"));
    let gap = judged.gap_mm.map_or(String::new(), |g| g.map(|v| format!("{v:.2}")).join(", "));
    let mark = if right(answer, judged) { "**named**" } else { judged.verdict.as_str() };
    let _ = writeln!(
        out,
        "| {truth} | {} | {mark} | {} | {} | {:.0} | {:.2}, {:.2} | {estimate} | {gap} |",
        answer.size,
        judged.names.join(", "),
        judged.class.as_deref().unwrap_or(""),
        judged.gain,
        judged.misfit[0],
        judged.misfit[1]
    );
}

/// The confusion matrix at reference size: rows are the truth, columns what came first.
///
/// # Errors
/// [`PictureError`], when the file cannot be written.
pub fn confusion_png(study: &Study, path: &Path) -> Result<(), PictureError> {
    prepare_font();
    let names: Vec<&str> = HIDDEN.iter().map(|h| h.name).collect();
    let extra = ["another", "unknown", "none"];
    let (cell, left, top) = (36, 230, 210);
    let columns = names.len() + extra.len();
    let size = ((left + cell * columns as i32 + 30) as u32, (top + cell * names.len() as i32 + 60) as u32);
    let area = BitMapBackend::new(path, size).into_drawing_area();
    area.fill(&WHITE)?;
    let text = (FONT, 17).into_font().color(&BLACK);
    let upright = (FONT, 17).into_font().transform(FontTransform::Rotate270).color(&BLACK);
    for (i, name) in names.iter().enumerate() {
        area.draw(&Text::new(*name, (12, top + cell * i as i32 + 9), text.clone()))?;
    }
    for (j, name) in names.iter().chain(&extra).enumerate() {
        area.draw(&Text::new(*name, (left + cell * j as i32 + 8, top - 10), upright.clone()))?;
    }
    for (i, name) in names.iter().enumerate() {
        let y = top + cell * i as i32;
        for j in 0..columns as i32 {
            let x = left + cell * j;
            area.draw(&Rectangle::new([(x, y), (x + cell, y + cell)], GREY.mix(0.3)))?;
        }
        for (_, judged) in study.reference().filter(|(a, _)| a.effects[0].0 == *name) {
            let fill = |area: &DrawingArea<BitMapBackend<'_>, plotters::coord::Shift>,
                        j: usize,
                        colour: RGBAColor| {
                let x = left + cell * j as i32;
                area.draw(&Rectangle::new([(x + 3, y + 3), (x + cell - 3, y + cell - 3)], colour.filled()))
            };
            match judged.verdict.as_str() {
                "none" => fill(&area, columns - 1, GREY.mix(1.0))?,
                "unknown" => fill(&area, columns - 2, GREY.mix(1.0))?,
                verdict => {
                    for said in &judged.names {
                        let j = names.iter().position(|n| n == said).unwrap_or(names.len());
                        let colour = if verdict == "named" { BLUE.mix(1.0) } else { ORANGE.mix(0.6) };
                        fill(&area, j, colour)?;
                    }
                }
            }
        }
    }
    let legend = "rows: hidden; columns: said. Blue named, orange tied, grey none or unknown.";
    area.draw(&Text::new(legend, (12, size.1 as i32 - 36), text))?;
    area.present()?;
    Ok(())
}

/// Gain over none against size, one curve an effect.
///
/// # Errors
/// [`PictureError`], when the file cannot be written.
pub fn detection_png(study: &Study, path: &Path) -> Result<(), PictureError> {
    prepare_font();
    let area = BitMapBackend::new(path, (1100, 700)).into_drawing_area();
    area.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(&area)
        .caption("gain over none by size of what is hidden (filled: named right)", (FONT, 24))
        .margin(14)
        .x_label_area_size(46)
        .y_label_area_size(80)
        .build_cartesian_2d((0.4..4.5).log_scale(), (1.0..1e5).log_scale())?;
    chart
        .configure_mesh()
        .x_desc("size over reference size")
        .y_desc("gain in BIC (1: none)")
        .label_style((FONT, 15))
        .draw()?;
    let mut sizes = SIZES;
    sizes.sort_by(f64::total_cmp);
    for (i, hidden) in HIDDEN.iter().enumerate() {
        let colour = Palette99::pick(i).mix(1.0);
        let points: Vec<(f64, f64, bool)> = sizes
            .iter()
            .filter_map(|size| {
                let (a, j) = study
                    .of(Family::Hidden)
                    .find(|(a, _)| a.size == *size && a.effects[0].0 == hidden.name)?;
                Some((*size, j.gain.max(1.0), right(a, j)))
            })
            .collect();
        chart.draw_series(LineSeries::new(points.iter().map(|p| (p.0, p.1)), colour.stroke_width(2)))?;
        for (x, y, named) in &points {
            let style = if *named { colour.filled() } else { colour.stroke_width(2) };
            chart.draw_series([Circle::new((*x, *y), 6, style)])?;
        }
        if let Some((x, y, _)) = points.last() {
            let style = (FONT, 14).into_font().color(&colour);
            chart.draw_series([Text::new(hidden.name, (x * 1.06, *y), style)])?;
        }
    }
    area.present()?;
    Ok(())
}
