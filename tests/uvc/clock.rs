//! Time stamps and pairs of both streams: restarts of the camera's clock, its rollover, a lag between the streams.

use super::{INTERVAL_US, small};
use meniscus::usb::uvc::{Assembler, AssemblyOutcome, DeviceClock, Pairer};

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
