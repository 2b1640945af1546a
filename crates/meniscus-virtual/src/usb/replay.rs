//! From a dump to a camera that says the same.

use super::SimulatedBus;
use meniscus_hil::device::{ControlExchange, Device, Replay};
use meniscus_usb::camera::{Dump, DumpedFrame};
use meniscus_usb::transport::Speed;

/// A bus in virtual time with a camera that says what a dump says.
#[must_use]
pub fn replay(dump: &Dump) -> SimulatedBus {
    let said = dump.controls.iter().map(|control| {
        let ([value, selector], [index, unit]) = (control.value.to_le_bytes(), control.index.to_le_bytes());
        ControlExchange {
            setup: [control.request_type, control.request, value, selector, index, unit],
            sent: control.sent.clone(),
            answer: control.answer.clone(),
            failed: control.error.is_some(),
        }
    });
    let headers = |frames: &[DumpedFrame]| frames.iter().map(|frame| frame.header.clone()).collect();
    let mut replay = Replay::default();
    (replay.vendor, replay.product) = (dump.vendor, dump.product);
    replay.serial = dump.serial.clone().unwrap_or_default();
    replay.usb2 = dump.speed == Speed::High.to_string();
    replay.headers = [headers(&dump.depth), headers(&dump.infrared)];
    SimulatedBus::new(Device::replaying(replay.saying(said.collect())))
}
