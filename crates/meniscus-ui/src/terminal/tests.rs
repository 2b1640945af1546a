//! The dashboard in a terminal in memory.

use super::dashboard::{Caption, Dashboard};
use meniscus::blob::{FieldGroup, KnownGroups, Model};
use meniscus::runtime::{Estimator, Memory, Mode, Turn, TurnInput};
use meniscus::surface::{POINTS, SurfaceProfile, profile_abscissa};
use meniscus::units::Micros;
use meniscus_data::validity::Validity;
use meniscus_platform::clock::Monotonic;
use meniscus_platform::files::AlignedBytes;
use meniscus_service::timed_turn::TimedTurn;
use ratatui::Terminal;
use ratatui::backend::TestBackend;
use ratatui::buffer::Buffer;
use ratatui::style::Color;
use std::time::Duration;

/// A turn of a liquid that moves and whose surface rises to the right by 6 mm a radius.
fn turn(model: &Model<'_>) -> TimedTurn {
    let mut memory = Memory::default();
    let mut estimate =
        Estimator::new(model).turn(&mut memory, TurnInput::default(), &mut Monotonic::start(), &mut []);
    estimate.mode = Mode::Tracking;
    estimate.latent[1] = 1.0;
    let height = |index: usize| (model.header.fill_m + 0.006 * profile_abscissa(index)) as f32;
    estimate.surface_m = std::array::from_fn(height);
    let profile = SurfaceProfile {
        height_m: std::array::from_fn(height),
        variance_m2: [1e-8; POINTS],
        valid: [true; POINTS],
        glass_x_m: None,
        sequence: 1,
        captured: Micros(1),
    };
    TimedTurn::untimed(Turn { time: Micros(1), stamp: None, profile: Some(Ok(profile)), estimate })
}

/// Returns what a dashboard of `columns` by `rows` shows of the turn.
fn shown(model: &Model<'_>, columns: u16, rows: u16) -> Buffer {
    let caption = Caption {
        title: "glycerine, simulated D435, model shipped".into(),
        length: Duration::from_secs(20),
        validity: Validity::of(&model.header),
    };
    let mut dashboard = Dashboard::new(model, caption);
    let logged = turn(model);
    dashboard.remember(&logged);
    let mut terminal = Terminal::new(TestBackend::new(columns, rows)).expect("a terminal in memory");
    terminal.draw(|frame| dashboard.draw(frame, Some(&logged))).expect("drawn").buffer.clone()
}

fn lines(buffer: &Buffer) -> Vec<String> {
    let width = usize::from(buffer.area.width);
    let line = |cells: &[ratatui::buffer::Cell]| cells.iter().map(|cell| cell.symbol()).collect();
    buffer.content().chunks(width).map(line).collect()
}

/// Pixels of the liquid in the section: half blocks of a colour beside the greys of the glass.
fn liquid(buffer: &Buffer) -> Vec<(usize, Color)> {
    let half = |cell: &ratatui::buffer::Cell| {
        let colours = match cell.symbol() {
            "▀" => vec![cell.fg, cell.bg],
            "▄" => vec![cell.fg],
            _ => vec![],
        };
        // The front of a half block in the terminal's own colour would be a stripe of letters' colour in the air.
        assert!(colours.first() != Some(&Color::Reset));
        colours.into_iter().filter(|colour| !matches!(colour, Color::Reset | Color::Indexed(250)))
    };
    let width = usize::from(buffer.area.width);
    let cells = buffer.content().iter().enumerate();
    cells.flat_map(|(place, cell)| half(cell).map(move |colour| (place % width, colour))).collect()
}

#[test]
fn a_small_and_a_large_terminal_show_the_liquid_and_every_figure() {
    let bytes = AlignedBytes::copy(meniscus_shipped::MODEL);
    let model = Model::load(&bytes).expect("the shipped model");
    for (columns, rows) in [(80, 24), (120, 40)] {
        let buffer = shown(&model, columns, rows);
        let text = lines(&buffer).join("\n");
        println!("{text}");
        let words = [
            "Tracking",
            "q ends",
            "model shipped",
            "21 of 21 points",
            "late or lost",
            "energy error",
            "heat made",
            "measured",
            "estimate",
            "rest",
            "surface z, mm",
            "x, mm",
            "mm/s",
            "slosh energy",
            "speed inside",
        ];
        for word in words {
            assert!(text.contains(word), "{columns}x{rows}: {word} is cut:\n{text}");
        }
        assert!(!text.contains("more in a higher window"), "{text}");
        let pixels = liquid(&buffer);
        // The section of a glass that is filled to three quarters.
        assert!(pixels.len() > usize::from(rows) * 10, "{} pixels of liquid", pixels.len());
        let colours: std::collections::BTreeSet<_> =
            pixels.iter().map(|(_, colour)| format!("{colour:?}")).collect();
        assert!(colours.len() > 2, "the speeds differ: {colours:?}");
        let of = |wanted: usize| pixels.iter().filter(|(column, _)| *column == wanted).count();
        let (left, right) =
            pixels.iter().fold((usize::MAX, 0), |(left, right), (x, _)| (left.min(*x), right.max(*x)));
        assert!(of(right) > of(left), "the liquid is higher at the right: {} for {}", of(right), of(left));
    }
}

#[test]
fn a_low_terminal_says_what_it_leaves_out() {
    let bytes = AlignedBytes::copy(meniscus_shipped::MODEL);
    let model = Model::load(&bytes).expect("the shipped model");
    let text = lines(&shown(&model, 80, 20)).join("\n");
    assert!(text.contains("more in a higher window"), "{text}");
    // Nothing is drawn where nothing fits, and nothing panics.
    for (columns, rows) in [(1, 1), (20, 5), (40, 12), (300, 100)] {
        shown(&model, columns, rows);
    }
}

#[test]
fn a_speed_that_is_not_known_has_no_colour() {
    let bytes = AlignedBytes::copy(meniscus_shipped::MODEL);
    let mut model = Model::load(&bytes).expect("the shipped model");
    let known = KnownGroups::NONE.with(FieldGroup::Position);
    model.header.stated_known = known;
    let buffer = shown(&model, 80, 24);
    let pixels = liquid(&buffer);
    assert!(!pixels.is_empty());
    assert!(pixels.iter().all(|(_, colour)| *colour == Color::Indexed(243)), "{pixels:?}");
    let text = lines(&buffer).join("\n");
    assert!(text.contains("not known"), "{text}");
}
