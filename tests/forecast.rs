//! The next crest on the shipped model and its unseen recording: where it is said to stand, how far it may be off, and
//! whether it may pass the rim.

use meniscus::blob::Model;
use meniscus::runtime::{Crest, Forecast, InputSource, Mode};
use meniscus_data::recording::Recording;
use meniscus_platform::files::AlignedBytes;
use meniscus_score::score::Held;
use meniscus_virtual::observe_recording::{perfect, turns_with};
use std::path::Path;

/// Half a second, frames.
const WITHIN: usize = 30;

/// A crest counts from this height over the fill, m.
const COUNTS_M: f64 = 0.003;

/// Highest point of a surface, m, and which it is.
fn highest(surface_m: &[f32]) -> (usize, f32) {
    let points = surface_m.iter().copied().enumerate();
    points.max_by(|a, b| a.1.total_cmp(&b.1)).expect("a surface has points")
}

#[test]
fn a_crest_says_how_far_it_may_be_off() {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../recordings/glycerine-unseen.safetensors"));
    let recording = Recording::load(path).expect("the shipped recording is good");
    let bytes = AlignedBytes::copy(meniscus_shipped::MODEL);
    let model = Model::load(&bytes).expect("the shipped model");
    // What the step of a frame is pushed by: the acceleration that the places of the glass tell up to it.
    let x = &recording.glass_x_m;
    let motion: Vec<f64> =
        (0..x.len()).map(|n| if n < 2 { 0.0 } else { (x[n] - 2.0 * x[n - 1] + x[n - 2]) * 3600.0 }).collect();
    let tops: Vec<f32> = (0..recording.frames()).map(|n| highest(recording.profile(n)).1).collect();
    let counts = |n: usize| {
        tops[n] > tops[n - 1]
            && tops[n] >= tops[n + 1]
            && f64::from(tops[n]) - recording.glass.fill_m > COUNTS_M
    };
    let (mut held, mut any, mut warned, mut looks) = (0, 0, 0, 0);
    let (mut planned_held, mut planned_came) = (0, 0);
    let (mut near, mut far) = (Held::default(), Held::default());
    turns_with(
        &model,
        &perfect(&recording),
        |_| InputSource::Tracked,
        |frame, memory, estimate| {
            if estimate.mode != Mode::Tracking || frame + WITHIN >= recording.frames() || frame % 3 > 0 {
                return;
            }
            let plan = &motion[frame + 1..=frame + WITHIN];
            let came = (frame + 1..frame + WITHIN).find(|n| counts(*n));
            if let Some(planned) = Crest::next(&model, memory, WITHIN, plan) {
                let then = Forecast::new(&model, memory, planned.frames, plan);
                assert_eq!(planned.height_m, highest(&then.surface_m).1, "frame {frame}");
                let counts = f64::from(planned.height_m) - recording.glass.fill_m > COUNTS_M;
                if let Some(n) = came.filter(|_| counts) {
                    planned_came += 1;
                    planned_held += usize::from((tops[n] - planned.height_m).abs() <= planned.half_width_m);
                }
            }
            for (lead, held) in [(15, &mut near), (WITHIN, &mut far)] {
                let said = Forecast::new(&model, memory, lead, plan);
                held.add(recording.profile(frame + lead), &said.surface_m, &said.half_width_m);
            }
            let Some(crest) = Crest::next(&model, memory, WITHIN, &[]) else { return };
            let (point, height_m) = highest(&Forecast::new(&model, memory, crest.frames, &[]).surface_m);
            assert_eq!(crest.height_m, height_m, "frame {frame}");
            let last = Forecast::new(&model, memory, WITHIN, &[]);
            assert_eq!(
                crest.half_width_m, last.half_width_m[point],
                "a push may bring another one up to the last frame"
            );
            assert_eq!(crest.spills, f64::from(crest.height_m + crest.half_width_m) >= model.header.rim_m);
            looks += 1;
            warned += usize::from(crest.spills);
            if let Some(n) = came {
                any += 1;
                held += usize::from((tops[n] - crest.height_m).abs() <= crest.half_width_m);
            }
        },
    );
    println!("{held} of {any} crests held; {warned} warnings of {looks}");
    // Nine of ten are promised; with the width of the predicted frame it was one of three.
    assert!(any > 50 && 10 * held >= 8 * any, "{held} of {any}");
    // With the factor of the present surface it was 60 % of the crests, and 82 % of the heights 0.25 s ahead.
    let [near, far] = [near, far].map(|held| held.share());
    println!("planned: {planned_held} of {planned_came} crests held; heights {near:.3} and {far:.3}");
    // Of the crests it is 82 % here: 137 looks at some fifty crests, whose errors go together.
    assert!(planned_came > 50 && 10 * planned_held >= 8 * planned_came, "{planned_held} of {planned_came}");
    assert!([near, far].iter().all(|share| (0.83..0.97).contains(share)), "{near} {far}");
    assert!(
        10 * warned < looks,
        "the rim is 40 mm above the fill, the highest crest 20: {warned} of {looks}"
    );
}

/// A planned acceleration from rest makes a slosh, and larger errors with it.
#[test]
fn a_planned_push_widens_the_interval() {
    let bytes = AlignedBytes::copy(meniscus_shipped::MODEL);
    let model = Model::load(&bytes).expect("the shipped model");
    let memory = meniscus::runtime::Memory::default();
    let width = |a: f64| {
        let said = Forecast::new(&model, &memory, WITHIN, &[a; WITHIN]);
        said.half_width_m.iter().sum::<f32>() / said.half_width_m.len() as f32
    };
    let [still, gentle, strong] = [0.0, 1.0, 3.0].map(width);
    assert!(still < gentle && gentle < strong, "{still} {gentle} {strong}");
    let again = Forecast::new(&model, &memory, WITHIN, &[0.0; WITHIN]);
    let mut last = None;
    Forecast::course(&model, &memory, WITHIN, &[0.0; WITHIN], |_, said| last = Some(*said));
    assert_eq!(last, Some(again), "one course, two ways to ask for it");
}
