//! Payloads of the simulated camera, healthy and damaged, through header, assembler and pairing.

#[path = "uvc/clock.rs"]
mod clock;
#[path = "uvc/headers.rs"]
mod headers;
#[path = "uvc/joining.rs"]
mod joining;

use meniscus::usb::uvc::{Assembler, AssemblyOutcome, DeviceClock, Losses, Pairer, Solitary};
use meniscus_hil::{
    Camera, CameraSettings, FaultInjector, FaultKind, FaultList, Payload, Shot, Source, Stream,
};

const WIDTH: usize = 16;
const HEIGHT: usize = 8;
const INTERVAL_US: u64 = 16_667;

fn camera() -> Camera {
    let (width, height) = (WIDTH as u16, HEIGHT as u16);
    Camera::new(CameraSettings { width, height, ..CameraSettings::default() })
}

/// Pixels that tell which shot they belong to.
fn pixels(shot: u64, bytes: usize) -> Vec<u8> {
    (0..WIDTH * HEIGHT * bytes).map(|i| (shot as usize * 31 + i * 7) as u8).collect()
}

fn expose(source: &mut impl Source, shot: u64) -> Vec<Payload> {
    let (depth, infrared) = (pixels(shot, 2), pixels(shot, 1));
    source.expose(&Shot::infrared(&depth, &infrared, 1_000_000 + shot * INTERVAL_US))
}

/// Counts of a run.
#[derive(Debug, Default, PartialEq)]
struct Books {
    depth: u32,
    infrared: u32,
    pairs: u32,
    lost: Losses,
    solitary: Solitary,
}

/// Runs shots through faults; asserts that every frame that comes out is whole and its own.
fn run(faults: &str, shots: u64, seed: u64, whole: bool) -> Books {
    let faults: FaultList = faults.parse().expect("the list is well formed");
    let mut source = FaultInjector::new(camera(), faults, seed);
    let (mut depth_buffer, mut infrared_buffer) = ([0; WIDTH * HEIGHT * 2], [0; WIDTH * HEIGHT]);
    let mut depth = Assembler::new(&mut depth_buffer);
    let mut infrared = Assembler::new(&mut infrared_buffer);
    let (mut pairer, mut clock) = (Pairer::new(INTERVAL_US as u32, 1), DeviceClock::default());
    let mut books = Books::default();
    for shot in 0..shots {
        for payload in expose(&mut source, shot) {
            let (assembler, count, bytes, stream) = match payload.stream {
                Stream::Depth => (&mut depth, &mut books.depth, 2, meniscus::usb::uvc::Stream::Depth),
                Stream::Infrared | Stream::Colour => {
                    (&mut infrared, &mut books.infrared, 1, meniscus::usb::uvc::Stream::Outline)
                }
            };
            let outcome = if whole {
                assembler.whole(&payload.bytes, &mut clock)
            } else {
                assembler.push(&payload.bytes, &mut clock)
            };
            if let AssemblyOutcome::Frame(frame) = outcome {
                let shot = (frame.stamp.captured.0 - 1_000_000) / INTERVAL_US;
                assert_eq!(frame.stamp.captured.0, 1_000_000 + shot * INTERVAL_US, "mid-exposure");
                assert_eq!(frame.pixels, pixels(shot, bytes), "torn or foreign pixels in shot {shot}");
                *count += 1;
                books.pairs += u32::from(pairer.offer(stream, frame.stamp).is_some());
            }
        }
    }
    books.lost = depth.losses();
    books.solitary = pairer.solitary();
    books
}

#[test]
fn every_fault_ends_in_its_own_counter() {
    let none = Losses::default();
    let table = [
        ("", 10, none),
        ("drop@5", 9, Losses { counter_gap: 1, ..none }),
        ("tear@5", 9, Losses { short_frame: 1, ..none }),
        ("late@5", 9, Losses { pts_backwards: 1, ..none }),
        ("err@5", 9, Losses { error_bit: 1, ..none }),
        ("length0@5", 9, Losses { bad_header: 1, ..none }),
        ("length2@5", 9, Losses { bad_header: 1, ..none }),
        ("length200@5", 9, Losses { bad_header: 1, ..none }),
        ("empty@5", 9, Losses { empty_payload: 1, ..none }),
        ("overlong@5", 9, Losses { overlong_frame: 1, ..none }),
        ("duplicate@5", 10, Losses { duplicate: 1, ..none }),
        // Whole frames with a remark: the flipped identifier equals that of both neighbours.
        ("fid@5", 10, Losses { fid_repeated: 2, ..none }),
        ("eof@5", 10, Losses { eof_missing: 1, ..none }),
    ];
    for whole in [false, true] {
        for (faults, frames, lost) in table {
            let books = run(faults, 10, 1, whole);
            assert_eq!((books.depth, books.lost), (frames, lost), "{faults}, whole {whole}");
            assert_eq!(books.pairs, frames, "{faults}: both streams were struck, all others pair");
        }
    }
}

#[test]
fn a_counter_gap_counts_the_frames_that_the_camera_skipped() {
    let books = run("gap@5", 10, 1, false);
    assert_eq!(books.depth, 10);
    assert!((1..=5).contains(&books.lost.counter_gap), "{books:?}");
}

#[test]
fn split_frames_are_joined_by_push_and_refused_by_whole() {
    let joined = run("split:1", 10, 1, false);
    assert_eq!((joined.depth, joined.lost), (10, Losses::default()));
    let refused = run("split@5", 10, 1, true);
    // The first part is a short frame, the others repeat its time.
    assert_eq!(refused.lost, Losses { short_frame: 1, duplicate: 3, ..Losses::default() });
}

#[test]
fn a_missing_infrared_frame_leaves_its_depth_frame_alone() {
    let books = run("noinfrared@5", 10, 1, false);
    assert_eq!((books.depth, books.infrared, books.pairs), (10, 9, 9));
    assert_eq!(books.solitary, Solitary { depth: 1, infrared: 0 });
}

#[test]
fn under_many_faults_nothing_torn_comes_out_and_every_frame_is_booked_once() {
    let faults =
        "drop:0.03,tear:0.03,err:0.03,length0:0.02,length200:0.02,duplicate:0.03,fid:0.02,eof:0.02,late:0.02";
    let mut lost = 0;
    for seed in 0..20 {
        let shots = 400;
        let books = run(faults, shots, seed, false);
        lost += books.lost.frames();
        // What is under way at the end is in no book, and two faults that meet may be booked twice.
        let difference = (u64::from(books.depth + books.lost.frames())).abs_diff(shots);
        assert!(difference <= 6, "seed {seed}: {books:?}");
    }
    assert!(lost > 800, "the faults struck: {lost}");
}

#[test]
fn all_faults_at_once_give_no_torn_frame() {
    let kinds: Vec<_> = FaultKind::all().map(|kind| format!("{}:0.1", kind.name())).collect();
    for seed in 0..20 {
        for order in [kinds.join(","), kinds.iter().rev().cloned().collect::<Vec<_>>().join(",")] {
            let books = run(&order, 300, seed, seed % 2 == 0);
            assert!(books.depth > 30 && books.lost.frames() > 30, "{books:?}");
        }
    }
}

/// A whole payload with a PTS and nothing else.
fn small(fid: bool, end: bool, pts: u32, pixels: &[u8]) -> Vec<u8> {
    let flags = u8::from(fid) | (u8::from(end) << 1) | 0b100;
    [&[6, flags], &pts.to_le_bytes()[..], pixels].concat()
}
