//! Thread that listens for plans.

use super::course::Course;
use super::plan::{LONGEST, Plan, read};
use super::plan_rules::PlanFault;
use super::record::PlanStanding;
use crate::commanded_motion::{ExpectedSender, Say};
use meniscus::runtime::output::HostTime;
use std::collections::BTreeMap;
use std::net::{SocketAddr, UdpSocket};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// Interval at which the listener checks whether it is still wanted.
const PAUSE: Duration = Duration::from_millis(100);

/// Pause between two messages about plans with the same fault: a sender of nothing else must not fill the log.
const SILENCE: Duration = Duration::from_secs(2);

/// Plans that are read in a second at most: a flood costs no more.
const RATE_HZ: u64 = 200;

/// Settings of the plans over UDP.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanWire {
    /// Address to listen at.
    pub address: SocketAddr,
    /// Direction of the line of the model in the axes of the plans, of length one.
    pub line: [f64; 3],
    /// Sender that is expected.
    pub expected: ExpectedSender,
}

/// The newest plan and what became of the ones before.
#[derive(Debug, Default)]
struct Held {
    plan: Option<Plan>,
    standing: PlanStanding,
}

/// The newest plan of a run, shared between those that receive plans and those that follow one.
#[derive(Clone, Debug, Default)]
pub struct SharedPlan {
    held: Arc<Mutex<Held>>,
    pub(super) ended: Arc<AtomicBool>,
}

impl SharedPlan {
    /// Takes a plan, or the fault of one: then the plan before it goes on, as it is what the robot still carries out.
    pub fn take(&self, plan: Result<Plan, PlanFault>) {
        self.with(|held| match plan {
            Ok(plan) => {
                held.standing.taken += 1;
                held.plan = Some(plan);
            }
            Err(fault) => held.standing.refuse(fault),
        });
    }

    /// Returns the standing of the newest plan, and its course behind the instant `host`.
    #[must_use]
    pub fn course(&self, host: Option<HostTime>) -> (PlanStanding, Course) {
        self.with(|held| {
            let mut standing = held.standing;
            let running = held.plan.as_ref().and_then(|plan| Some((plan, Course::of(plan, host)?)));
            let Some((plan, course)) = running else { return (standing, Course::default()) };
            (standing.sequence, standing.across_m) = (Some(plan.sequence), plan.across_m as f32);
            (standing, course)
        })
    }

    /// Calls `with` on what is held.
    fn with<T>(&self, with: impl FnOnce(&mut Held) -> T) -> T {
        // A plan is put in whole: there is nothing that a panic could leave half done.
        with(&mut self.held.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Listens for plans until `ended` is set.
    ///
    /// # Errors
    /// The error of the operating system on the address.
    pub(super) fn listen(&self, wire: PlanWire, say: Say) -> std::io::Result<()> {
        let socket = UdpSocket::bind(wire.address)?;
        socket.set_read_timeout(Some(PAUSE))?;
        let shared = self.clone();
        let thread = std::thread::Builder::new().name("plans".into());
        thread.spawn(move || shared.run(&socket, &wire, &say)).map(drop)
    }

    fn run(&self, socket: &UdpSocket, wire: &PlanWire, say: &Say) {
        let (mut room, mut said) = (vec![0; LONGEST], BTreeMap::new());
        while !self.ended.load(Ordering::Relaxed) {
            let Ok((length, from)) = socket.recv_from(&mut room) else { continue };
            let stranger = wire
                .expected
                .address
                .is_some_and(|address| address.to_canonical() != from.ip().to_canonical());
            if !stranger {
                let fault = self.hear(room.get(..length).unwrap_or_default(), wire);
                if let Some(fault) = fault
                    && said.get(&fault.code()).is_none_or(|last: &Instant| last.elapsed() >= SILENCE)
                {
                    said.insert(fault.code(), Instant::now());
                    say(&format!("a plan was refused: {fault}"));
                }
            }
            std::thread::sleep(Duration::from_micros(1_000_000 / RATE_HZ));
        }
    }

    /// Takes one datagram; returns the fault of a plan that is refused.
    fn hear(&self, bytes: &[u8], wire: &PlanWire) -> Option<PlanFault> {
        let now_ns = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |now| now.as_nanos() as u64);
        let read = read(bytes, wire.expected.token.as_deref(), &wire.line, now_ns)?;
        let fault = read.as_ref().err().copied();
        self.take(read);
        fault
    }
}
