//! The right liquid is named from what a camera sees of it, and none where it is not among those asked.
#![cfg(feature = "offline")]

use meniscus::host::recognise::Note;
use meniscus::offline::recognise::{look, recognise};
use meniscus::offline::recording::Recording;
use meniscus::surface::SurfaceProfile;
use std::path::Path;

/// The liquids that come with the program.
fn shipped() -> Vec<Note> {
    Note::all_of(Path::new("models/liquids")).expect("the shipped notes")
}

/// What the camera sees of the shipped recording, which no note was learnt from.
fn glycerine() -> (Vec<Option<SurfaceProfile>>, f64) {
    let recording =
        Recording::load(Path::new("recordings/glycerine-unseen.safetensors")).expect("it is shipped");
    let motion = &recording.provenance.motion;
    assert!(shipped().iter().all(|note| note.liquid != "glycerine" || !note.recordings.contains(motion)));
    (look(&recording, 0.24, 5).expect("the shipped glass"), recording.glass.fill_m)
}

#[test]
fn the_shipped_recording_is_glycerine_and_none_of_the_others() {
    let (seen, fill_m) = glycerine();
    let all = shipped();
    assert_eq!(all.len(), 5);
    let said = recognise(&all, fill_m, &seen, |_, _, _| {});
    assert_eq!(said.liquid.as_deref(), Some("glycerine"), "{}", said.line());
    let others: Vec<Note> = all.iter().filter(|note| note.liquid != "glycerine").cloned().collect();
    let said = recognise(&others, fill_m, &seen, |_, _, _| {});
    assert_eq!(said.liquid, None, "{}", said.line());
    // Four seconds do, and a tenth of the frames may be lost.
    let lossy: Vec<_> = seen.iter().take(240).enumerate().map(|(n, p)| p.filter(|_| n % 10 != 7)).collect();
    let said = recognise(&all, fill_m, &lossy, |_, _, _| {});
    assert_eq!(said.liquid.as_deref(), Some("glycerine"), "{}", said.line());
}

#[test]
fn what_is_believed_begins_even_and_grows() {
    let (seen, fill_m) = glycerine();
    let mut believed = Vec::new();
    recognise(&shipped(), fill_m, &seen, |frame, trail, recogniser| {
        if [10, 240, 500].contains(&frame) {
            let mut p = [0.0; 5];
            let verdict = recogniser.verdict(trail, &mut p);
            assert!((p.iter().sum::<f64>() + verdict.none - 1.0).abs() < 1e-9);
            believed.push(p.into_iter().fold(0.0, f64::max));
        }
    });
    assert!(believed[0] < 0.2 && believed[1] > 0.7 && believed[2] > believed[1] - 0.05, "{believed:?}");
}
