//! Frames of several payloads, and payloads without a pixel: hand-made sequences with their books counted by hand.

use super::{WIDTH, camera, expose, pixels, small};
use meniscus::usb::uvc::{Assembler, AssemblyOutcome, Cause, DeviceClock, Losses};
use meniscus_hil::Stream;

/// The depth payload of each shot, from a camera that counts its frames.
fn depth_payloads(shots: u64) -> Vec<Vec<u8>> {
    let mut camera = camera();
    let of = |payloads: Vec<meniscus_hil::Payload>| {
        payloads.into_iter().find(|payload| payload.stream == Stream::Depth).expect("a depth image").bytes
    };
    (0..shots).map(|shot| of(expose(&mut camera, shot))).collect()
}

/// Length of the header of `payload`.
fn header(payload: &[u8]) -> usize {
    usize::from(payload[0])
}

/// The header of `payload` without a pixel and without the end of the frame.
fn empty(payload: &[u8]) -> Vec<u8> {
    let mut bytes = payload[..header(payload)].to_vec();
    bytes[1] &= !0b10;
    bytes
}

/// `payload` in two: its first row without the end of the frame, and the rest.
fn halves(payload: &[u8]) -> [Vec<u8>; 2] {
    let at = header(payload) + 2 * WIDTH;
    [
        [&empty(payload)[..], &payload[header(payload)..at]].concat(),
        [&payload[..header(payload)], &payload[at..]].concat(),
    ]
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
fn an_assembler_keeps_one_image_or_two() {
    let mut buffer = [0; 8];
    let mut clock = DeviceClock::default();
    let mut one = Assembler::new(&mut buffer);
    assert_eq!(one.kept(), 1);
    assert!(matches!(one.push(&small(false, true, 10, &[1; 8]), &mut clock), AssemblyOutcome::Frame(_)));
    assert_eq!(one.pixels(), [1; 8]);
    let mut two = Assembler::keeping_two(&mut buffer);
    assert_eq!(two.kept(), 2);
    assert!(matches!(two.push(&small(true, true, 20, &[2; 4]), &mut clock), AssemblyOutcome::Frame(_)));
    assert_eq!(two.pixels(), [2; 4]);
}

/// Time stamps are optional in every payload but the first: one without belongs to the frame of its identifier.
#[test]
fn a_rest_without_a_time_is_joined_by_its_identifier() {
    let mut buffer = [0; 4];
    let (mut assembler, mut clock) = (Assembler::new(&mut buffer), DeviceClock::default());
    assert_eq!(assembler.push(&small(true, false, 10, &[1, 2]), &mut clock), AssemblyOutcome::Partial);
    let joined = assembler.push(&[2, 0b11, 3, 4], &mut clock);
    assert!(matches!(joined, AssemblyOutcome::Frame(frame) if frame.pixels == [1, 2, 3, 4]), "{joined:?}");
    assert_eq!(assembler.push(&small(false, false, 20, &[1, 2]), &mut clock), AssemblyOutcome::Partial);
    assert_eq!(assembler.push(&[2, 0b11, 3, 4], &mut clock), AssemblyOutcome::Lost(Cause::PtsMissing));
    assert_eq!((assembler.losses().frame_unended, assembler.losses().pts_missing), (1, 1));
}

/// The end of a lost frame closes it: a payload of the same identifier and time behind it is the frame's copy, not its rest.
#[test]
fn the_end_of_a_lost_frame_closes_it() {
    let mut buffer = [0; 4];
    let (mut assembler, mut clock) = (Assembler::new(&mut buffer), DeviceClock::default());
    let long = assembler.push(&small(false, false, 10, &[0; 5]), &mut clock);
    assert_eq!(long, AssemblyOutcome::Lost(Cause::OverlongFrame));
    assert_eq!(assembler.push(&small(false, true, 10, &[0; 2]), &mut clock), AssemblyOutcome::Partial);
    let again = assembler.push(&small(false, true, 10, &[0; 4]), &mut clock);
    assert_eq!(again, AssemblyOutcome::Lost(Cause::Duplicate));
    // A frame that is refused with its end leaves nothing open either.
    let long = assembler.push(&small(true, true, 20, &[0; 5]), &mut clock);
    assert_eq!(long, AssemblyOutcome::Lost(Cause::OverlongFrame));
    let again = assembler.push(&small(true, true, 20, &[0; 4]), &mut clock);
    assert_eq!(again, AssemblyOutcome::Lost(Cause::Duplicate));
    // The second frame goes on from the first one without a counter of its own.
    let due = Losses { overlong_frame: 2, duplicate: 2, counter_missing: 1, ..Losses::default() };
    assert_eq!(assembler.losses(), due);
}

/// A header alone, between two frames, is the trace of one lost frame: the gap in the camera's counter is the same frame.
#[test]
fn a_frame_of_which_the_header_alone_came_is_booked_once() {
    let payloads = depth_payloads(4);
    for ended in [false, true] {
        let mut buffer = [0; 256];
        let (mut assembler, mut clock) = (Assembler::new(&mut buffer), DeviceClock::default());
        let mut alone = empty(&payloads[1]);
        alone[1] |= u8::from(ended) << 1;
        assert!(matches!(assembler.push(&payloads[0], &mut clock), AssemblyOutcome::Frame(_)));
        assert_eq!(assembler.push(&alone, &mut clock), AssemblyOutcome::Lost(Cause::EmptyPayload));
        assert!(matches!(assembler.push(&payloads[2], &mut clock), AssemblyOutcome::Frame(_)));
        assert!(matches!(assembler.push(&payloads[3], &mut clock), AssemblyOutcome::Frame(_)));
        assert_eq!(assembler.losses(), Losses { empty_payload: 1, ..Losses::default() });
    }
}

/// Within a frame a header alone is no frame of its own: the frame goes on, and a frame that never arrives is still missed.
#[test]
fn a_header_alone_within_a_frame_neither_ends_it_nor_hides_a_lost_one() {
    let payloads = depth_payloads(3);
    let [first, rest] = halves(&payloads[0]);
    let mut buffer = [0; 256];
    let (mut assembler, mut clock) = (Assembler::new(&mut buffer), DeviceClock::default());
    assert_eq!(assembler.push(&first, &mut clock), AssemblyOutcome::Partial);
    let alone = assembler.push(&empty(&payloads[0]), &mut clock);
    assert_eq!(alone, AssemblyOutcome::Lost(Cause::EmptyPayload));
    let whole = assembler.push(&rest, &mut clock);
    assert!(matches!(whole, AssemblyOutcome::Frame(frame) if frame.pixels == pixels(0, 2)), "{whole:?}");
    // The frame behind it never arrives.
    assert!(matches!(assembler.push(&payloads[2], &mut clock), AssemblyOutcome::Frame(_)));
    let due = Losses { empty_payload: 1, counter_gap: 1, ..Losses::default() };
    assert_eq!(assembler.losses(), due);
}

#[test]
fn a_header_alone_may_carry_the_end_or_the_error_of_a_frame() {
    let payloads = depth_payloads(3);
    let mut buffer = [0; 256];
    let (mut assembler, mut clock) = (Assembler::new(&mut buffer), DeviceClock::default());
    assert_eq!(assembler.push(&halves(&payloads[0])[0], &mut clock), AssemblyOutcome::Partial);
    let end = assembler.push(&payloads[0][..header(&payloads[0])], &mut clock);
    assert_eq!(end, AssemblyOutcome::Lost(Cause::ShortFrame));
    let mut broken = empty(&payloads[1]);
    broken[1] |= 0b100_0000;
    assert_eq!(assembler.push(&broken, &mut clock), AssemblyOutcome::Lost(Cause::ErrorBit));
    assert!(matches!(assembler.push(&payloads[2], &mut clock), AssemblyOutcome::Frame(_)));
    let unended = Losses { short_frame: 1, error_bit: 1, ..Losses::default() };
    assert_eq!(assembler.losses(), unended);
}
