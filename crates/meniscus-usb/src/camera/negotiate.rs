//! Probe and commit of both streams: all are committed before any is started.

use super::error::CameraError;
use super::monitor::REQUEST;
use super::plan::{Plan, StreamPlan};
use crate::transport::{Transport, UsbError};
use meniscus::usb::uvc::request::{COMMIT, PROBE, Setup};
use meniscus::usb::uvc::{PROBE_MAX, Probe, ProbeError};

/// Agrees with the camera on both streams.
pub(super) fn negotiate(transport: &mut impl Transport, plan: &Plan) -> Result<(), CameraError> {
    plan.streams.iter().try_for_each(|stream| {
        let agreed = agree(transport, stream, plan.probe_length)?;
        let setup = Setup::set_cur(COMMIT, 0, stream.interface);
        transport.control_out(setup, agreed.bytes(), REQUEST).map_err(usb("commit the stream's mode"))
    })
}

/// GET_MAX, SET_CUR, GET_CUR; the answer has to be what was asked.
fn agree(transport: &mut impl Transport, stream: &StreamPlan, length: usize) -> Result<Probe, CameraError> {
    let refused = |error: ProbeError| CameraError::Probe { stream: stream.name(), error };
    let most = read(transport, Setup::get_max(PROBE, 0, stream.interface), length)?.map_err(refused)?;
    let asked = most.ask(stream.mode, stream.interval);
    let setup = Setup::set_cur(PROBE, 0, stream.interface);
    transport.control_out(setup, asked.bytes(), REQUEST).map_err(usb("ask the camera for a mode"))?;
    let answer = read(transport, Setup::get_cur(PROBE, 0, stream.interface), length)?.map_err(refused)?;
    answer.agrees(&asked, stream.frame_bytes).map_err(refused)?;
    Ok(answer)
}

fn read(
    transport: &mut impl Transport,
    setup: Setup,
    length: usize,
) -> Result<Result<Probe, ProbeError>, CameraError> {
    let mut bytes = [0; PROBE_MAX];
    let room = &mut bytes[..length.min(PROBE_MAX)];
    let got =
        transport.control_in(setup, room, REQUEST).map_err(usb("read the camera's answer to a mode"))?;
    Ok(Probe::read(room.get(..got).unwrap_or(&[]), length))
}

fn usb(doing: &'static str) -> impl Fn(UsbError) -> CameraError {
    move |error| CameraError::Usb { doing, error }
}
