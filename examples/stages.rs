//! Picture of one frame on its way through the model: image, window of surface heights, latents, field. The documentation
//! has it (`docs/stages.png`).
//!
//! `cargo run --release -p meniscus-examples --example stages -- stages.png`

use meniscus::blob::{KnownGroups, Model};
use meniscus::runtime::InputSource;
use meniscus::surface::{Config, profile_abscissa};
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_data::recording::{Lattice, Recording, STATE};
use meniscus_platform::files::AlignedBytes;
use meniscus_report::plot::{FONT, GREY, ORANGE, prepare_font};
use meniscus_score::score::field_of;
use meniscus_ui::figure_parts::{camera, slice};
use meniscus_ui::picture::{CameraImage, Slice};
use meniscus_virtual::observe_recording::{sightings, turns_with};
use meniscus_virtual::render::{Images, Liquid, Scene, SceneSettings};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::colors::colormaps::{ColorMap, ViridisRGB};
use std::error::Error;

/// Frames that the encoder reads.
const WINDOW: usize = 16;
/// Frames whose latents are drawn: one second.
const SECOND: usize = 60;
/// Height above and below the surface at rest that is drawn, mm.
const REACH_MM: f64 = 15.0;
const SIZE: (u32, u32) = (1600, 470);
const LETTER: u32 = 17;

type Panel<'a> = DrawingArea<BitMapBackend<'a>, Shift>;
type Drawn = Result<(), Box<dyn Error>>;

fn main() -> Drawn {
    let path = std::env::args().nth(1).ok_or("a path for the picture is missing: stages.png")?;
    let recording = Recording::load("recordings/glycerine-unseen.safetensors".as_ref())?;
    let settings = SceneSettings::of(&recording.glass);
    let seen = sightings(&recording, settings)?;
    let bytes = AlignedBytes::copy(meniscus_shipped::MODEL);
    let model = Model::load(&bytes)?;
    let turns = turns_with(&model, &seen, |_| InputSource::Tracked, |_, _, _| {});

    // The frame behind the first second at which the surface rises fastest at the wall.
    let rise = |frame: usize| recording.profile(frame)[0] - recording.profile(frame - 1)[0];
    let frame = (SECOND..turns.len()).max_by(|a, b| rise(*a).total_cmp(&rise(*b)));
    let frame = frame.ok_or("the recording is shorter than a second")?;
    let turn = &turns[frame].turn;
    let mut state = vec![0.0; STATE];
    field_of(&model, &turn.estimate, &mut state);

    let config = Config::new(settings.camera)?;
    let mut images = Images::new(&settings);
    Scene::new(settings).render(&Liquid::of(&recording, frame), frame as u64, &mut images);
    // The older a profile, the paler.
    let window = (0..WINDOW).rev().filter_map(|age| {
        let profile = seen[frame - age]?;
        let heights = profile.height_m.iter().enumerate();
        let x_mm = |k| 1e3 * recording.glass.radius_m * profile_abscissa(k);
        let line = heights.map(|(k, z)| (x_mm(k), 1e3 * f64::from(*z))).collect();
        Some((line, ORANGE.mix((1.0 - age as f64 / WINDOW as f64).powi(2))))
    });
    let latents = turns[frame + 1 - SECOND..=frame].iter().map(|turn| turn.turn.estimate.latent);
    let latents: Vec<_> = latents.collect();
    let in_time = (0..latents[0].len()).map(|latent| {
        let now = |k: usize| (k + 1) as f64 - SECOND as f64;
        let line = latents.iter().enumerate().map(|(k, y)| (FRAME_INTERVAL_S * now(k), y[latent])).collect();
        (line, Palette99::pick(latent).mix(0.9))
    });
    let section = slice(&Lattice::new(&recording.glass), &recording, KnownGroups::ALL, &state);

    prepare_font();
    let area = BitMapBackend::new(&path, SIZE).into_drawing_area();
    area.fill(&WHITE)?;
    let panels = area.split_evenly((1, 4));
    draw_image(&panels[0], &camera(&config, &recording, &images.infrared, turn, frame))?;
    let (half_mm, rim_mm) = (1e3 * recording.glass.radius_m, 1e3 * recording.glass.rim_m);
    let fill_mm = 1e3 * recording.glass.fill_m;
    let heights = Plane {
        title: "2. window: the last 16 profiles",
        x: (-half_mm, half_mm, "x, mm"),
        y: (fill_mm - REACH_MM, fill_mm + REACH_MM, "height, mm"),
        decimals: 0,
    };
    heights.draw(&panels[1], window)?;
    let most = latents.iter().flatten().fold(0.1, |most, y| y.abs().max(most)) * 1.05;
    let states = Plane {
        title: "3. state: 13 latents",
        x: (-1.0, 0.0, "time before this frame, s"),
        y: (-most, most, "latent"),
        decimals: 1,
    };
    states.draw(&panels[2], in_time)?;
    draw_field(&panels[3], &section, half_mm, rim_mm)?;
    area.present()?;
    Ok(())
}

/// The camera's image around the glass, with the points of the surface on it.
fn draw_image(panel: &Panel<'_>, image: &CameraImage<'_>) -> Drawn {
    let panel = panel.titled("1. image: 21 points of the edge", (FONT, LETTER))?;
    let (left, top, width, height) = image.crop;
    let (across, down) = panel.dim_in_pixel();
    let zoom = (f64::from(across - LETTER) / width as f64).min(f64::from(down - LETTER) / height as f64);
    let aside = 0.5 * (f64::from(across) - zoom * width as f64);
    let place = |u: f64, v: f64| {
        ((aside + (u - left as f64) * zoom).round() as i32, ((v - top as f64) * zoom).round() as i32)
    };
    for (row, column) in (top..top + height).flat_map(|row| (left..left + width).map(move |c| (row, c))) {
        let grey = image.infrared[row * image.size.0 + column];
        let (u, v) = (column as f64, row as f64);
        let pixel =
            Rectangle::new([place(u, v), place(u + 1.0, v + 1.0)], RGBColor(grey, grey, grey).filled());
        panel.draw(&pixel)?;
    }
    for (u, v) in &image.measured {
        let middle = place(f64::from(*u) + 0.5, f64::from(*v) + 0.5);
        panel.draw(&Circle::new(middle, 4, ORANGE.filled()))?;
    }
    Ok(())
}

/// Axes of curves: least and largest value with a name.
struct Plane {
    title: &'static str,
    x: (f64, f64, &'static str),
    y: (f64, f64, &'static str),
    decimals: usize,
}

impl Plane {
    fn draw(&self, panel: &Panel<'_>, lines: impl Iterator<Item = (Vec<(f64, f64)>, RGBAColor)>) -> Drawn {
        let (x, y, decimals) = (self.x, self.y, self.decimals);
        let mut chart = ChartBuilder::on(panel)
            .caption(self.title, (FONT, LETTER))
            .margin(8)
            .x_label_area_size(3 * LETTER)
            .y_label_area_size(4 * LETTER)
            .build_cartesian_2d(x.0..x.1, y.0..y.1)?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(GREY.mix(0.25))
            .x_labels(5)
            .y_labels(6)
            .x_label_formatter(&|x| format!("{x:.decimals$}"))
            .y_label_formatter(&|y| format!("{y:.decimals$}"))
            .label_style((FONT, LETTER - 3))
            .x_desc(x.2)
            .y_desc(y.2)
            .draw()?;
        for (line, colour) in lines {
            chart.draw_series(LineSeries::new(line, colour.stroke_width(2)))?;
        }
        Ok(())
    }
}

/// Tracers in the middle of the glass, coloured by their speed.
fn draw_field(panel: &Panel<'_>, section: &Slice, half_mm: f64, rim_mm: f64) -> Drawn {
    let fastest = section.values().fold(0.0, f64::max);
    let mut chart = ChartBuilder::on(panel)
        .caption(format!("4. field: speed, 0 to {fastest:.2} m/s"), (FONT, LETTER))
        .margin(8)
        .x_label_area_size(3 * LETTER)
        .y_label_area_size(4 * LETTER)
        .build_cartesian_2d(-1.1 * half_mm..1.1 * half_mm, 0.0..rim_mm)?;
    let millimetres = |value: &f64| format!("{value:.0}");
    chart
        .configure_mesh()
        .disable_mesh()
        .x_labels(5)
        .y_labels(6)
        .x_label_formatter(&millimetres)
        .y_label_formatter(&millimetres)
        .label_style((FONT, LETTER - 3))
        .x_desc("x, mm")
        .y_desc("z, mm")
        .draw()?;
    let wall = vec![(-half_mm, rim_mm), (-half_mm, 0.0), (half_mm, 0.0), (half_mm, rim_mm)];
    chart.draw_series([PathElement::new(wall, GREY.stroke_width(2))])?;
    chart.draw_series(section.tracers.iter().map(|tracer| {
        let share = tracer.value.unwrap_or(0.0) / fastest;
        Circle::new(tracer.at_mm, 5, ViridisRGB.get_color(share as f32).filled())
    }))?;
    Ok(())
}
