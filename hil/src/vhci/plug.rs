//! A camera at a port, for as long as it lives: two threads, one for what the kernel asks, one for the clock.

use super::bus::{Bus, Witness, receive};
use super::port::{self, PortError};
use crate::device::{Device, Trouble};
use std::os::unix::net::UnixStream;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Longest sleep of the clock's thread: how late a plug or unplug may be.
const LOOK: Duration = Duration::from_millis(5);

#[derive(Debug)]
struct Shared {
    bus: Mutex<Bus>,
    /// Something was asked that may have brought the next event forward.
    asked: Condvar,
    over: Mutex<bool>,
}

impl Shared {
    fn bus(&self) -> MutexGuard<'_, Bus> {
        self.bus.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn is_over(&self) -> bool {
        *self.over.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A camera that is plugged in, until this is dropped.
#[derive(Debug)]
pub struct Plugged {
    shared: Arc<Shared>,
    clock: Option<JoinHandle<Result<(), PortError>>>,
}

impl Plugged {
    /// Plugs a camera in; it comes and goes as its troubles say.
    ///
    /// # Errors
    /// [`PortError`] when it cannot be attached now.
    pub fn new(device: Device) -> Result<Self, PortError> {
        let shared =
            Shared { bus: Mutex::new(Bus::new(device)), asked: Condvar::new(), over: Mutex::new(false) };
        let shared = Arc::new(shared);
        // The first time is tried here, so that the caller learns the reason.
        look(&shared)?;
        let clock = Arc::clone(&shared);
        let clock = std::thread::spawn(move || run(&clock));
        Ok(Self { shared, clock: Some(clock) })
    }

    /// Returns the observations so far.
    #[must_use]
    pub fn witness(&self) -> Witness {
        self.shared.bus().witness.clone()
    }

    /// Imposes a trouble on the camera now.
    pub fn impose(&self, trouble: Trouble) {
        let mut bus = self.shared.bus();
        let now_us = bus.now_us();
        bus.device.impose(trouble, now_us);
        drop(bus);
        self.shared.asked.notify_all();
    }

    /// Returns the times of all exposures so far, microseconds since the camera was made: its own book.
    #[must_use]
    pub fn exposures_us(&self) -> Vec<u64> {
        self.shared.bus().device.exposures_us().to_vec()
    }

    /// Takes the camera away for good and waits until its port is free.
    ///
    /// # Errors
    /// [`PortError`] when the port could not be used at some time, or does not become free.
    pub fn unplug(mut self) -> Result<Witness, PortError> {
        let ended = self.end();
        let begun = Instant::now();
        while !port::all_free()? {
            if begun.elapsed() > Duration::from_secs(5) {
                return Err(PortError::NoneFree("left"));
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        ended.map(|()| self.witness())
    }

    fn end(&mut self) -> Result<(), PortError> {
        *self.shared.over.lock().unwrap_or_else(PoisonError::into_inner) = true;
        self.shared.asked.notify_all();
        let ended = self.clock.take().and_then(|clock| clock.join().ok()).unwrap_or(Ok(()));
        self.shared.bus().unplug();
        ended
    }
}

impl Drop for Plugged {
    fn drop(&mut self) {
        let _ended = self.end();
    }
}

/// Plugs or unplugs the camera as its device says.
fn look(shared: &Arc<Shared>) -> Result<(), PortError> {
    let mut bus = shared.bus();
    let now_us = bus.now_us();
    match (bus.device.seen(now_us), bus.link.is_some()) {
        (None, true) => bus.unplug(),
        (Some(seen), false) => {
            drop(bus);
            let link = port::attach(seen.usb2)?;
            let kernel = link.try_clone().map_err(PortError::Refused)?;
            shared.bus().plug(link);
            let shared = Arc::clone(shared);
            std::thread::spawn(move || hear(&shared, kernel));
        }
        _ => {}
    }
    Ok(())
}

/// Takes what the kernel asks until the socket is closed.
fn hear(shared: &Shared, mut kernel: UnixStream) {
    while let Ok((command, bytes)) = receive(&mut kernel) {
        shared.bus().take(command, &bytes);
        shared.asked.notify_all();
    }
}

/// The clock: events at their time.
fn run(shared: &Arc<Shared>) -> Result<(), PortError> {
    while !shared.is_over() {
        look(shared)?;
        let mut bus = shared.bus();
        bus.pump();
        let now_us = bus.now_us();
        let ahead = bus.device.next_us().map(|at_us| Duration::from_micros(at_us.saturating_sub(now_us)));
        let wait = ahead.unwrap_or(LOOK).min(LOOK);
        if !wait.is_zero() {
            let _woken = shared.asked.wait_timeout(bus, wait);
        }
    }
    Ok(())
}
