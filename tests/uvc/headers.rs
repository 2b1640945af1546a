//! Headers of payloads: fields with and without their flags, impossible lengths, random bytes.

use meniscus::usb::uvc::{
    Assembler, AssemblyOutcome, Cause, DeviceClock, HeaderError, PayloadHeader, Timing,
};
use meniscus_hil::{Image, pack};

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
