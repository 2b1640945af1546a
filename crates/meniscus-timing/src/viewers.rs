//! Turn time with viewers of the live page, and bytes sent to each, measured end to end.
//!
//! The simulated camera plays its recording round after round in real time; viewers look in every second pair of
//! rounds (without, with, with, without), so that every turn has its like with the same content on both sides, and a
//! machine that grows slower or faster meanwhile favours neither.

use meniscus::blob::Model;
use meniscus::runtime::DEADLINE_US;
use meniscus::runtime::Estimator;
use meniscus::surface::Config;
use meniscus_data::recording::Recording;
use meniscus_numerics::statistics::quantile;
use meniscus_report::checks::Check;
use meniscus_service::live::{Log, Worker};
use meniscus_service::run::Viewer;
use meniscus_service::timed_turn::TimedTurn;
use meniscus_ui::page::{Page, PageError};
use meniscus_usb::link::link;
use meniscus_virtual::camera::{PAYLOAD_ROOM, SimulatedCamera};
use meniscus_virtual::looped_recording::BACK;
use meniscus_virtual::render::SceneSettings;
use std::net::{Ipv4Addr, SocketAddr, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use tungstenite::Message;

/// Payload buffers between camera and worker, as in the main job.
const BUFFERS: usize = 8;

/// The start of each round that is left out: viewers come and go in it.
const SETTLE: Duration = Duration::from_millis(500);

/// Rate that the page requests by default, Hz.
const RATE: u8 = 60;

/// Measured times and rates.
#[derive(Clone, Debug, Default)]
pub struct Viewers {
    /// Times of the turns without and with viewers, microseconds.
    pub turn_us: [Vec<u64>; 2],
    /// Turns that ended more than a frame interval after their payload, without and with viewers.
    pub late: [u64; 2],
    /// Bytes and frames of each viewer, each second.
    pub rates: Vec<(f64, f64)>,
    /// Bytes of the bases, once a viewer.
    pub load_bytes: usize,
    /// Change of the median turn from each round without viewers to its like with them, as a share.
    pub changes: Vec<f64>,
}

/// Extent of the measurement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ViewerPlan {
    /// Pairs of rounds, one with viewers and one without.
    pub pairs: usize,
    /// Viewers at a time.
    pub viewers: usize,
}

/// Measures by this plan; `each` is called after every round.
///
/// # Errors
/// [`PageError`], when no page can be opened.
pub fn study(
    model: &Model<'_>,
    recording: &Recording,
    scene: SceneSettings,
    config: Config,
    plan: ViewerPlan,
    each: impl Fn() + Sync,
) -> Result<Viewers, PageError> {
    let ViewerPlan { pairs, viewers: count } = plan;
    let address = SocketAddr::from((Ipv4Addr::LOCALHOST, 0));
    let page = Page::open(model, config, "a measurement", address, None)?;
    let camera = SimulatedCamera::new(recording, scene, meniscus_hil::FaultList::default()).repeating();
    let round = Duration::from_secs_f64((recording.frames() + BACK) as f64 / 60.0);
    let turns = 2 * pairs * (recording.frames() + BACK) + 600;
    let stop = AtomicBool::new(false);
    let (camera_end, worker_end) = link(BUFFERS, PAYLOAD_ROOM);
    let mut measured = Viewers::default();
    std::thread::scope(|scope| {
        let (page, stop) = (&page, &stop);
        scope.spawn(move || camera.play(usize::MAX, &camera_end, stop));
        scope.spawn(move || page.show(model));
        let worker = scope.spawn(move || {
            let (mut log, mut outlet) = (Log::with_room(turns), page.sink());
            Worker::new(Estimator::new(model), config).run(&worker_end, stop, &mut [&mut outlet, &mut log]);
            log
        });
        let begun = Instant::now();
        let mut rounds = Vec::new();
        for number in 0..2 * pairs {
            let looked = matches!(number % 4, 1 | 2);
            let end = begun + round * (number as u32 + 1);
            let gone = AtomicBool::new(false);
            std::thread::scope(|viewers| {
                let wanted = if looked { count } else { 0 };
                let (from, gone) = (page.address(), &gone);
                let all: Vec<_> = (0..wanted).map(|_| viewers.spawn(move || view(from, gone))).collect();
                std::thread::sleep(end.saturating_duration_since(Instant::now()));
                gone.store(true, Ordering::Relaxed);
                measured.rates.extend(all.into_iter().filter_map(|viewer| viewer.join().ok().flatten()));
            });
            rounds.push((looked, end - round + SETTLE, end));
            each();
        }
        stop.store(true, Ordering::Relaxed);
        page.end();
        if let Ok(log) = worker.join() {
            measured.take(&rounds, &log.turns);
        }
    });
    measured.load_bytes = page.load_bytes();
    Ok(measured)
}

/// One viewer until it is `gone`: bytes and frames a second; `None` if it was let go before.
fn view(address: SocketAddr, gone: &AtomicBool) -> Option<(f64, f64)> {
    let stream = TcpStream::connect(address).ok()?;
    stream.set_nodelay(true).ok()?;
    let (mut socket, _) = tungstenite::client(format!("ws://{address}/live"), stream).ok()?;
    let taken = |number: [u8; 4]| {
        let [a, b, c, d] = number;
        Message::binary(vec![a, b, c, d, RATE, 0, 0, 0])
    };
    socket.send(taken([0; 4])).ok()?;
    let begun = Instant::now();
    let (mut bytes, mut frames) = (0_usize, 0_u32);
    while !gone.load(Ordering::Relaxed) {
        let Message::Binary(message) = socket.read().ok()? else { continue };
        // A header of four bytes: no message here is longer than 64 KiB.
        bytes += message.len() + 4;
        if let [1, _, _, _, number @ ..] = &*message
            && let Some(number) = number.first_chunk::<4>()
        {
            frames += 1;
            socket.send(taken(*number)).ok()?;
        }
    }
    let seconds = begun.elapsed().as_secs_f64();
    Some((bytes as f64 / seconds, f64::from(frames) / seconds))
}

impl Viewers {
    /// Sorts the turns into the rounds that they ended in.
    fn take(&mut self, rounds: &[(bool, Instant, Instant)], turns: &[TimedTurn]) {
        let mut medians: [Vec<f64>; 2] = [vec![], vec![]];
        for (looked, from, to) in rounds {
            // Turns without a frame cost a third: a machine that starves the camera must not look quick.
            let like =
                |logged: &&TimedTurn| logged.turn.stamp.is_some() && (*from..*to).contains(&logged.ended);
            let within = turns.iter().filter(like);
            let mut times: Vec<u64> = within.clone().map(|logged| logged.turn_us).collect();
            self.late[usize::from(*looked)] +=
                within.filter(|logged| logged.latency_us > DEADLINE_US).count() as u64;
            medians[usize::from(*looked)].push(quantile_us(&times, 0.5));
            self.turn_us[usize::from(*looked)].append(&mut times);
        }
        let [without, with] = medians;
        self.changes = without.iter().zip(with).map(|(without, with)| with / without - 1.0).collect();
    }

    /// Change of the median turn by the viewers, as a share of it.
    #[must_use]
    pub fn change(&self) -> f64 {
        quantile_us(&self.turn_us[1], 0.5) / quantile_us(&self.turn_us[0], 0.5) - 1.0
    }

    /// Returns the mean data rate to one viewer, Mbit/s.
    #[must_use]
    pub fn mbit_s(&self) -> f64 {
        8e-6 * self.rates.iter().map(|rate| rate.0).sum::<f64>() / self.rates.len() as f64
    }

    /// Frames a second of the viewer that got fewest.
    #[must_use]
    pub fn frames_s(&self) -> f64 {
        self.rates.iter().map(|rate| rate.1).fold(f64::INFINITY, f64::min)
    }

    /// Everything as checks; the targets are those of the page.
    #[must_use]
    pub fn checks(&self) -> Vec<Check> {
        let of = |looked: usize, part: f64| quantile_us(&self.turn_us[looked], part);
        vec![
            Check::at_most("viewers_turn_change", self.change(), "1", 0.02),
            Check::at_most("page_mbit_s", self.mbit_s(), "Mbit/s", 2.0),
            Check::informational("page_frames_s", self.frames_s(), "Hz"),
            Check::informational("page_load_mb", self.load_bytes as f64 * 1e-6, "MB"),
            Check::informational(
                "turns_with_a_frame",
                self.turn_us.iter().map(Vec::len).sum::<usize>() as f64,
                "1",
            ),
            Check::informational("turn_us_median_alone", of(0, 0.5), "us"),
            Check::informational("turn_us_median_viewers", of(1, 0.5), "us"),
            Check::informational("turn_us_p99_alone", of(0, 0.99), "us"),
            Check::informational("turn_us_p99_viewers", of(1, 0.99), "us"),
            Check::informational("deadline_misses_alone", self.late[0] as f64, "1"),
            Check::informational("deadline_misses_viewers", self.late[1] as f64, "1"),
        ]
    }
}

/// The quantile of times in whole microseconds; NaN of none.
fn quantile_us(times: &[u64], share: f64) -> f64 {
    quantile(times.iter().copied(), share).map_or(f64::NAN, |time| time as f64)
}
