//! No profile where there is no contact line: empty glasses, none, a part of a line, a stripe.

use crate::scenes::{HEIGHT, WIDTH, scenes};
use meniscus::surface::{Config, ExtractionError, ExtractionState, Intrinsics, Settings, extract_outline};
use meniscus::usb::frame::{OutlineFrame, Stamp};
use meniscus_virtual::camera_study::traced::degrade::Faults;
use meniscus_virtual::camera_study::traced::judge::{FRAMES, read_scene};
use meniscus_virtual::camera_study::traced::set::{Kind, TracedScene};

/// The faults under which nothing must be seen where nothing is.
fn many_faults() -> Vec<Faults> {
    let mut all = Vec::new();
    for gain in [0.5, 1.0, 1.6] {
        let faults = Faults { gain, ..Faults::default() };
        all.extend([
            faults,
            Faults { dots: 60.0, ..faults },
            Faults { dots: 150.0, ..faults },
            Faults { defocus_px: 1.0, ..faults },
            Faults { smear_px: 7, ..faults },
            Faults { grey_rms: 5.0, ..faults },
            Faults { border_px: 4, hole_share: 0.4, ..faults },
        ]);
    }
    all
}

/// The scene without its glass: every row runs straight from its left to its right.
fn without_glass(scene: &TracedScene) -> TracedScene {
    let (left, right) = (180, 460);
    let mut grey = scene.grey.clone();
    for row in grey.chunks_exact_mut(WIDTH) {
        let (from, to) = (row[left], row[right]);
        for (column, pixel) in row.iter_mut().enumerate().take(right).skip(left) {
            *pixel = from + (to - from) * (column - left) as f32 / (right - left) as f32;
        }
    }
    TracedScene { grey, ..scene.clone() }
}

#[test]
fn an_empty_glass_and_none_give_no_profile() {
    let empty = scenes("", Kind::Empty);
    assert_eq!(empty.len(), 8);
    let bare: Vec<_> = empty.iter().map(without_glass).collect();
    let (mut images, mut seen) = (0, Vec::new());
    for (scene, faults) in
        empty.iter().chain(&bare).flat_map(|s| many_faults().into_iter().map(move |f| (s, f)))
    {
        // Where the liquid would stand is not known of an empty glass.
        for fill_m in [0.5, 0.65] {
            let other = |s: Settings| Settings { fill_m: fill_m * s.rim_m, ..s };
            let read = read_scene(scene, &faults, &other).expect("sound settings");
            images += FRAMES;
            if read.profiles > 0 {
                seen.push((scene.truth.name.clone(), faults));
            }
        }
    }
    println!("{images} images of empty glasses and of none, {} with a profile", seen.len());
    assert!(images >= 200 && seen.is_empty(), "{seen:?}");
}

/// A drawn image of tones: a card, a dark table, and within the silhouette of the usual glass `inside(column, row)`.
fn drawn(inside: impl Fn(usize, usize) -> u8) -> Vec<u8> {
    let pixel = |at: usize| {
        let (column, row) = (at % WIDTH, at / WIDTH);
        match (286..=353).contains(&column) {
            _ if row >= 268 => 40,
            true => inside(column, row),
            false => CARD,
        }
    };
    (0..WIDTH * HEIGHT).map(pixel).collect()
}

/// Tones of the drawn images.
const CARD: u8 = 200;
const WATER: u8 = 150;

/// The whole curve is scored: water below a part of it, or a stripe above shallow water, is no contact line.
#[test]
fn a_part_of_a_line_and_a_stripe_are_none() {
    let lens = Intrinsics { width: WIDTH, height: HEIGHT, fx: 384.0, fy: 384.0, ppx: 319.5, ppy: 239.5 };
    let settings = Settings { intrinsics: lens, ..Settings::default().of_clear_liquid() };
    let config = Config::new(settings).expect("sound settings");
    let read = |bytes: Vec<u8>| {
        let frame = OutlineFrame { bytes: &bytes, width: WIDTH, height: HEIGHT, stamp: Stamp::default() };
        extract_outline(&config, &mut ExtractionState::new(), frame)
    };
    let step = |dark: bool| if dark { WATER } else { CARD };
    let water = read(drawn(|_, row| step(row >= 198))).expect("a line");
    // Row 197.5 at 365 mm, 30 mm high.
    let height_m = 0.030 + 0.365 * (239.5 - 197.5) / 384.0;
    assert!((water.height_m[10] - height_m).abs() < 0.8e-3, "{}", water.height_m[10]);
    let part = read(drawn(|column, row| step(row >= 198 || column > 325)));
    assert_eq!(part, Err(ExtractionError::TooFewColumns), "something dark behind the right half");
    let stripe = read(drawn(|_, row| step((198..202).contains(&row) || row >= 246)));
    assert_eq!(stripe, Err(ExtractionError::TooFewColumns), "a stripe");
}
