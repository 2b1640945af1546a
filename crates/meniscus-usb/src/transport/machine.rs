//! The machine's own bus, by libusb.
//!
//! One context for the whole run and one handle for as long as the device is there; the kernel's video
//! driver is detached at the claim and kept away by holding the interfaces.

use super::libusb::usb_error;
use super::transfers::Slot;
use super::{Completion, Listed, NotQueued, Pipe, Speed, Transport, UsbError};
use crate::buffer::Buffer;
use meniscus::usb::uvc::request::Setup;
use rusb::{Context, Device, DeviceHandle, UsbContext};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Time that transfers in flight have to come back when the device is closed.
const CLOSE_LIMIT: Duration = Duration::from_secs(1);

/// libusb's bus.
#[derive(Debug)]
pub struct Machine {
    // Dropped in this order: transfers, handle, context.
    slots: Vec<Slot>,
    handle: Option<Arc<DeviceHandle<Context>>>,
    context: Context,
    begun: Instant,
}

impl Machine {
    /// Opens libusb; no device is touched.
    ///
    /// # Errors
    /// [`UsbError`] when libusb finds no bus on this machine.
    pub fn new() -> Result<Self, UsbError> {
        let context = Context::new().map_err(usb_error)?;
        Ok(Self { slots: Vec::new(), handle: None, context, begun: Instant::now() })
    }

    fn handle(&self) -> Result<&Arc<DeviceHandle<Context>>, UsbError> {
        self.handle.as_ref().ok_or(UsbError::NoDevice)
    }

    fn devices(&self) -> Result<Vec<(Listed, Device<Context>)>, UsbError> {
        let devices = self.context.devices().map_err(usb_error)?;
        Ok(devices.iter().filter_map(|device| Some((listed(&device)?, device))).collect())
    }
}

impl Transport for Machine {
    fn now(&mut self) -> Duration {
        self.begun.elapsed()
    }

    fn pause(&mut self, time: Duration) {
        std::thread::sleep(time);
    }

    fn list(&mut self) -> Result<Vec<Listed>, UsbError> {
        Ok(self.devices()?.into_iter().map(|(listed, _)| listed).collect())
    }

    fn open(&mut self, wanted: &Listed) -> Result<(), UsbError> {
        self.close();
        let devices = self.devices()?;
        let same = |(listed, _): &(Listed, _)| listed.port == wanted.port && listed.product == wanted.product;
        let (_, device) = devices.into_iter().find(same).ok_or(UsbError::NoDevice)?;
        let handle = device.open().map_err(usb_error)?;
        match handle.set_auto_detach_kernel_driver(true) {
            // Where there is no kernel driver to detach, there is nothing to do.
            Ok(()) | Err(rusb::Error::NotSupported) => {}
            Err(error) => return Err(usb_error(error)),
        }
        self.handle = Some(Arc::new(handle));
        Ok(())
    }

    fn close(&mut self) {
        self.cancel();
        let deadline = self.now() + CLOSE_LIMIT;
        while !self.slots.is_empty() && self.now() < deadline {
            let _ended = self.reap(deadline.saturating_sub(self.begun.elapsed()));
        }
        // What did not come back is leaked with its share of the handle: see `transfers`.
        self.slots.clear();
        self.handle = None;
    }

    fn control_in(&mut self, setup: Setup, into: &mut [u8], timeout: Duration) -> Result<usize, UsbError> {
        let Setup { request_type, request, value, index } = setup;
        self.handle()?
            .read_control(request_type, request, value, index, into, finite(timeout))
            .map_err(usb_error)
    }

    fn control_out(&mut self, setup: Setup, bytes: &[u8], timeout: Duration) -> Result<(), UsbError> {
        let Setup { request_type, request, value, index } = setup;
        let handle = self.handle()?;
        let sent = handle.write_control(request_type, request, value, index, bytes, finite(timeout));
        if sent.map_err(usb_error)? == bytes.len() { Ok(()) } else { Err(UsbError::Io) }
    }

    fn claim(&mut self, interface: u8) -> Result<(), UsbError> {
        self.handle()?.claim_interface(interface).map_err(usb_error)
    }

    fn clear_halt(&mut self, endpoint: u8) -> Result<(), UsbError> {
        self.handle()?.clear_halt(endpoint).map_err(usb_error)
    }

    fn submit(&mut self, pipe: Pipe, endpoint: u8, buffer: Buffer) -> Result<(), NotQueued> {
        let Some(handle) = &self.handle else {
            return Err(NotQueued { error: UsbError::NoDevice, buffer });
        };
        self.slots.push(Slot::submit(handle, pipe, endpoint, buffer)?);
        Ok(())
    }

    fn reap(&mut self, wait: Duration) -> Option<Completion> {
        let deadline = Instant::now() + wait;
        loop {
            let ends = self.slots.iter().enumerate().filter_map(|(place, slot)| Some((slot.end()?, place)));
            if let Some((_, place)) = ends.min() {
                let slot = self.slots.swap_remove(place);
                let endpoint = slot.endpoint;
                return slot.finish().map(|(status, buffer)| Completion { endpoint, status, buffer });
            }
            let left = deadline.saturating_duration_since(Instant::now());
            // An interrupted wait is tried again until the time is up.
            let _interrupted = self.context.handle_events(Some(left));
            if left.is_zero() && self.slots.iter().all(|slot| slot.end().is_none()) {
                return None;
            }
        }
    }

    fn cancel(&mut self) {
        self.slots.iter().for_each(Slot::cancel);
    }

    fn in_flight(&self) -> usize {
        self.slots.len()
    }

    fn reset(&mut self) -> Result<(), UsbError> {
        self.handle()?.reset().map_err(usb_error)
    }
}

impl Drop for Machine {
    fn drop(&mut self) {
        self.close();
    }
}

/// libusb takes 0 for "no limit", and counts milliseconds.
fn finite(timeout: Duration) -> Duration {
    timeout.max(Duration::from_millis(1))
}

fn listed(device: &Device<Context>) -> Option<Listed> {
    let descriptor = device.device_descriptor().ok()?;
    let ports = device.port_numbers().ok()?;
    let path: Vec<_> = ports.iter().map(u8::to_string).collect();
    let port = format!("{}-{}", device.bus_number(), path.join("."));
    let speed = match device.speed() {
        rusb::Speed::Low | rusb::Speed::Full => Speed::Full,
        rusb::Speed::High => Speed::High,
        rusb::Speed::Super | rusb::Speed::SuperPlus => Speed::Super,
        _ => Speed::Unknown,
    };
    // Linux keeps the string where it can be read without opening the device.
    let serial = std::fs::read_to_string(format!("/sys/bus/usb/devices/{port}/serial")).ok();
    let serial = serial.map(|serial| serial.trim().to_owned());
    Some(Listed { port, vendor: descriptor.vendor_id(), product: descriptor.product_id(), serial, speed })
}
