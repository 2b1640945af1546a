//! Pictures of the study: the confusion matrix and the curves of detection.

use super::cases::{Hidden, SIZES, hidden};
use super::plans::Family;
use super::run::JudgedTrial;
use super::tally::{StudyTally, right};
use meniscus::reduced::effects::Class;
use meniscus_report::plot::{BLUE, FONT, GREEN, GREY, ORANGE, PURPLE, PictureError, VERMILION, prepare_font};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::path::Path;

/// Draws the confusion matrix at reference size: rows are the truth, columns the verdict.
///
/// # Errors
/// [`PictureError`], when the file cannot be written.
pub fn confusion_png(study: &StudyTally, path: &Path) -> Result<(), PictureError> {
    prepare_font();
    let names: Vec<&str> = hidden().map(|h| h.effect.name).collect();
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
                    for name in &judged.names {
                        let j = names.iter().position(|n| n == name).unwrap_or(names.len());
                        let colour = if verdict == "named" { BLUE.mix(1.0) } else { ORANGE.mix(0.6) };
                        fill(&area, j, colour)?;
                    }
                }
            }
        }
    }
    let legend = "rows: hidden; columns: verdict. Blue named, orange tied, grey none or unknown.";
    area.draw(&Text::new(legend, (12, size.1 as i32 - 36), text))?;
    area.present()?;
    Ok(())
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
            "gain over none by size of the hidden effect (filled: named right; a colour a class)",
            (FONT, 22),
        )
        .margin(14)
        .x_label_area_size(46)
        .y_label_area_size(80)
        .build_cartesian_2d((0.4..4.5).log_scale(), (GAINS.0..GAINS.1).log_scale())?;
    chart
        .configure_mesh()
        .x_desc("size over reference size")
        .y_desc("gain in BIC")
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
