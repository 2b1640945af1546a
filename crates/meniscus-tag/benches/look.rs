//! An image of the camera's size, with the tag and without it, beside a search of the whole image by the detector alone.
//!
//! `cargo bench -p meniscus-tag --bench look`. The figure to look at is a look over the search of the same run. While the tag is seen,
//! its surroundings and a part of the image are searched, and else a part alone.

use criterion::{Criterion, criterion_group, criterion_main};
use meniscus::surface::Intrinsics;
use meniscus::units::Micros;
use meniscus_tag::{Sighting, TagFinder, TagTracker, Wanted};
use std::hint::black_box;
use std::path::Path;

/// Width and height of the image, px.
const SIZE: (usize, usize) = (640, 480);

/// Place of the rendered image in it, px.
const LEFT: usize = 200;
const TOP: usize = 100;

/// Lens of the rendered image (`tests/fixtures/tag/truth.json`), moved to its place.
const LENS: Intrinsics = Intrinsics {
    width: SIZE.0,
    height: SIZE.1,
    fx: 384.21,
    fy: 384.21,
    ppx: 96.3 + LEFT as f32,
    ppy: 79.4 + TOP as f32,
};

/// The tag of the rendered image.
const WANTED: Wanted = Wanted { number: 7, size_m: 0.04, lens: LENS, pitch_rad: 0.0 };

/// Returns a striped image, a busy background, and the same with the tag in it.
fn images() -> [Vec<u8>; 2] {
    let (width, height) = SIZE;
    let stripe = |at: usize| if (at % width / 13 + at / width / 11).is_multiple_of(2) { 60 } else { 150 };
    let without: Vec<u8> = (0..width * height).map(stripe).collect();
    let mut with = without.clone();
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/fixtures/tag/turned.png");
    let tag = image::open(file).expect("an image").into_luma8();
    for (row, line) in tag.as_raw().chunks_exact(tag.width() as usize).enumerate() {
        let start = (row + TOP) * width + LEFT;
        with[start..start + line.len()].copy_from_slice(line);
    }
    [without, with]
}

fn look(criterion: &mut Criterion) {
    let [without, with] = images();
    let mut group = criterion.benchmark_group("look");
    group.bench_function("the detector alone, whole image", |bencher| {
        let mut finder = TagFinder::new(SIZE).expect("a finder");
        bencher.iter(|| finder.anywhere(black_box(&with)).expect("searched").len());
    });
    let mut at = 1_000_000;
    let mut next = || {
        at += 16_667;
        Micros(at)
    };
    group.bench_function("with the tag", |bencher| {
        let mut tracker = TagTracker::new(WANTED).expect("a tracker");
        let is_seen = |sighting: &Sighting| matches!(sighting, Sighting::Seen { .. });
        // A round of the search comes first, and is not timed.
        let found = (0..67).any(|_| is_seen(&tracker.look(next(), &with).expect("searched")));
        assert!(found, "the tag is found within a round");
        bencher.iter(|| {
            let sighting = tracker.look(next(), black_box(&with)).expect("searched");
            assert!(is_seen(&sighting), "{sighting:?}");
        });
    });
    group.bench_function("without it", |bencher| {
        let mut tracker = TagTracker::new(WANTED).expect("a tracker");
        bencher.iter(|| {
            let sighting = tracker.look(next(), black_box(&without)).expect("searched");
            assert_eq!(sighting, Sighting::Missing);
        });
    });
    group.finish();
}

criterion_group!(benches, look);
criterion_main!(benches);
