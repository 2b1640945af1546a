//! Picture of one recording: the prediction of each liquid, and its probability over time.

use super::study::recognise;
use meniscus::identify::slope;
use meniscus::surface::SurfaceProfile;
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_report::plot::{
    BLUE, FONT, GREEN, GREY, ORANGE, PURPLE, PictureError, SKY, VERMILION, legend, prepare_font,
};
use meniscus_service::identify::{MOST, Note, Standing};
use plotters::coord::Shift;
use plotters::prelude::*;
use std::path::Path;

/// Width and height, pixels.
const SIZE: (u32, u32) = (1200, 760);

/// Colours of the liquids, in their order; a seventh and further ones begin again.
const COLOURS: [RGBColor; 6] = [BLUE, ORANGE, GREEN, PURPLE, VERMILION, SKY];

/// Curve of the picture.
struct Curve {
    name: String,
    colour: RGBColor,
    points: Vec<(f64, f64)>,
}

/// Draws `profiles` with the predictions of `notes` as a PNG file, and returns their verdict.
///
/// # Errors
/// [`PictureError`], when the file cannot be written.
pub fn picture(
    notes: &[Note],
    fill_m: f64,
    profiles: &[Option<SurfaceProfile>],
    title: &str,
    path: &Path,
) -> Result<Standing, PictureError> {
    let time = |frame: usize| frame as f64 * FRAME_INTERVAL_S;
    let mut waves: Vec<Vec<(f64, f64)>> = vec![Vec::new(); notes.len()];
    let mut probability: Vec<Vec<(f64, f64)>> = vec![Vec::new(); notes.len() + 1];
    let standing = recognise(notes, fill_m, profiles, |frame, trail, recogniser| {
        let mut probabilities = [0.0; MOST];
        let room = &mut probabilities[..notes.len()];
        let verdict = recogniser.verdict(trail, room);
        for (curve, p) in probability.iter_mut().zip(room.iter().chain([&verdict.none])) {
            curve.push((time(frame), *p));
        }
        for (index, wave) in waves.iter_mut().enumerate() {
            wave.extend(trail.height_m(index).map(|s| (time(frame), 1e3 * s)));
        }
    });
    let colour = |index: usize| COLOURS[index % COLOURS.len()];
    let named = |index: usize| notes.get(index).map_or("none of these", |note| note.liquid.as_str());
    let curves = |of: Vec<Vec<(f64, f64)>>| -> Vec<Curve> {
        let curve = |(index, points): (usize, Vec<(f64, f64)>)| Curve {
            name: named(index).into(),
            colour: if index < notes.len() { colour(index) } else { GREY },
            points,
        };
        of.into_iter().enumerate().map(curve).collect()
    };
    let measured: Vec<(f64, f64)> = (profiles.iter().enumerate())
        .filter_map(|(frame, profile)| Some((time(frame), 1e3 * slope(profile.as_ref()?, fill_m)?.height_m)))
        .collect();
    prepare_font();
    let area = BitMapBackend::new(path, SIZE).into_drawing_area();
    area.fill(&WHITE)?;
    let (upper, lower) = area.split_vertically(440);
    let end_s = time(profiles.len());
    let top = 1.3 * measured.iter().map(|(_, s)| s.abs()).fold(1.0, f64::max);
    let heights = Axes { end_s, range: -top..top, unit: "height of the first mode, mm" };
    draw(&upper, &format!("{title}: {}", standing.line()), &heights, &curves(waves), Some(&measured))?;
    let probabilities = Axes { end_s, range: 0.0..1.05, unit: "probability" };
    draw(&lower, "", &probabilities, &curves(probability), None)?;
    area.present()?;
    Ok(standing)
}

/// Axes of one half of the picture.
struct Axes {
    /// Length of the recording, s.
    end_s: f64,
    /// Range of the vertical axis.
    range: std::ops::Range<f64>,
    /// Name and unit of the vertical axis.
    unit: &'static str,
}

/// Draws one half of the picture.
fn draw(
    area: &DrawingArea<BitMapBackend<'_>, Shift>,
    title: &str,
    axes: &Axes,
    curves: &[Curve],
    measured: Option<&[(f64, f64)]>,
) -> Result<(), PictureError> {
    let mut builder = ChartBuilder::on(area);
    builder.margin(10).x_label_area_size(38).y_label_area_size(58);
    if !title.is_empty() {
        builder.caption(title, (FONT, 20));
    }
    // Room beside the curves for their names.
    let mut chart = builder.build_cartesian_2d(0.0..1.22 * axes.end_s, axes.range.clone())?;
    chart
        .configure_mesh()
        .light_line_style(WHITE)
        .x_desc("time, s")
        .y_desc(axes.unit)
        .label_style((FONT, 14))
        .draw()?;
    if let Some(points) = measured {
        let dots = points.iter().map(|p| Circle::new(*p, 2, BLACK.filled()));
        chart
            .draw_series(dots)?
            .label("measured")
            .legend(|(x, y)| Circle::new((x + 10, y), 3, BLACK.filled()));
    }
    for curve in curves {
        let colour = curve.colour;
        chart
            .draw_series(LineSeries::new(curve.points.iter().copied(), colour.stroke_width(2)))?
            .label(curve.name.as_str())
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], colour.stroke_width(3)));
    }
    legend(&mut chart, SeriesLabelPosition::UpperRight)?;
    Ok(())
}
