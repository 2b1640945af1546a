//! Actions of each rung of the recovery ladder, every wait bounded.

use super::connect::{LOOK, establish, pause_or_return};
use super::error::CameraError;
use super::monitor::send;
use super::negotiate::negotiate;
use super::recovery::Rung;
use super::session::{Session, TICK};
use super::sink::Sink;
use crate::transport::{Status, Transport, UsbError};
use meniscus::usb::d4xx::{Command, opcode};
use std::time::Duration;

/// Longest time for a cancelled queue to come back.
const DRAIN: Duration = Duration::from_millis(500);
/// Longest times for the camera to leave the bus after its restart, and to come back.
const LEAVE: Duration = Duration::from_secs(1);
const RETURN: Duration = Duration::from_secs(10);
/// Time that a reset port is given.
const AFTER_RESET: Duration = Duration::from_millis(500);

/// State of a camera on the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Presence {
    /// It is listed.
    There,
    /// It is not.
    Gone,
}

impl<T: Transport> Session<T> {
    /// Takes a rung. Afterwards the transfers are queued, or the reason says why not.
    pub(super) fn climb(&mut self, rung: Rung, sink: &mut impl Sink) -> Result<(), CameraError> {
        self.health.rungs[rung as usize] += 1;
        self.patience = rung.settle();
        match rung {
            Rung::Requeue => self.drain()?,
            Rung::Renegotiate => {
                self.drain()?;
                negotiate(&mut self.transport, &self.plan)?;
            }
            Rung::Restart => {
                // Whether it was heard shows in the camera's leaving the bus.
                let _heard = send(&mut self.transport, &self.plan, &Command::new(opcode::HWRST, [0; 4]));
                self.close();
                self.wait_for(Presence::Gone, LEAVE, sink)?;
                self.wait_for(Presence::There, RETURN, sink)?;
                self.reopen()?;
            }
            Rung::Reset => {
                let _drained = self.drain();
                let reset = match self.transport.reset() {
                    // A restart that was not heard has closed it.
                    Err(UsbError::NoDevice) => self.reset_closed(),
                    reset => reset,
                };
                self.close();
                reset.map_err(|error| CameraError::Usb { doing: "reset the camera's port", error })?;
                self.transport.pause(AFTER_RESET);
                self.reopen()?;
            }
            Rung::Replug => {
                self.close();
                self.reopen()?;
            }
        }
        self.start().map_err(|trouble| CameraError::GaveUp { seconds: 0, last: trouble.to_string() })
    }

    /// The pause before a rung; that before a re-plug ends when the camera comes back.
    pub(super) fn wait_before(&mut self, rung: Rung, pause: Duration, sink: &mut impl Sink) {
        if rung == Rung::Replug {
            let serial = self.settings.serial.as_deref();
            pause_or_return(&mut self.transport, serial, pause, || sink.wanted());
        } else {
            self.transport.pause(pause);
        }
    }

    /// Cancels what is in flight and waits until it has come back.
    fn drain(&mut self) -> Result<(), CameraError> {
        self.transport.cancel();
        let deadline = self.transport.now() + DRAIN;
        while self.transport.in_flight() > 0 && self.transport.now() < deadline {
            let Some(ended) = self.transport.reap(TICK) else { continue };
            if ended.status == Status::Completed {
                self.health.drained += 1;
            }
            self.idle.push(ended.buffer);
        }
        if self.transport.in_flight() > 0 {
            return Err(CameraError::Usb {
                doing: "get the camera's transfers back",
                error: UsbError::Timeout,
            });
        }
        Ok(())
    }

    /// Closes the device; what did not come back is counted.
    fn close(&mut self) {
        let _drained = self.drain();
        self.health.buffers_lost += self.transport.in_flight() as u64;
        self.transport.close();
    }

    /// Stops for good.
    pub(super) fn stop(&mut self) {
        self.close();
        self.idle.clear();
    }

    /// Opens the camera for nothing but a reset.
    fn reset_closed(&mut self) -> Result<(), UsbError> {
        let port = &self.connected.device.port;
        let listed = self.transport.list()?.into_iter().find(|device| device.port == *port);
        self.transport.open(&listed.ok_or(UsbError::NoDevice)?)?;
        self.transport.reset()
    }

    /// Waits until the camera has left the bus, or is back on it.
    fn wait_for(
        &mut self,
        wanted: Presence,
        limit: Duration,
        sink: &mut impl Sink,
    ) -> Result<(), CameraError> {
        let deadline = self.transport.now() + limit;
        while sink.wanted() {
            let port = &self.connected.device.port;
            let listed = self.transport.list().unwrap_or_default();
            let there = listed.iter().any(|device| device.port == *port);
            if there == (wanted == Presence::There) {
                return Ok(());
            }
            if self.transport.now() >= deadline {
                let doing = match wanted {
                    Presence::There => "find the camera after its restart",
                    Presence::Gone => "restart the camera",
                };
                return Err(CameraError::Usb { doing, error: UsbError::Timeout });
            }
            self.transport.pause(LOOK);
        }
        Ok(())
    }

    /// Opens the same camera again; it has to give the same images as before.
    fn reopen(&mut self) -> Result<(), CameraError> {
        let (connected, plan) = establish(&mut self.transport, &self.settings)?;
        if connected.size != self.connected.size || connected.depth_unit_um != self.connected.depth_unit_um {
            self.transport.close();
            return Err(CameraError::SlowLink(connected.device.port));
        }
        (self.connected, self.plan) = (connected, plan);
        Ok(())
    }
}
