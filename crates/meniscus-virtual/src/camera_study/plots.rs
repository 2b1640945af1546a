//! Pictures of the study: errors by condition, and what some scenes look like.

use super::conditions::{Condition, DISTANCES_M, LOOKS};
use super::judge::Judged;
use meniscus::surface::{Config, POINTS, profile_abscissa};
use meniscus_report::plot::{BLUE, FONT, GREY, ORANGE, PURPLE, PictureError, prepare_font};
use plotters::prelude::*;
use std::path::Path;

/// Width and height, pixels.
const SIZE: (u32, u32) = (1400, 800);
/// Scenes in the sheet, across and down; each this large.
const SHEET: (usize, usize) = (5, 4);
const TILE: (usize, usize) = (280, 280);

/// Writes every point's error by condition, with the stated interval's mean.
///
/// # Errors
/// [`PictureError`].
pub fn errors_png(scenes: &[Judged], path: &Path) -> Result<(), PictureError> {
    prepare_font();
    let area = BitMapBackend::new(path, SIZE).into_drawing_area();
    area.fill(&WHITE)?;
    let shown: Vec<Condition> = Condition::ALL.into_iter().filter(|c| *c != Condition::NoLiquid).collect();
    let mut chart = ChartBuilder::on(&area)
        .caption("height of the liquid's edge, measured less true, one dot a point", (FONT, 26))
        .margin(12)
        .x_label_area_size(40)
        .y_label_area_size(70)
        .build_cartesian_2d(0.0..shown.len() as f64, -3.0..3.0)?;
    let name = |x: &f64| {
        let at = x - 0.5;
        if at.fract().abs() < 0.01 {
            shown.get(at as usize).map_or("", |c| c.name()).to_owned()
        } else {
            String::new()
        }
    };
    chart
        .configure_mesh()
        .disable_x_mesh()
        .x_labels(2 * shown.len() + 1)
        .x_label_formatter(&name)
        .label_style((FONT, 18))
        .y_desc("error, mm (beyond 3 mm: at the border)")
        .draw()?;
    for (place, condition) in shown.iter().enumerate() {
        let points: Vec<_> =
            scenes.iter().filter(|j| j.case.condition == *condition).flat_map(|j| &j.points).collect();
        let across = |index: usize| place as f64 + 0.12 + 0.76 * (index as f64 * 0.618_034).fract();
        chart.draw_series(points.iter().enumerate().map(|(index, point)| {
            let inside = point.error_mm.abs() <= point.half_mm;
            let colour = if inside { BLUE.mix(0.35) } else { PURPLE.mix(0.9) };
            Circle::new((across(index), point.error_mm.clamp(-2.98, 2.98)), 2, colour.filled())
        }))?;
        let half = points.iter().map(|p| p.half_mm).sum::<f64>() / points.len().max(1) as f64;
        for side in [-half, half] {
            let ends = [(place as f64 + 0.06, side), (place as f64 + 0.94, side)];
            chart.draw_series([PathElement::new(ends, ORANGE.stroke_width(3))])?;
        }
    }
    let note = "orange: mean stated interval; purple: points outside of their own";
    area.draw(&Text::new(note, (90, 50), (FONT, 18).into_font().color(&GREY)))?;
    area.present()?;
    Ok(())
}

/// Writes the last frames of some scenes with what was measured in them and what is true.
///
/// # Errors
/// [`PictureError`].
pub fn scenes_png(scenes: &[Judged], path: &Path) -> Result<(), PictureError> {
    prepare_font();
    let size = ((SHEET.0 * TILE.0) as u32, (SHEET.1 * TILE.1) as u32);
    let area = BitMapBackend::new(path, size).into_drawing_area();
    area.fill(&WHITE)?;
    let tiles = area.split_evenly((SHEET.1, SHEET.0));
    // Three of each condition with clutter, two of the others, in the order of the set.
    let mut chosen: Vec<&Judged> = Vec::new();
    for condition in Condition::ALL {
        let count = if matches!(condition, Condition::Nominal | Condition::DoubleNoise) { 2 } else { 4 };
        let count = if condition == Condition::Holes { 1 } else { count };
        chosen.extend(scenes.iter().filter(|j| j.case.condition == condition).take(count));
    }
    for (tile, judged) in tiles.iter().zip(chosen) {
        draw_scene(judged, tile)?;
    }
    area.present()?;
    Ok(())
}

fn draw_scene<DB: DrawingBackend>(
    judged: &Judged,
    tile: &DrawingArea<DB, plotters::coord::Shift>,
) -> Result<(), PictureError>
where
    DB::ErrorType: 'static,
{
    let case = &judged.case;
    let Ok(config) = Config::new(case.settings.camera) else { return Ok(()) };
    let (width, height) = config.image_size();
    let camera = &case.settings.camera;
    let glass_x = case.glass_m(super::conditions::FRAMES - 1) as f32;
    // Twice enlarged around the middle of the glass.
    let (u, v) = config.pixel_of([glass_x, 0.0, 0.5 * camera.rim_m]);
    let corner = |at: f32, tile: usize, end: usize| {
        ((at - 0.25 * tile as f32).max(0.0) as usize).min(end.saturating_sub(tile / 2))
    };
    let (left, top) = (corner(u, TILE.0, width), corner(v, TILE.1, height));
    for y in 0..TILE.1 - 22 {
        for x in 0..TILE.0 - 2 {
            let grey = judged.last.0[(top + y / 2) * width + left + x / 2];
            tile.draw_pixel((x as i32, y as i32 + 20), &RGBColor(grey, grey, grey))?;
        }
    }
    let place = |index: usize, height_m: f32| {
        let [x, y, z] = config.wall_point(profile_abscissa(index) as f32, height_m);
        let (u, v) = config.pixel_of([x + glass_x, y, z]);
        ((2.0 * (u + 0.5 - left as f32)) as i32, (2.0 * (v + 0.5 - top as f32)) as i32 + 20)
    };
    if case.condition != Condition::NoLiquid {
        let truth: Vec<_> = (0..POINTS).map(|i| place(i, case.truth_m[i] as f32)).collect();
        tile.draw(&PathElement::new(truth, ORANGE.stroke_width(1)))?;
    }
    if let Some(profile) = &judged.last.1 {
        for index in (0..POINTS).filter(|&i| profile.valid[i]) {
            tile.draw(&Circle::new(place(index, profile.height_m[index]), 2, BLUE.filled()))?;
        }
    }
    let seen = if judged.last.1.is_some() { "" } else { ", not seen" };
    let text = format!(
        "{}, {}, {} m, {:.0} deg{seen}",
        case.condition.name(),
        LOOKS[case.look].0,
        DISTANCES_M[case.distance],
        case.tilt_deg
    );
    tile.draw(&Text::new(text, (2, 3), (FONT, 12).into_font().color(&BLACK)))?;
    Ok(())
}
