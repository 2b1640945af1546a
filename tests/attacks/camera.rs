//! Attacks by a device that says it is a D435: its descriptors, its answers, its payloads.

use meniscus::usb::uvc::descriptor::interfaces;
use meniscus::usb::uvc::format::video_modes;
use meniscus::usb::uvc::request::{PROBE, Setup};
use meniscus::usb::uvc::{Assembler, AssemblyOutcome, DeviceClock, Stream};
use meniscus_usb::buffer::Buffer;
use meniscus_usb::camera::{CameraError, Note, Session, Settings, Sink};
use meniscus_usb::transport::{Completion, Listed, NotQueued, Pipe, Transport, UsbError};
use meniscus_virtual::camera_study::faults::bus;
use meniscus_virtual::usb::SimulatedBus;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::time::Duration;

/// Largest buffer of a transfer that an image of 848 x 480 with 16 bits a pixel justifies, bytes.
const BUFFER_MAX: usize = 1 << 20;
/// Calls after which a session hangs.
const PATIENCE: u32 = 50_000;

/// A camera whose bytes `lie` alters on their way: the answer to a request, or a payload (no request).
struct Liar<F> {
    bus: SimulatedBus,
    lie: F,
}

impl<F: FnMut(Option<Setup>, &mut Vec<u8>)> Transport for Liar<F> {
    fn now(&mut self) -> Duration {
        self.bus.now()
    }
    fn pause(&mut self, time: Duration) {
        self.bus.pause(time);
    }
    fn list(&mut self) -> Result<Vec<Listed>, UsbError> {
        self.bus.list()
    }
    fn open(&mut self, device: &Listed) -> Result<(), UsbError> {
        self.bus.open(device)
    }
    fn close(&mut self) {
        self.bus.close();
    }
    fn control_in(&mut self, setup: Setup, into: &mut [u8], timeout: Duration) -> Result<usize, UsbError> {
        let length = self.bus.control_in(setup, into, timeout)?;
        let mut answer = into[..length].to_vec();
        (self.lie)(Some(setup), &mut answer);
        answer.truncate(into.len());
        into[..answer.len()].copy_from_slice(&answer);
        Ok(answer.len())
    }
    fn control_out(&mut self, setup: Setup, bytes: &[u8], timeout: Duration) -> Result<(), UsbError> {
        self.bus.control_out(setup, bytes, timeout)
    }
    fn claim(&mut self, interface: u8) -> Result<(), UsbError> {
        self.bus.claim(interface)
    }
    fn clear_halt(&mut self, endpoint: u8) -> Result<(), UsbError> {
        self.bus.clear_halt(endpoint)
    }
    fn submit(&mut self, pipe: Pipe, endpoint: u8, buffer: Buffer) -> Result<(), NotQueued> {
        self.bus.submit(pipe, endpoint, buffer)
    }
    fn reap(&mut self, wait: Duration) -> Option<Completion> {
        let mut done = self.bus.reap(wait)?;
        let mut payload = done.buffer.to_vec();
        (self.lie)(None, &mut payload);
        payload.truncate(done.buffer.size());
        done.buffer.fill_from(&payload);
        Some(done)
    }
    fn cancel(&mut self) {
        self.bus.cancel();
    }
    fn in_flight(&self) -> usize {
        self.bus.in_flight()
    }
    fn reset(&mut self) -> Result<(), UsbError> {
        self.bus.reset()
    }
}

/// Takes frames until there are enough or the session hangs.
struct Counter {
    assemblers: [Assembler<'static>; 2],
    clock: DeviceClock,
    spare: Vec<Buffer>,
    frames: u32,
    calls: u32,
}

impl Sink for Counter {
    fn wanted(&mut self) -> bool {
        self.calls += 1;
        self.frames < 24 && self.calls < PATIENCE
    }
    fn spare(&mut self) -> Option<Buffer> {
        self.spare.pop()
    }
    fn deliver(&mut self, stream: Stream, payload: Buffer) -> bool {
        let assembler = &mut self.assemblers[usize::from(stream == Stream::Outline)];
        let whole = matches!(assembler.push(&payload, &mut self.clock), AssemblyOutcome::Frame(_));
        self.frames += u32::from(whole);
        self.spare.push(payload);
        true
    }
    fn dropped(&mut self) {}
    fn note(&mut self, _: Note) {}
}

/// Outcome of a session with a liar: no session, or frames and how the streams ended.
type Met = Result<(u32, Result<(), CameraError>), CameraError>;

/// Connects to a camera that lies and reads 24 frames of it. Whatever it says, what comes out is bounded and finite.
fn meet(lie: impl FnMut(Option<Setup>, &mut Vec<u8>)) -> Met {
    let mut session = Session::connect(Liar { bus: bus(None), lie }, Settings::default())?;
    let optics = session.connected().optics();
    let lens = [optics.intrinsics.fx, optics.intrinsics.fy, optics.depth_unit_m];
    assert!(lens.iter().all(|number| number.is_finite() && *number > 0.0), "{optics:?}");
    let bytes = session.buffer_bytes();
    assert!(bytes <= BUFFER_MAX, "{bytes} bytes a transfer");
    let images = session.plan().streams.map(|stream| stream.frame_bytes as usize);
    let assembler = |bytes: usize| Assembler::new(Box::leak(vec![0; bytes].into_boxed_slice()));
    let mut counter = Counter {
        assemblers: images.map(assembler),
        clock: DeviceClock::default(),
        spare: (0..4).map(|_| Buffer::new(bytes)).collect(),
        frames: 0,
        calls: 0,
    };
    let ended = session.stream(&mut counter);
    assert!(counter.calls < PATIENCE, "the session hangs");
    assert_eq!(session.transport().in_flight(), 0, "transfers are left in flight");
    Ok((counter.frames, ended))
}

/// Flips, sets and cuts a few places of `bytes`.
fn alter(random: &mut ChaCha8Rng, bytes: &mut Vec<u8>) {
    for _ in 0..random.random_range(1..4) {
        if bytes.is_empty() {
            return;
        }
        let at = random.random_range(0..bytes.len());
        match random.random_range(0..4) {
            0 => bytes[at] ^= 1 << random.random_range(0..8),
            1 => bytes[at] = [0, 1, 127, 255][random.random_range(0..4_usize)],
            2 => bytes.truncate(at),
            _ => bytes[at..].iter_mut().take(4).for_each(|byte| *byte = 0xff),
        }
    }
}

/// A camera that claims huge images gets buffers of the images that are understood, or is refused in words.
///
/// Frame descriptors and probe answers that claim images and transfers of 4 GiB.
#[test]
fn a_camera_that_claims_gigabytes_gets_none() {
    // Bytes of an image (VS_FRAME_UNCOMPRESSED) or of a line (VS_FRAME_FRAME_BASED): UVC 1.5, payload specifications.
    let mut claimed = 0;
    let claim = |setup: Option<Setup>, bytes: &mut Vec<u8>| {
        if setup.is_none_or(|setup| setup.request != 6) {
            return;
        }
        for at in 0..bytes.len().saturating_sub(26) {
            let place = match bytes[at..at + 3] {
                [length, 0x24, 5] if length >= 26 => 17,
                [length, 0x24, 0x11] if length >= 26 => 22,
                _ => continue,
            };
            bytes[at + place..at + place + 4].fill(0xff);
        }
        // The claim is read as one: whoever believes it takes gigabytes.
        let modes = interfaces(bytes)
            .flat_map(|one| video_modes(&one).map(|mode| mode.frame_bytes).collect::<Vec<_>>());
        claimed += modes.filter(|bytes| *bytes > 1 << 30).count();
    };
    let (frames, ended) = meet(claim).expect("the claim is not believed, and the camera is read");
    assert_eq!((frames, ended), (24, Ok(())));
    assert!(claimed > 10, "{claimed} modes claim gigabytes");
    // dwMaxVideoFrameSize and dwMaxPayloadTransferSize of a probe (UVC 1.5, table 4-75).
    let probe = |setup: Option<Setup>, bytes: &mut Vec<u8>| {
        if setup.is_some_and(|setup| {
            setup.request_type == 0xa1 && setup.value == u16::from(PROBE) << 8 && setup.index < 256
        }) && bytes.len() >= 26
        {
            bytes[18..26].fill(0xff);
        }
    };
    let refused = meet(probe).expect_err("an image of another size is not the wanted image").to_string();
    assert!(refused.contains("frames of 4294967295 bytes") && refused.contains("What to do: "), "{refused}");
}

/// Whatever a camera answers, a session ends in frames or in words that say what to do.
///
/// 300 cameras, each with one altered descriptor, calibration table, identity or probe, or with every eighth answer altered.
#[test]
fn a_camera_that_answers_wrongly_ends_in_frames_or_words() {
    let (mut refused, mut read) = (0, 0);
    for seed in 0..300_u64 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let (chosen, mut answers) = (random.random_range(0..24), 0);
        let met = meet(|setup, bytes| {
            let Some(_) = setup else { return };
            answers += 1;
            let one = seed.is_multiple_of(2);
            if (one && answers == chosen) || (!one && random.random_range(0..8) == 0) {
                alter(&mut random, bytes);
            }
        });
        match met {
            Err(error) | Ok((_, Err(error))) => {
                refused += 1;
                assert!(error.to_string().contains("What to do: "), "seed {seed}: {error}");
            }
            Ok((frames, Ok(()))) => {
                read += 1;
                assert_eq!(frames, 24, "seed {seed}");
            }
        }
    }
    assert!(refused > 30 && read > 30, "{refused} refused, {read} read");
}

/// Altered payloads end a session neither by a crash nor by waiting for ever.
///
/// 60 cameras whose payloads are altered or cut, from one in thirty to all of them.
#[test]
fn a_camera_that_sends_rubbish_is_read_or_given_up() {
    let (mut given_up, mut read) = (0, 0);
    for seed in 0..60 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let share = [0.03, 0.3, 1.0][seed as usize % 3];
        let met = meet(|setup, bytes| {
            if setup.is_none() && random.random_bool(share) {
                let mut head: Vec<u8> = bytes.iter().take(64).copied().collect();
                let tail = bytes.split_off(head.len());
                alter(&mut random, &mut head);
                bytes.clear();
                bytes.extend(head);
                bytes.extend(tail);
            }
        });
        match met.expect("its answers are sound") {
            (_, Err(error)) => {
                given_up += 1;
                assert!(error.to_string().contains("What to do: "), "seed {seed}: {error}");
            }
            (frames, Ok(())) => {
                read += 1;
                assert_eq!(frames, 24, "seed {seed}");
            }
        }
    }
    assert!(read > 20, "{read} read, {given_up} given up");
}
