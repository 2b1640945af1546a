//! A glass of one's own: what was said of it against rendered images of it, the wizard's screen, and the file in use.

#[path = "support/findings.rs"]
mod findings;
#[path = "support/optional.rs"]
mod optional;

use findings::{missed, value};
use meniscus::blob::Model;
use meniscus::surface::{Config, Liquid, Optics, Settings};
use meniscus::units::Micros;
use meniscus::usb::frame::Stamp;
use meniscus::usb::uvc::Stream;
use meniscus_bags as bag;
use meniscus_bags::observe_images;
use meniscus_bags::{Calibration, Image};
use meniscus_platform::files::AlignedBytes;
use meniscus_service::setup::{Inspection, MeasuredGlass, Pair, Portrait, Setup, SetupOrigin, inspect};
use meniscus_ui::terminal::{Step, Wish, Wizard};
use meniscus_usb::camera::OutlineImage;
use meniscus_virtual::render::{Clutter, Images, Liquid as Seen, Scene, SceneSettings};
use ratatui::Terminal;
use ratatui::backend::TestBackend;
use ratatui::crossterm::event::{KeyCode, KeyEvent};
use ratatui::style::Color;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The glass of the tests, as a person would say it.
const SAID: MeasuredGlass = MeasuredGlass::of([35.0, 70.0, 110.0]);

/// `count` pairs of a glass whose liquid stands at `height_mm` of a frame's number.
fn pairs(settings: SceneSettings, count: u64, x_m: f64, height_mm: impl Fn(u64) -> f64) -> Vec<Pair> {
    let (mut scene, mut images) = (Scene::new(settings), Images::new(&settings));
    let pair = |frame: u64| {
        let height_m = (1e-3 * height_mm(frame)) as f32;
        let liquid = Seen { glass_m: [x_m, 0.0], wall_m: &[height_m; 72], column_m: &[height_m; 194] };
        scene.render(&liquid, frame, &mut images);
        let stamp = Stamp { sequence: frame as u32, captured: Micros(16_667 * frame) };
        Pair { depth: Some(images.depth.clone()), outline: images.infrared.clone(), stamp }
    };
    (0..count).map(pair).collect()
}

fn look(pairs: &[Pair], said: MeasuredGlass) -> Inspection {
    let outline = OutlineImage::Infrared;
    let origin = SetupOrigin { outline, camera: "a rendered camera", made_by: "a test" };
    inspect(pairs, Optics::default(), said, origin)
}

/// The same glass at rest, `count` times, under `settings`.
fn at_rest(settings: SceneSettings, said: MeasuredGlass) -> Inspection {
    look(&pairs(settings, 24, 0.004, |_| 70.0), said)
}

/// A camera elsewhere than the settings' own.
fn camera(distance_m: f32, height_m: f32, pitch_deg: f32, liquid: Liquid) -> SceneSettings {
    let camera = Settings {
        camera_distance_m: distance_m,
        camera_height_m: height_m,
        camera_pitch_rad: pitch_deg.to_radians(),
        liquid,
        ..Settings::default()
    };
    SceneSettings { camera, ..SceneSettings::default() }
}

#[test]
fn the_camera_is_found_where_it_stands() {
    let table = [
        (0.40, 0.030, 0.0, Liquid::Dark),
        (0.33, 0.045, -6.0, Liquid::Dark),
        (0.52, 0.020, 5.0, Liquid::Dark),
        (0.45, 0.050, -9.0, Liquid::Bright),
    ];
    for (distance_m, height_m, pitch_deg, liquid) in table {
        let seen = at_rest(camera(distance_m, height_m, pitch_deg, liquid), SAID);
        let checks: Vec<_> = seen.findings.iter().map(|finding| &finding.check).collect();
        assert!(seen.ok(), "{distance_m} m, {pitch_deg} degrees: {:?}\n{checks:#?}", missed(&seen));
        let view = &seen.setup.as_ref().expect("a setup").view;
        println!("{distance_m} m: {view:?}, radius {:.2} mm", value(&seen, "radius_seen_mm"));
        assert!((view.distance_mm - 1e3 * f64::from(distance_m)).abs() < 3.0, "{view:?}");
        assert!((view.height_mm - 1e3 * f64::from(height_m)).abs() < 3.0, "{view:?}");
        assert!((view.pitch_deg - f64::from(pitch_deg)).abs() < 0.7, "{view:?}");
        // The sides of a bright liquid are shaded, so that it looks a little narrower.
        assert!((value(&seen, "radius_seen_mm") - 35.0).abs() < 1.0);
        assert!((value(&seen, "offset_mm") - 4.0).abs() < 1.0);
    }
}

/// A camera that is not where the settings without a setup have it: with the file the profile is the true one.
#[test]
fn the_file_brings_the_surface_to_where_it_is() {
    let elsewhere = camera(0.46, 0.042, -5.0, Liquid::Dark);
    let seen = at_rest(elsewhere, SAID);
    let path = folder("elsewhere").join("deep/glass.toml");
    seen.setup.as_ref().expect("a setup").write(&path).expect("written");
    let setup = Setup::read(&path).expect("read back");
    assert_eq!(Some(&setup), seen.setup.as_ref());
    let higher = pairs(elsewhere, 10, -0.01, |_| 73.0);
    let of = |settings| meniscus_service::setup::Rest::of(&higher, &Config::new(settings).expect("settings"));
    let with = of(setup.settings(Optics::default()));
    assert!((with.level_mm - 73.0).abs() < 0.3 && with.seen == 1.0, "{with:?}");
    let without = of(Settings::default());
    assert!(without.seen == 0.0 || (without.level_mm - 73.0).abs() > 2.0, "{without:?}");
}

#[test]
fn a_wrong_measure_is_named_with_what_to_do() {
    let glass = SceneSettings::default();
    for (said, name) in [
        (MeasuredGlass { radius_mm: 31.0, ..SAID }, "radius_seen_mm"),
        (MeasuredGlass { radius_mm: 38.0, ..SAID }, "radius_seen_mm"),
        (MeasuredGlass { fill_mm: 60.0, ..SAID }, "fill_seen_mm"),
        (MeasuredGlass { fill_mm: 79.0, ..SAID }, "fill_seen_mm"),
    ] {
        let seen = at_rest(glass, said);
        assert!(missed(&seen).contains(&name), "{said:?}: {:?}", missed(&seen));
        let remedies = seen.remedies();
        assert!(
            remedies.iter().any(|one| one.check.name == name && one.remedy.contains("measure")),
            "{remedies:?}"
        );
    }
    assert!(MeasuredGlass { fill_mm: 110.0, ..SAID }.check().is_err_and(|what| what.contains("rim")));
    assert!(
        MeasuredGlass { radius_mm: f64::NAN, ..SAID }.check().is_err_and(|what| what.contains("10 to 60"))
    );
}

#[test]
fn no_glass_a_clear_liquid_and_one_that_moves_are_distinguished() {
    let nothing = at_rest(SceneSettings { glass_present: false, ..SceneSettings::default() }, SAID);
    assert!(nothing.setup.is_none() && missed(&nothing).contains(&"liquid_seen"));
    assert!(nothing.remedies()[0].remedy.contains("before the middle of the camera"));
    assert!(look(&[], SAID).setup.is_none(), "no images at all");

    let clear = |clear| SceneSettings {
        clutter: Clutter { clear, ..Clutter::default() },
        ..SceneSettings::default()
    };
    let through = at_rest(clear(0.6), SAID);
    assert_eq!(value(&through, "opaque"), 0.0, "{:?}", missed(&through));
    assert!(
        through.remedies().iter().any(|one| one.remedy.contains("transparent")),
        "{:?}",
        through.remedies()
    );
    let water = at_rest(clear(0.97), SAID);
    assert!(water.setup.is_none() && water.remedies()[0].remedy.contains("clear in the near infrared"));

    let swinging =
        look(&pairs(SceneSettings::default(), 24, 0.0, |k| 70.0 + 2.0 * (0.5 * k as f64).sin()), SAID);
    assert!(missed(&swinging).contains(&"rest_noise_mm"), "{:?}", missed(&swinging));
}

/// Input of `correct`: one position for each frame interval, empty where the camera brought nothing.
#[test]
fn a_cameras_recording_is_read_interval_by_interval() {
    let shots = pairs(SceneSettings::default(), 16, 0.0, |_| 70.0);
    let kept = shots.into_iter().enumerate().filter(|(frame, _)| *frame != 7);
    let images = kept.flat_map(|(_, Pair { depth, outline, stamp })| {
        let stamp = Stamp { captured: Micros(stamp.captured.0 + 5_000_000), ..stamp };
        let depth = depth.expect("a camera with depth");
        [(Stream::Depth, depth), (Stream::Outline, outline)].map(|(stream, pixels)| Image {
            stream,
            stamp,
            pixels,
        })
    });
    let images: Vec<_> = images.map(Ok).collect();
    let calibration = Calibration::of(&Optics::default(), 0.05, "a rendered camera");
    let recording = bag::Recording { calibration, images: Box::new(images.into_iter()) };
    let config = Config::new(Settings::default()).expect("settings");
    let seen = observe_images(recording, config).expect("whole");
    let empty: Vec<usize> = (0..seen.len()).filter(|frame| seen[*frame].is_none()).collect();
    assert_eq!((seen.len(), empty), (16, vec![7]));
}

#[test]
fn a_setup_of_another_glass_is_refused_by_the_model() {
    let bytes = AlignedBytes::copy(meniscus_shipped::MODEL);
    let header = Model::load(&bytes).expect("the shipped model").header;
    let setup = at_rest(SceneSettings::default(), SAID).setup.expect("a setup");
    let with =
        |glass: MeasuredGlass| Setup { glass, ..setup.clone() }.settings_for(&header, Optics::default());
    let near = with(MeasuredGlass::of([35.4, 69.5, 105.0])).expect("within what a person measures");
    assert!((near.radius_m, near.fill_m) == (0.035, 0.070), "the model's measures hold");
    assert!(
        (1e3 * f64::from(near.camera_height_m) - setup.view.height_mm - 0.5).abs() < 1e-3,
        "the camera moves"
    );
    let far = with(MeasuredGlass { radius_mm: 30.0, ..SAID }).expect_err("another glass");
    assert!(far.to_string().contains("radius 35.0 mm, the setup says 30.0 mm"), "{far}");
}

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

/// A folder of its own for each test.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("setup").join(name);
    let _old = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).expect("a folder");
    folder
}

fn meniscus(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_meniscus-under-test"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("it starts")
}

fn json(output: &Output) -> Value {
    let text = String::from_utf8_lossy(&output.stdout);
    serde_json::from_str(&text)
        .unwrap_or_else(|e| panic!("{e}: {text}{}", String::from_utf8_lossy(&output.stderr)))
}

#[test]
fn a_script_sets_up_and_a_run_takes_the_file() {
    let folder = folder("script");
    let asked = ["setup", "--source", "simulated-usb", "--yes", "--pairs", "20", "--json"];
    let with = |rest: &[&str]| meniscus(&folder, &[&asked[..], rest].concat());
    let wrong = with(&["--radius-mm", "29", "--fill-mm", "70", "--rim-mm", "110"]);
    assert!(!wrong.status.success() && !folder.join("glass.toml").exists(), "nothing is written");
    assert!(json(&wrong)["remedies"]["radius_seen_mm"].is_string());

    // A machine that other programs load may fall below 60 Hz for some seconds: then once more.
    let attempt = || with(&["--radius-mm", "35", "--fill-mm", "70", "--rim-mm", "110"]);
    let mut right = attempt();
    for _ in 0..2 {
        if right.status.success() {
            break;
        }
        right = attempt();
    }
    let report = json(&right);
    let checks = report["checks"].as_array().expect("checks");
    // The rate is the machine's; everything else is of the glass.
    let late = |check: &&Value| check["ok"] == false && check["name"] != "frame_rate_hz";
    assert_eq!(checks.iter().filter(late).count(), 0, "{report:#}");
    if !right.status.success() {
        return optional::skip(&format!("this machine does not reach the camera's 60 Hz: {report:#}"));
    }
    assert_eq!(report["model"]["fits"], true);
    let run = meniscus(&folder, &["run", "--patient", "--seconds", "3", "--setup", "glass.toml", "--json"]);
    let run = json(&run);
    let rel = run["checks"]
        .as_array()
        .and_then(|all| all.iter().find(|c| c["name"] == "surface_slosh_rel").cloned());
    assert!(rel.is_some_and(|check| check["ok"] == true), "{run:#}");

    let file = folder.join("glass.toml");
    let text = fs::read_to_string(&file).expect("the file");
    let spoilt = |name: &str, from: &str, to: &str| {
        let path = folder.join(name);
        assert!(text.contains(from), "{text}");
        fs::write(&path, text.replace(from, to)).expect("written");
        let run = meniscus(&folder, &["run", "--patient", "--setup", name]);
        assert!(!run.status.success(), "{name}");
        String::from_utf8_lossy(&run.stderr).into_owned()
    };
    let other = spoilt("other.toml", "radius_mm = 35.0", "radius_mm = 30.0");
    assert!(
        other.contains("other.toml") && other.contains("radius 35.0 mm, the setup says 30.0 mm"),
        "{other}"
    );
    assert!(spoilt("odd.toml", "fill_mm", "fil_mm").contains("odd.toml is no settings file"));
    assert!(spoilt("far.toml", "fill_mm = 70.0", "fill_mm = 700.0").contains("15 to 200 mm"));
}
