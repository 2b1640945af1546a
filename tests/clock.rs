//! Stamps of frames on the host's clock, against the simulated camera's own book of exposures, in virtual time.

use meniscus::units::Micros;
use meniscus::usb::uvc::{Assembler, AssemblyOutcome, DeviceClock, Pairer, Stream};
use meniscus_hil::FaultList;
use meniscus_hil::device::{ClockStep, Device, Habits, TestCard};
use meniscus_service::clock_map::{ClockMap, LeastLatency};
use meniscus_service::ledger::{FrameLedger, HandledFrame, SetAside};
use meniscus_usb::buffer::Buffer;
use meniscus_usb::camera::{Note, Session, Settings, Sink};
use meniscus_virtual::usb::SimulatedBus;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Least time from mid-exposure to the arrival of a pair at the simulated camera: half of its exposure, its transfer, and
/// the infrared image behind that of depth, s.
const LATENCY_S: f64 = 0.002 + 0.006 + 0.000_3;

/// One frame on the host's clock.
struct Stamped {
    shot: u64,
    instant_s: f64,
    std_s: f64,
}

/// A host before the camera: assembles, pairs, and maps the camera's times to its own.
struct Host {
    assemblers: [Assembler<'static>; 2],
    clock: DeviceClock,
    pairer: Pairer,
    spare: Vec<Buffer>,
    bus_us: Arc<AtomicU64>,
    begun: Instant,
    map: ClockMap,
    ledger: FrameLedger,
    stamped: Vec<Stamped>,
    wanted: usize,
    draw: u64,
}

impl Host {
    fn new(bus_us: Arc<AtomicU64>, bytes: [usize; 2], buffer_bytes: usize, wanted: usize) -> Self {
        let begun = Instant::now();
        let latency = LeastLatency { mean_s: LATENCY_S, std_s: 0.000_2 };
        Self {
            assemblers: bytes
                .map(|bytes| Assembler::keeping_two(Box::leak(vec![0; 2 * bytes].into_boxed_slice()))),
            clock: DeviceClock::default(),
            pairer: Pairer::new(16_667, 2),
            spare: (0..4).map(|_| Buffer::new(buffer_bytes)).collect(),
            bus_us,
            begun,
            map: ClockMap::starting_at(begun).with_latency(latency),
            ledger: FrameLedger::default(),
            stamped: Vec::new(),
            wanted,
            draw: 7,
        }
    }

    /// A share from 0 to 1.
    fn share(&mut self) -> f64 {
        self.draw = self.draw.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.draw >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Delay of an arrival by the host: exponential of mean 1 ms, and in every fiftieth frame up to 40 ms more.
    fn queue_s(&mut self) -> f64 {
        let rare = if self.share() < 0.02 { 0.040 * self.share() } else { 0.0 };
        rare - 0.001 * (1.0 - self.share()).ln()
    }

    /// Takes a pair, as the worker does.
    fn take(&mut self, number: u32, captured: Micros, shot: u16) {
        let arrived_s = 1e-6 * self.bus_us.load(Ordering::Relaxed) as f64 + self.queue_s();
        let arrived = self.begun + Duration::from_secs_f64(arrived_s);
        if self.ledger.is_next(number, captured) {
            self.map.observe_next(captured, arrived);
        } else {
            self.map.observe(captured, arrived);
        }
        self.ledger.handle(&HandledFrame {
            number: Some(number),
            captured,
            due_s: self.map.earliest_arrival_s(captured).expect("a frame came"),
            by_clock: true,
            arrived_s,
            ended_s: arrived_s + 0.001,
            clock_restarts: self.map.restarts(),
            set_aside: SetAside::default(),
        });
        // The card's number has 16 bits.
        let shot = self.stamped.last().map_or(0, |last| last.shot & !0xffff) + u64::from(shot);
        let (instant_s, std_s) = (self.map.instant_s(captured), self.map.std_s(captured));
        self.stamped.push(Stamped {
            shot,
            instant_s: instant_s.expect("a frame came"),
            std_s: std_s.expect("a frame came"),
        });
    }
}

impl Sink for Host {
    fn wanted(&mut self) -> bool {
        self.stamped.len() < self.wanted
    }

    fn spare(&mut self) -> Option<Buffer> {
        self.spare.pop()
    }

    fn deliver(&mut self, stream: Stream, payload: Buffer) -> bool {
        let assembler = &mut self.assemblers[usize::from(stream == Stream::Outline)];
        if let AssemblyOutcome::Frame(frame) = assembler.push(&payload, &mut self.clock) {
            let shot = u16::from_le_bytes([frame.pixels[0], frame.pixels[1]]);
            if let Some(pair) = self.pairer.offer(stream, frame.stamp) {
                self.take(pair.depth.sequence, pair.depth.captured, shot);
            }
        }
        self.spare.push(payload);
        true
    }

    fn dropped(&mut self) {}

    fn note(&mut self, _: Note) {}
}

/// Errors of the stamps, ms, in the order of the frames, with the host at the end.
fn errors_ms(habits: Habits, frames: usize) -> (Vec<f64>, Host) {
    let device = Device::new(Box::new(TestCard::default()), None, FaultList::default(), 1);
    let bus = SimulatedBus::new(device.with_habits(habits));
    let bus_us = bus.watch();
    let mut session = Session::connect(bus, Settings::default()).expect("connected");
    let bytes = session.plan().streams.map(|stream| stream.frame_bytes as usize);
    let mut host = Host::new(bus_us, bytes, session.buffer_bytes(), frames);
    session.stream(&mut host).expect("it ends with the last frame that is wanted");
    let device = session.transport().device();
    let error_ms = |stamped: &Stamped| {
        let exposed_us = device.exposed_us(stamped.shot).expect("in the book");
        1e3 * (stamped.instant_s - 1e-6 * exposed_us as f64)
    };
    let errors = host.stamped.iter().map(error_ms).collect();
    (errors, host)
}

fn p99(errors_ms: &[f64]) -> f64 {
    let mut sizes: Vec<f64> = errors_ms.iter().map(|error| error.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    sizes[(sizes.len() - 1) * 99 / 100]
}

/// Two minutes of a camera whose clock drifts by 100 ppm, steps, and begins anew when the camera is plugged in again.
#[test]
fn stamps_are_true_to_a_millisecond_through_drift_a_step_and_a_replug() {
    for drift_ppm in [-100, 100] {
        let step = Some(ClockStep { shot: 2_400, by_us: 120_000 });
        let habits =
            Habits { clock_restarts: true, drift_ppm, step, replug_shot: Some(4_800), ..Habits::default() };
        let (errors_ms, host) = errors_ms(habits, 7_200);
        let stamp_error_ms_p99 = p99(&errors_ms);
        println!(
            "{drift_ppm} ppm: stamp_error_ms_p99 {stamp_error_ms_p99:.3}, drift found {:.1} ppm, {} steps, {} restarts",
            host.map.drift_ppm(),
            host.map.steps(),
            host.map.restarts()
        );
        assert!(stamp_error_ms_p99 <= 1.0, "{drift_ppm} ppm: {stamp_error_ms_p99} ms");
        assert_eq!((host.map.steps(), host.map.restarts()), (1, 1), "the step and the re-plug are counted");
        assert!((host.map.drift_ppm() + f64::from(drift_ppm)).abs() < 5.0, "{}", host.map.drift_ppm());
        // Behind the start and the recognition of each step, the stated deviation is honest: three of it hold 99 %.
        let settled = |shot: u64| [0, 2_400, 4_800].iter().all(|from| !(*from..from + 600).contains(&shot));
        let kept: Vec<_> = errors_ms.iter().zip(&host.stamped).filter(|(_, s)| settled(s.shot)).collect();
        let inside = kept.iter().filter(|(error, s)| error.abs() <= 3e3 * s.std_s).count();
        assert!(inside * 100 >= kept.len() * 99, "{inside} of {} within three deviations", kept.len());
    }
}
