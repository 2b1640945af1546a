//! Pictures of the study: the confusion matrix and the curves of detection.

use super::bench::Judged;
use super::cases::{Hidden, SIZES, hidden};
use super::plans::Family;
use super::run::JudgedTrial;
use super::tally::{StudyTally, right};
use meniscus::reduced::effects::Class;
use meniscus_report::plot::{BLUE, FONT, GREEN, GREY, ORANGE, PURPLE, PictureError, VERMILION, prepare_font};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::path::Path;

/// Side of a cell of the confusion matrix, px.
const CELL: i32 = 36;

/// Left and upper edge of the cells, px; names and title stand there.
const CORNER: (i32, i32) = (230, 280);

/// Verdicts behind the names of the effects.
const OTHERS: [&str; 3] = ["another", "unknown", "none"];

/// Title of the confusion matrix.
const TITLE: &str = "A verdict off the diagonal is wrong, tied or undecided";

/// Explanation of the confusion matrix.
const LEGEND: [&str; 2] = [
    "Rows: hidden effect, at reference size. Columns: verdict. Blue: named. Orange: tied. Grey: unknown or none.",
    "Left half of a cell: glass that was known while rules were made. Right half: fresh glass.",
];

/// Draws the confusion matrix at reference size: rows are the truth, columns the verdict. The glasses that were known while
/// rules were made fill the left half of a cell, the fresh ones the right half.
///
/// # Errors
/// [`PictureError`], when the file cannot be written.
pub fn confusion_png(study: &StudyTally, path: &Path) -> Result<(), PictureError> {
    prepare_font();
    let names: Vec<&str> = hidden().map(|h| h.effect.name).collect();
    let columns = names.len() + OTHERS.len();
    let (left, top) = CORNER;
    let size = ((left + CELL * columns as i32 + 30) as u32, (top + CELL * names.len() as i32 + 76) as u32);
    let area = BitMapBackend::new(path, size).into_drawing_area();
    area.fill(&WHITE)?;
    let text = (FONT, 17).into_font().color(&BLACK);
    let upright = (FONT, 17).into_font().transform(FontTransform::Rotate270).color(&BLACK);
    area.draw(&Text::new(TITLE, (12, 18), (FONT, 24).into_font().color(&BLACK)))?;
    for (i, name) in names.iter().enumerate() {
        area.draw(&Text::new(*name, (12, top + CELL * i as i32 + 9), text.clone()))?;
    }
    for (j, name) in names.iter().chain(&OTHERS).enumerate() {
        area.draw(&Text::new(*name, (left + CELL * j as i32 + 8, top - 10), upright.clone()))?;
    }
    for (i, name) in names.iter().enumerate() {
        for j in 0..columns {
            let (x, y) = corner(i, j);
            area.draw(&Rectangle::new([(x, y), (x + CELL, y + CELL)], GREY.mix(0.3)))?;
        }
        for (family, half) in [(Family::Hidden, 0), (Family::Fresh, 1)] {
            let of_family = study.of(family).filter(|(a, _)| a.size == 1.0 && a.effects[0].0 == *name);
            for (j, colour) in of_family.flat_map(|(_, judged)| filled_cells(judged, &names)) {
                let (x, y) = corner(i, j);
                let from = x + 3 + half * (CELL / 2 - 2);
                let rectangle = [(from, y + 3), (from + CELL / 2 - 4, y + CELL - 3)];
                area.draw(&Rectangle::new(rectangle, colour.filled()))?;
            }
        }
    }
    for (line, y) in LEGEND.iter().zip([54, 30]) {
        area.draw(&Text::new(*line, (12, size.1 as i32 - y), text.clone()))?;
    }
    area.present()?;
    Ok(())
}

/// Upper left corner of a cell, px.
fn corner(row: usize, column: usize) -> (i32, i32) {
    (CORNER.0 + CELL * column as i32, CORNER.1 + CELL * row as i32)
}

/// Columns and colours of a verdict, where the effects have these names in the order of the columns.
fn filled_cells(judged: &Judged, names: &[&str]) -> Vec<(usize, RGBColor)> {
    let behind = |at: usize| names.len() + at;
    match judged.verdict.as_str() {
        "unknown" => vec![(behind(1), GREY)],
        "none" => vec![(behind(2), GREY)],
        verdict => {
            let colour = if verdict == "named" { BLUE } else { ORANGE };
            let column = |name: &String| names.iter().position(|n| n == name).unwrap_or(behind(0));
            judged.names.iter().map(|name| (column(name), colour)).collect()
        }
    }
}

/// Ends of the axis of gains: from the smallest significant gain to beyond a gross error of scale.
const GAINS: (f64, f64) = (10.0, 1e6);

/// Least ratio of the gains at which two labels stand, so that neither covers the other.
const LABELS_APART: f64 = 1.33;

/// Returns the colour of a class; labels distinguish the lines of one class.
fn colour_of(class: Class) -> RGBColor {
    match class {
        Class::View => BLUE,
        Class::Timing => GREY,
        Class::Actuation => PURPLE,
        Class::Stiffness => GREEN,
        Class::Damping => ORANGE,
        Class::AmplitudeDamping => VERMILION,
        Class::Shape => BLACK,
    }
}

/// Draws the gain over no effect against size, one curve per effect.
///
/// # Errors
/// [`PictureError`], when the file cannot be written.
pub fn detection_png(study: &StudyTally, path: &Path) -> Result<(), PictureError> {
    prepare_font();
    let area = BitMapBackend::new(path, (1100, 700)).into_drawing_area();
    area.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(&area)
        .caption(
            "The evidence for an effect grows with its size (filled: named right; one colour for each class)",
            (FONT, 22),
        )
        .margin(14)
        .x_label_area_size(46)
        .y_label_area_size(80)
        .build_cartesian_2d((0.4..4.5).log_scale(), (GAINS.0..GAINS.1).log_scale())?;
    chart
        .configure_mesh()
        .x_desc("size over reference size")
        .y_desc("gain in BIC over no effect")
        .x_label_formatter(&|size| format!("{size:.1}"))
        .y_label_formatter(&|gain| format!("{gain:.0}"))
        .light_line_style(WHITE)
        .label_style((FONT, 15))
        .draw()?;
    let mut sizes = SIZES;
    sizes.sort_by(f64::total_cmp);
    let mut ends = Vec::new();
    for Hidden { effect, .. } in hidden() {
        let colour = colour_of(effect.class);
        let of = |size: &f64| {
            let mine = |(a, _): &&JudgedTrial| a.size == *size && a.effects[0].0 == effect.name;
            let (a, j) = study.of(Family::Hidden).find(mine)?;
            Some((*size, j.gain.clamp(GAINS.0, GAINS.1), right(a, j)))
        };
        let points: Vec<(f64, f64, bool)> = sizes.iter().filter_map(of).collect();
        chart.draw_series(LineSeries::new(points.iter().map(|p| (p.0, p.1)), colour.stroke_width(2)))?;
        for (x, y, named) in &points {
            let style = if *named { colour.filled() } else { colour.stroke_width(2) };
            chart.draw_series([Circle::new((*x, *y), 6, style)])?;
        }
        ends.extend(points.last().map(|(x, y, _)| (effect.name, colour, (*x, *y))));
    }
    // From the top down, each label below the one above it.
    ends.sort_by(|a, b| b.2.1.total_cmp(&a.2.1));
    let mut above = f64::INFINITY;
    for (name, colour, (x, y)) in ends {
        let at = y.min(above / LABELS_APART);
        above = at;
        let line = [(x * 1.04, y), (x * 1.16, at)];
        chart.draw_series([PathElement::new(line.to_vec(), GREY.mix(0.6))])?;
        let style = (FONT, 15).into_font().color(&colour).pos(Pos::new(HPos::Left, VPos::Center));
        chart.draw_series([Text::new(name, (x * 1.18, at), style)])?;
    }
    area.present()?;
    Ok(())
}
