//! Thread that listens for plans.

use super::plan::{LONGEST, Plan, read};
use super::record::PlanStanding;
use crate::commanded_motion::{ExpectedSender, Say};
use std::net::{SocketAddr, UdpSocket};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// Interval at which the listener checks whether it is still wanted.
const PAUSE: Duration = Duration::from_millis(100);

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
pub(super) struct Held {
    pub(super) plan: Option<Plan>,
    pub(super) standing: PlanStanding,
}

/// The newest plan, shared between the listener and the controller's thread.
#[derive(Clone, Debug, Default)]
pub(super) struct SharedPlan {
    held: Arc<Mutex<Held>>,
    pub(super) ended: Arc<AtomicBool>,
}

impl SharedPlan {
    /// Calls `with` on what is held.
    pub(super) fn with<T>(&self, with: impl FnOnce(&mut Held) -> T) -> T {
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
        let mut room = vec![0; LONGEST];
        while !self.ended.load(Ordering::Relaxed) {
            let Ok((length, from)) = socket.recv_from(&mut room) else { continue };
            let stranger = wire
                .expected
                .address
                .is_some_and(|address| address.to_canonical() != from.ip().to_canonical());
            if !stranger {
                self.take(room.get(..length).unwrap_or_default(), wire, say);
            }
            std::thread::sleep(Duration::from_micros(1_000_000 / RATE_HZ));
        }
    }

    /// Takes one datagram.
    fn take(&self, bytes: &[u8], wire: &PlanWire, say: &Say) {
        let now_ns = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |now| now.as_nanos() as u64);
        let Some(read) = read(bytes, wire.expected.token.as_deref(), &wire.line, now_ns) else { return };
        match read {
            Ok(plan) => self.with(|held| {
                held.standing.taken += 1;
                held.plan = Some(plan);
            }),
            Err(fault) => {
                // The plan before it goes on: it is what the robot still carries out.
                self.with(|held| held.standing.refuse(fault));
                say(&format!("a plan was refused: {fault}"));
            }
        }
    }
}
