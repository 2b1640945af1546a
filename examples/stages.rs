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
use meniscus_ui::picture::{Panel, SliceChart};
use meniscus_virtual::observe_recording::{sightings, turns_with};
use meniscus_virtual::render::{Images, Liquid, Scene, SceneSettings};
use plotters::prelude::*;
use std::error::Error;

/// Frames that the encoder reads.
const WINDOW: usize = 16;
/// Frames whose latents are drawn: one second.
const SECOND: usize = 60;
/// Height above and below the surface at rest that is drawn, mm.
const REACH_MM: f64 = 15.0;
const SIZE: (u32, u32) = (1600, 470);
const LETTER: u32 = 17;

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
    let image = panels[0].titled("1. image: 21 points; the estimate is green", (FONT, LETTER))?;
    camera(&config, &recording, &images.infrared, turn, frame).draw(&image)?;
    let (half_mm, rim_mm) = (1e3 * recording.glass.radius_m, 1e3 * recording.glass.rim_m);
    let fill_mm = 1e3 * recording.glass.fill_m;
    let heights = Plane {
        title: "2. window: the last 16 profiles",
        x: Axis { low: -half_mm, high: half_mm, name: "x, mm" },
        y: Axis { low: fill_mm - REACH_MM, high: fill_mm + REACH_MM, name: "height, mm" },
        decimals: 0,
    };
    heights.draw(&panels[1], window)?;
    let most = latents.iter().flatten().fold(0.1, |most, y| y.abs().max(most)) * 1.05;
    let states = Plane {
        title: "3. state: 13 latents",
        x: Axis { low: -1.0, high: 0.0, name: "time before this frame, s" },
        y: Axis { low: -most, high: most, name: "latent" },
        decimals: 1,
    };
    states.draw(&panels[2], in_time)?;
    let top = section.values().fold(0.0, f64::max);
    let caption = format!("4. field: speed, violet 0 to yellow {top:.2} m/s");
    let field = SliceChart { caption: &caption, glass_mm: (half_mm, rim_mm), letter: LETTER - 3, top };
    field.draw(&panels[3], &section)?;
    area.present()?;
    Ok(())
}

/// An axis with its name and unit.
struct Axis {
    low: f64,
    high: f64,
    name: &'static str,
}

/// Axes of curves.
struct Plane {
    title: &'static str,
    x: Axis,
    y: Axis,
    decimals: usize,
}

impl Plane {
    fn draw(&self, panel: &Panel<'_>, lines: impl Iterator<Item = (Vec<(f64, f64)>, RGBAColor)>) -> Drawn {
        let (x, y, decimals) = (&self.x, &self.y, self.decimals);
        let mut chart = ChartBuilder::on(panel)
            .caption(self.title, (FONT, LETTER))
            .margin(8)
            .x_label_area_size(3 * LETTER)
            .y_label_area_size(4 * LETTER)
            .build_cartesian_2d(x.low..x.high, y.low..y.high)?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(GREY.mix(0.25))
            .x_labels(5)
            .y_labels(6)
            .x_label_formatter(&|x| format!("{x:.decimals$}"))
            .y_label_formatter(&|y| format!("{y:.decimals$}"))
            .label_style((FONT, LETTER - 3))
            .x_desc(x.name)
            .y_desc(y.name)
            .draw()?;
        for (line, colour) in lines {
            chart.draw_series(LineSeries::new(line, colour.stroke_width(2)))?;
        }
        Ok(())
    }
}
