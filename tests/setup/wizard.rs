//! The wizard's screen from its first step to its last, and a picture of it for the tutorial.

use super::{SAID, look, pairs};
use meniscus::surface::{Config, Optics};
use meniscus_service::setup::{MeasuredGlass, Portrait};
use meniscus_ui::terminal::{Step, Wish, Wizard};
use meniscus_virtual::render::SceneSettings;
use ratatui::Terminal;
use ratatui::backend::TestBackend;
use ratatui::crossterm::event::{KeyCode, KeyEvent};
use ratatui::style::Color;
use std::path::Path;

/// Distance of the two sides in a drawn picture, characters: the median over its lines.
fn median_width(glass: &ratatui::buffer::Buffer) -> u16 {
    let apart = |y: u16| {
        let of = |x: &u16| glass[(*x, y)].fg == Color::Indexed(51);
        let all: Vec<u16> = (0..glass.area.width).filter(of).collect();
        (all.len() == 2).then(|| all[1] - all[0])
    };
    let mut widths: Vec<u16> = (0..glass.area.height).filter_map(apart).collect();
    widths.sort_unstable();
    widths[widths.len() / 2]
}

#[test]
fn the_wizard_draws_what_is_seen_and_leads_on() {
    let images = pairs(SceneSettings::default(), 24, 0.0, |_| 70.0);
    let portrait = || Portrait::of(&images, &Optics::default()).expect("images");
    let mut wizard =
        Wizard::new("a rendered camera".into(), Vec::new(), MeasuredGlass { radius_mm: 30.0, ..SAID });
    let mut terminal = Terminal::new(TestBackend::new(140, 44)).expect("a terminal");
    let mut draw = |wizard: &Wizard| {
        terminal.draw(|frame| wizard.draw(frame)).expect("drawn");
        terminal.backend().buffer().clone()
    };
    let text = |buffer: &ratatui::buffer::Buffer| -> String {
        buffer.content().iter().map(ratatui::buffer::Cell::symbol).collect()
    };
    let count = |buffer: &ratatui::buffer::Buffer, colour: u8| {
        let is = |c: Color| usize::from(c == Color::Indexed(colour));
        buffer.content().iter().map(|cell| is(cell.fg) + is(cell.bg)).sum::<usize>()
    };
    assert!(text(&draw(&wizard)).contains("waiting for the first images"));
    let show = |wizard: &mut Wizard| {
        let seen = look(&images, wizard.said().expect("numbers"));
        let settings = seen.setup.as_ref().map(|setup| setup.settings(Optics::default()));
        wizard.see(portrait(), seen, settings.and_then(|settings| Config::new(settings).ok()));
    };
    let press = |wizard: &mut Wizard, code| wizard.key(KeyEvent::from(code));

    assert_eq!(press(&mut wizard, KeyCode::Enter), Wish::None);
    show(&mut wizard);
    let glass = draw(&wizard);
    assert!(text(&glass).contains("distance_mm") && !text(&glass).contains(" -- "), "the place is well");
    let [sides, edge, points, rest] = [51, 214, 201, 226].map(|colour| count(&glass, colour));
    assert!(sides > 30 && edge > 10 && rest > 5, "{sides} {edge} {rest}");
    assert_eq!(points, 0, "the reader finds no glass of that radius");
    // The sides are as far apart as the glass is wide: 68 of the 256 columns that are shown in 86 characters.
    let width = median_width(&glass);
    assert!((21..=25).contains(&width), "{width} characters");

    press(&mut wizard, KeyCode::Char('d'));
    let depth = draw(&wizard);
    assert!(
        text(&depth).contains("depth") && count(&depth, 120) + count(&depth, 78) > 100,
        "the near glass in its colour"
    );

    press(&mut wizard, KeyCode::Enter);
    assert_eq!(wizard.step(), Step::Measure);
    let asked = text(&draw(&wizard));
    assert!(asked.contains("radius_seen_mm") && asked.contains(" -- "), "a wrong radius is marked");
    assert!(asked.contains("another radius than you"), "{asked}");
    // Digits replace the number that was offered, and a measure that the camera contradicts leads back to the measures.
    press(&mut wizard, KeyCode::Char('3'));
    press(&mut wizard, KeyCode::Char('1'));
    assert_eq!(wizard.said().expect("numbers").radius_mm, 31.0);
    assert_eq!(press(&mut wizard, KeyCode::Enter), Wish::Look);
    assert_eq!(wizard.step(), Step::Rest);
    show(&mut wizard);
    assert_eq!(wizard.step(), Step::Measure);
    let back = text(&draw(&wizard));
    assert!(back.contains("another radius than you") && back.contains("Enter goes on when this"), "{back}");
    press(&mut wizard, KeyCode::Backspace);
    press(&mut wizard, KeyCode::Backspace);
    assert!(text(&draw(&wizard)).contains("radius_mm: '' is no number"));
    assert_eq!(press(&mut wizard, KeyCode::Enter), Wish::None, "no way on without a number");
    assert!(text(&draw(&wizard)).contains("Enter goes on when this"), "Enter says why it leads nowhere");
    press(&mut wizard, KeyCode::Char('9'));
    assert!(text(&draw(&wizard)).contains("out of range: 10 to 60"));
    press(&mut wizard, KeyCode::Backspace);
    press(&mut wizard, KeyCode::Char('3'));
    press(&mut wizard, KeyCode::Char('5'));
    assert_eq!(press(&mut wizard, KeyCode::Enter), Wish::Look);
    assert_eq!(press(&mut wizard, KeyCode::Enter), Wish::None, "nothing was looked at yet");
    assert!(text(&draw(&wizard)).contains("Enter waits for the look"));
    show(&mut wizard);
    assert!(count(&draw(&wizard), 201) > 10, "the surface points");
    let all = text(&draw(&wizard));
    assert!(all.contains("rest_noise_mm") && all.contains("Enter writes the settings"));
    if let Some(path) = std::env::var_os("MENISCUS_SETUP_PICTURE") {
        press(&mut wizard, KeyCode::Char('d'));
        let shot = draw(&wizard);
        paint(&shot, Path::new(&path));
    }
    assert_eq!(press(&mut wizard, KeyCode::Enter), Wish::Save);
    assert_eq!(press(&mut wizard, KeyCode::Char('q')), Wish::Leave);
}

/// A terminal's buffer as a picture, for docs/tutorial.md: 8 x 16 pixels a character.
fn paint(buffer: &ratatui::buffer::Buffer, path: &Path) {
    use meniscus_report::plot::{MONOSPACE, prepare_font};
    use plotters::prelude::{
        BitMapBackend, Color as _, IntoDrawingArea, IntoFont, RGBColor, Rectangle, Text,
    };
    prepare_font();
    let (wide, high) = (u32::from(buffer.area.width), u32::from(buffer.area.height));
    let area = BitMapBackend::new(path, (8 * wide, 16 * high)).into_drawing_area();
    area.fill(&RGBColor(24, 24, 24)).expect("drawn");
    let rgb = |colour: Color, otherwise: u8| match colour {
        Color::Indexed(grey @ 232..) => {
            RGBColor(8 + 10 * (grey - 232), 8 + 10 * (grey - 232), 8 + 10 * (grey - 232))
        }
        Color::Indexed(cube @ 16..) => {
            let level = |k: u8| if k == 0 { 0 } else { 55 + 40 * k };
            let cube = cube - 16;
            RGBColor(level(cube / 36), level(cube / 6 % 6), level(cube % 6))
        }
        Color::Green => RGBColor(80, 200, 120),
        Color::Red => RGBColor(230, 90, 80),
        Color::Yellow => RGBColor(220, 190, 80),
        Color::Black => RGBColor(0, 0, 0),
        _ => RGBColor(otherwise, otherwise, otherwise),
    };
    let cells = || (0..buffer.area.height).flat_map(|y| (0..buffer.area.width).map(move |x| (x, y)));
    let place = |x: u16, y: u16| (8 * i32::from(x), 16 * i32::from(y));
    for (x, y) in cells() {
        let (cell, (left, top)) = (&buffer[(x, y)], place(x, y));
        let fill = |from: i32, to: i32, colour: RGBColor| {
            let rectangle = Rectangle::new([(left, top + from), (left + 8, top + to)], colour.filled());
            area.draw(&rectangle).expect("drawn");
        };
        fill(0, 16, rgb(cell.bg, 24));
        if cell.symbol() == "▀" {
            fill(0, 8, rgb(cell.fg, 210));
        }
    }
    // After all backgrounds, because a letter may be higher than its cell.
    for (x, y) in cells() {
        let (cell, (left, top)) = (&buffer[(x, y)], place(x, y));
        if !matches!(cell.symbol(), "▀" | " ") {
            let style = (MONOSPACE, 13).into_font().color(&rgb(cell.fg, 210));
            area.draw(&Text::new(cell.symbol().to_owned(), (left, top + 3), style)).expect("drawn");
        }
    }
    area.present().expect("written");
}
