//! Payloads of the simulated camera, healthy and damaged, through header, assembler and pairing.

#[path = "uvc/joining.rs"]
mod joining;

use meniscus::usb::uvc::{
    Assembler, AssemblyOutcome, Cause, DeviceClock, HeaderError, Losses, Pairer, PayloadHeader, Solitary,
    Timing,
};
use meniscus_hil::{
    Camera, CameraSettings, FaultInjector, FaultKind, FaultList, Image, Payload, Shot, Source, Stream, pack,
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

#[test]
fn a_frame_without_its_middle_or_its_end_is_lost() {
    let mut buffer = [0; 4];
    let (mut assembler, mut clock) = (Assembler::new(&mut buffer), DeviceClock::default());
    assert_eq!(assembler.push(&small(false, false, 10, &[1, 2]), &mut clock), AssemblyOutcome::Partial);
    assert_eq!(
        assembler.push(&small(false, true, 10, &[4]), &mut clock),
        AssemblyOutcome::Lost(Cause::ShortFrame)
    );
    assert_eq!(assembler.push(&small(true, false, 20, &[1, 2]), &mut clock), AssemblyOutcome::Partial);
    let next = assembler.push(&small(false, true, 30, &[5, 6, 7, 8]), &mut clock);
    assert!(matches!(next, AssemblyOutcome::Frame(frame) if frame.pixels == [5, 6, 7, 8]), "{next:?}");
    let lost = assembler.losses();
    assert_eq!((lost.short_frame, lost.frame_unended, lost.frames()), (1, 1, 2));
}

/// The frame after the next one has the same identifier: only its time tells it from the rest of this one.
#[test]
fn the_rest_of_a_frame_is_not_taken_from_the_frame_after_the_next() {
    let mut buffer = [0; 4];
    let (mut assembler, mut clock) = (Assembler::new(&mut buffer), DeviceClock::default());
    assert_eq!(assembler.push(&small(false, false, 10, &[1, 2]), &mut clock), AssemblyOutcome::Partial);
    // The rest of it, the next frame, and the first half of the one behind are lost.
    let torn = assembler.push(&small(false, true, 30, &[7, 8]), &mut clock);
    assert_eq!(torn, AssemblyOutcome::Lost(Cause::ShortFrame));
    // A payload of another frame at the same time is no rest either.
    assert_eq!(assembler.push(&small(true, false, 40, &[1, 2]), &mut clock), AssemblyOutcome::Partial);
    let torn = assembler.push(&small(false, true, 40, &[3, 4]), &mut clock);
    assert!(!matches!(torn, AssemblyOutcome::Frame(_)), "{torn:?}");
}

#[test]
fn the_rest_of_a_refused_frame_is_swallowed() {
    let mut buffer = [0; 4];
    let (mut assembler, mut clock) = (Assembler::new(&mut buffer), DeviceClock::default());
    assert_eq!(
        assembler.push(&small(false, false, 10, &[0; 5]), &mut clock),
        AssemblyOutcome::Lost(Cause::OverlongFrame)
    );
    assert_eq!(assembler.push(&small(false, false, 10, &[0; 2]), &mut clock), AssemblyOutcome::Partial);
    assert_eq!(assembler.push(&small(false, true, 10, &[0; 2]), &mut clock), AssemblyOutcome::Partial);
    assert!(matches!(assembler.push(&small(true, true, 20, &[0; 4]), &mut clock), AssemblyOutcome::Frame(_)));
    assert_eq!(assembler.losses().frames(), 1);
}

#[test]
fn time_goes_on_over_the_wrap_of_the_clock_and_after_its_reset() {
    let mut buffer = [0; 1];
    let (mut assembler, mut clock) = (Assembler::new(&mut buffer), DeviceClock::default());
    let mut time = |pts, fid| match assembler.push(&small(fid, true, pts, &[0]), &mut clock) {
        AssemblyOutcome::Frame(frame) => Some(frame.stamp.captured.0),
        _ => None,
    };
    let start = u64::from(u32::MAX) - 9_999;
    assert_eq!(time(u32::MAX - 9_999, false), Some(start));
    assert_eq!(time(6_667, true), Some(start + 16_667), "wrapped");
    // The camera restarts: two frames are refused, then time goes on.
    let restart = u32::MAX - 50_000_000;
    assert_eq!([time(restart, false), time(restart + 16_667, true)], [None, None]);
    let again = start + 16_667 + 33_333;
    assert_eq!(time(restart + 2 * 16_667, false), Some(again + 16_667));
    // Late frames, however many, do not move the clock.
    assert_eq!([time(restart, true), time(restart + 1, false), time(restart + 2, true)], [None; 3]);
    assert_eq!(time(restart + 3 * 16_667, false), Some(again + 2 * 16_667));
}

/// Pairs that a receiver of both streams made of a sequence of frames.
#[derive(Default)]
struct Received {
    /// Number of each pair's shot, by the pixels of its depth image.
    shots: Vec<u8>,
    wrong: u32,
}

/// A frame as the camera sends it: its stream, the shot that it shows and its time stamp.
#[derive(Clone, Copy)]
struct Sent {
    stream: meniscus::usb::uvc::Stream,
    shot: u8,
    pts: u32,
}

/// Receives `sent` in its order, with room for two images of each stream.
fn receive(sent: impl Iterator<Item = Sent>) -> Received {
    let (mut depth_room, mut outline_room) = ([0; 2], [0; 2]);
    let mut depth = Assembler::keeping_two(&mut depth_room);
    let mut outline = Assembler::keeping_two(&mut outline_room);
    let (mut clock, mut pairer) = (DeviceClock::default(), Pairer::new(INTERVAL_US as u32, 2));
    let (mut received, mut last) = (Received::default(), None);
    for Sent { stream, shot, pts } in sent {
        let assembler = match stream {
            meniscus::usb::uvc::Stream::Depth => &mut depth,
            meniscus::usb::uvc::Stream::Outline => &mut outline,
        };
        let payload = small(shot % 2 == 1, true, pts, &[shot]);
        let AssemblyOutcome::Frame(frame) = assembler.push(&payload, &mut clock) else { continue };
        let Some(pair) = pairer.offer(stream, frame.stamp) else { continue };
        let images = [depth.pixels_of(pair.depth), outline.pixels_of(pair.outline)];
        let [Some([of_depth]), Some([of_outline])] = images else { panic!("{images:?} of shot {shot}") };
        received.wrong += u32::from(of_depth != of_outline);
        assert!(last < Some(pair.depth.captured), "time goes on");
        last = Some(pair.depth.captured);
        received.shots.push(*of_depth);
    }
    received
}

/// Shots `from..to` of a camera whose clock shows `pts` at the first, without the frames for which `lost` says so.
fn shots(
    from: u8,
    to: u8,
    pts: u32,
    lost: impl Fn(meniscus::usb::uvc::Stream, u8) -> bool,
) -> impl Iterator<Item = Sent> {
    use meniscus::usb::uvc::Stream::{Depth, Outline};
    let all = (from..to).flat_map(move |shot| {
        let at = pts.wrapping_add(u32::from(shot - from) * INTERVAL_US as u32);
        [Sent { stream: Depth, shot, pts: at }, Sent { stream: Outline, shot, pts: at.wrapping_add(40) }]
    });
    all.filter(move |sent| !lost(sent.stream, sent.shot))
}

/// The clock starts anew, and either stream loses frames before or after that: no image is paired with one of another instant, and
/// pairs come again after two frames. Clocks that are up for a minute, or for longer than half of their circle.
#[test]
fn a_restart_with_frames_lost_on_one_stream_neither_blinds_nor_mixes() {
    for before_pts in [60_000_000, 2_400_000_000, u32::MAX - 300_000] {
        // Each bit loses one frame: depth and outline of the last two shots before and of the first two after.
        for mask in 0_u32..1 << 8 {
            let bit = |stream, shot: u8| {
                u32::from(shot) * 2 + u32::from(stream == meniscus::usb::uvc::Stream::Outline)
            };
            let before = shots(0, 20, before_pts, move |stream, shot| {
                shot >= 18 && mask >> bit(stream, shot - 18) & 1 == 1
            });
            let after = shots(20, 60, 500_000, move |stream, shot| {
                shot < 22 && mask >> (4 + bit(stream, shot - 20)) & 1 == 1
            });
            let received = receive(before.chain(after));
            assert_eq!(received.wrong, 0, "{mask:08b} at {before_pts}");
            let late = received.shots.iter().filter(|shot| **shot >= 23).count();
            assert_eq!(late, 37, "{mask:08b} at {before_pts}: {:?}", received.shots);
        }
    }
}

/// A constant lag of a frame between the streams (librealsense issue 1773), either way.
#[test]
fn a_stream_that_lags_by_a_frame_pairs_every_time() {
    for lagging in [meniscus::usb::uvc::Stream::Depth, meniscus::usb::uvc::Stream::Outline] {
        let mut sent: Vec<_> = shots(0, 100, 1_000_000, |_, _| false).collect();
        // The lagging stream's frame n comes behind the other's frame n + 1.
        sent.sort_by_key(|sent| 2 * u32::from(sent.shot) + if sent.stream == lagging { 3 } else { 0 });
        let received = receive(sent.into_iter());
        assert_eq!((received.shots.len(), received.wrong), (100, 0), "{lagging:?} lags");
    }
}

#[test]
fn streams_that_start_on_either_side_of_the_rollover_pair() {
    // The first depth frame is stamped 20 us before the rollover, its partner 20 us behind it.
    let received = receive(shots(0, 50, u32::MAX - 19, |_, _| false));
    assert_eq!((received.shots.len(), received.wrong), (50, 0));
    let outline_first =
        shots(0, 50, u32::MAX - 19, |stream, shot| shot == 0 && stream == meniscus::usb::uvc::Stream::Depth);
    assert_eq!(receive(outline_first).shots.len(), 49);
}

#[test]
fn a_payload_without_a_time_is_no_frame() {
    let mut buffer = [0; 1];
    let (mut assembler, mut clock) = (Assembler::new(&mut buffer), DeviceClock::default());
    assert_eq!(assembler.push(&[2, 0b10, 7], &mut clock), AssemblyOutcome::Lost(Cause::PtsMissing));
    assert_eq!(assembler.losses().pts_missing, 1);
}

#[test]
fn the_header_reads_what_the_camera_wrote() {
    let stamp = meniscus_hil::Stamp {
        fid: true,
        pts_us: 0x1234_5678,
        bus_frame: 0x0fff,
        counter: 77,
        exposure_us: 4_000,
        interval_us: 16_667,
    };
    let bytes = pack(&stamp, &Image { pixels: &[1, 2, 3], width: 3, height: 1, format: 1 });
    let (header, pixels) = PayloadHeader::split(&bytes).expect("a healthy header");
    assert_eq!(pixels, [1, 2, 3]);
    assert_eq!((header.frame_id(), header.end_of_frame(), header.end_of_header()), (true, true, true));
    assert_eq!((header.error(), header.still_image()), (false, false));
    assert_eq!((header.pts(), header.source_clock()), (Some(0x1234_5678), Some((0x1234_5678, 0x07ff))));
    let blocks: Vec<_> = header.blocks().map(|block| (block.id, block.body.len() + 8)).collect();
    assert_eq!(blocks, [(0x8000_0001, 40), (3, 80), (0x8000_0000, 60), (0x8000_0002, 40)]);
    let timing = Timing::of(&header);
    assert_eq!((timing.counter, timing.sensor_us), (Some(77), Some(2_000)));
    assert_eq!((timing.exposure_us, timing.interval_us), (Some(4_000), Some(16_667)));
}

#[test]
fn a_field_without_its_flag_has_no_value_and_a_block_of_size_zero_ends_the_walk() {
    let stamp = meniscus_hil::Stamp {
        fid: false,
        pts_us: 1,
        bus_frame: 0,
        counter: 7,
        exposure_us: 2,
        interval_us: 3,
    };
    let mut bytes = pack(&stamp, &Image { pixels: &[0], width: 1, height: 1, format: 0 });
    bytes[12 + 12] = 0b10;
    let timing = Timing::of(&PayloadHeader::split(&bytes).expect("still sound").0);
    assert_eq!((timing.counter, timing.sensor_us, timing.exposure_us), (None, Some(1), None));
    bytes[12 + 4] = 0;
    assert_eq!(PayloadHeader::split(&bytes).expect("still sound").0.blocks().count(), 0);
}

#[test]
fn impossible_header_lengths_are_named() {
    let table: [(&[u8], HeaderError); 5] = [
        (&[], HeaderError::Empty),
        (&[0, 0x8c, 1, 2], HeaderError::TooShort { length: 0, needed: 12 }),
        (&[2, 0x8c, 1, 2], HeaderError::TooShort { length: 2, needed: 12 }),
        (&[200, 0, 1, 2], HeaderError::BeyondPayload { length: 200, payload: 4 }),
        (&[2], HeaderError::BeyondPayload { length: 2, payload: 1 }),
    ];
    for (bytes, error) in table {
        assert_eq!(PayloadHeader::split(bytes).err(), Some(error));
    }
}

#[test]
fn random_bytes_never_panic_and_never_give_a_wrong_size() {
    let mut random = 0x2545_f491_4f6c_dd1d_u64;
    let mut draw = move || {
        random ^= random << 13;
        random ^= random >> 7;
        random ^= random << 17;
        random
    };
    let mut buffer = [0; 48];
    let (mut assembler, mut clock) = (Assembler::new(&mut buffer), DeviceClock::default());
    let mut frames = 0;
    for _ in 0..200_000 {
        let length = (draw() % 80) as usize;
        let mut payload: Vec<u8> = (0..length).map(|_| draw() as u8).collect();
        // Half of them get a header that may well be sound.
        if let (Some(first), true) = (payload.first_mut(), draw() % 2 == 0) {
            *first = (draw() % 40) as u8;
        }
        let outcome = if draw() % 4 == 0 {
            assembler.whole(&payload, &mut clock)
        } else {
            assembler.push(&payload, &mut clock)
        };
        if let AssemblyOutcome::Frame(frame) = outcome {
            assert_eq!(frame.pixels.len(), 48);
            frames += 1;
        }
        if let Ok((header, _)) = PayloadHeader::split(&payload) {
            assert!(header.blocks().count() <= 10);
        }
    }
    assert!(frames > 10, "some of it was sound: {frames}");
}
