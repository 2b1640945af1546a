//! Pictures of the study: the confusion matrix and the curves of detection.

use super::cases::{HIDDEN, SIZES};
use super::plans::Family;
use super::tally::{Study, right};
use crate::host::view::plot::{BLUE, FONT, GREY, ORANGE, PictureError, prepare_font};
use crate::offline::prelude::*;
use plotters::prelude::*;
use std::path::Path;

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
