//! Time of the work on an image of the camera's size.

use crate::fixture::{Fixture, NUMBER};
use meniscus::surface::Intrinsics;
use meniscus::units::Micros;
use meniscus_tag::{Sighting, TagTracker, Wanted};
use std::time::Instant;

/// Time between two frames, us.
const INTERVAL_US: u128 = 16_667;

/// Median of `times`, 99th percentile and the longest.
fn quantiles(mut times: Vec<u128>) -> [u128; 3] {
    times.sort_unstable();
    [times[times.len() / 2], times[times.len() * 99 / 100], times[times.len() - 1]]
}

#[test]
fn an_image_takes_a_small_part_of_the_interval() {
    let fixture = Fixture::load();
    let small = fixture.images.iter().find(|image| image.name == "turned").expect("an image");
    let lens = Intrinsics {
        width: 640,
        height: 480,
        ppx: fixture.lens.ppx + 200.0,
        ppy: fixture.lens.ppy + 100.0,
        ..fixture.lens
    };
    // The small image in a striped large one, a busy background.
    let mut with: Vec<u8> =
        (0..640 * 480).map(|at| if (at % 640 / 13 + at / 640 / 11) % 2 == 0 { 60 } else { 150 }).collect();
    let without = with.clone();
    for (row, line) in small.pixels.chunks_exact(fixture.lens.width).enumerate() {
        let start = (row + 100) * 640 + 200;
        with[start..start + line.len()].copy_from_slice(line);
    }
    let wanted = Wanted { number: NUMBER as u32, size_m: fixture.size_m, lens, pitch_rad: 0.0 };
    let mut tracker = TagTracker::new(wanted).expect("a tracker");
    let mut time = |n: u64, image: &[u8]| {
        let begun = Instant::now();
        let sighting = tracker.look(Micros(1_000_000 + n * 16_667), image).expect("searched");
        (begun.elapsed().as_micros(), sighting)
    };
    let seen: Vec<u128> = (0..300)
        .map(|n| {
            let (us, sighting) = time(n, &with);
            assert!(matches!(sighting, Sighting::Seen { .. }), "{n}: {sighting:?}");
            us
        })
        .collect();
    let lost: Vec<u128> = (300..600).map(|n| time(n, &without).0).collect();
    let ([median, p99, most], [lost_median, lost_p99, lost_most]) = (quantiles(seen), quantiles(lost));
    println!(
        "seen: {median} us, {p99} us (99 %), {most} us at the most; lost: {lost_median}, {lost_p99}, {lost_most}"
    );
    // Medians alone: the machine of a test has other work as well.
    assert!(median < INTERVAL_US / 4 && lost_median < INTERVAL_US / 2, "{median} {lost_median}");
}
