//! Controls of the extension unit over a transport, every try bounded.

use super::error::CameraError;
use super::plan::Plan;
use crate::transport::{Transport, UsbError};
use meniscus::usb::d4xx::{Command, HARDWARE_MONITOR, MESSAGE, MonitorError};
use meniscus::usb::uvc::request::Setup;
use std::time::Duration;

/// Longest time of one control request.
pub(super) const REQUEST: Duration = Duration::from_secs(1);
/// Longest time of one command with all its tries.
const COMMAND: Duration = Duration::from_secs(3);
/// Pause between two tries.
const PAUSE: Duration = Duration::from_millis(50);

/// Sends a command and gives the message that answers it, at least `needed` bytes of payload inside.
/// A camera that is busy, not ready or stalls is asked again, for three seconds at most.
pub(super) fn ask(
    transport: &mut impl Transport,
    plan: &Plan,
    asked: &'static str,
    command: &Command<'_>,
    needed: usize,
) -> Result<Vec<u8>, CameraError> {
    let deadline = transport.now() + COMMAND;
    loop {
        let failed = match once(transport, plan, command) {
            Ok(message) => match command.answer(&message, needed) {
                Ok(_) => return Ok(message),
                Err(error) => CameraError::Monitor { asked, error },
            },
            Err(error) => CameraError::Usb { doing: "talk to the camera's hardware monitor", error },
        };
        let again = match &failed {
            CameraError::Monitor { error, .. } => error.passes(),
            CameraError::Usb { error, .. } => {
                matches!(error, UsbError::Stall | UsbError::Timeout | UsbError::Io)
            }
            _ => false,
        };
        if !again || transport.now() + PAUSE >= deadline {
            return Err(failed);
        }
        transport.pause(PAUSE);
    }
}

/// Command and answer, with nothing in between.
fn once(transport: &mut impl Transport, plan: &Plan, command: &Command<'_>) -> Result<Vec<u8>, UsbError> {
    send(transport, plan, command)?;
    let mut message = vec![0; MESSAGE];
    let setup = Setup::get_cur(HARDWARE_MONITOR, plan.unit, plan.control);
    let length = transport.control_in(setup, &mut message, REQUEST)?;
    message.truncate(length);
    Ok(message)
}

/// A command that has no answer.
pub(super) fn send(
    transport: &mut impl Transport,
    plan: &Plan,
    command: &Command<'_>,
) -> Result<(), UsbError> {
    let mut message = [0; MESSAGE];
    command.write(&mut message);
    transport.control_out(Setup::set_cur(HARDWARE_MONITOR, plan.unit, plan.control), &message, REQUEST)
}

/// Writes a control of the extension unit, three times at most.
pub(super) fn set(
    transport: &mut impl Transport,
    plan: &Plan,
    doing: &'static str,
    selector: u8,
    bytes: &[u8],
) -> Result<(), CameraError> {
    write(transport, Setup::set_cur(selector, plan.unit, plan.control), doing, bytes)
}

/// Writes a control of the colour imager's camera terminal, if there is one in the plan.
pub(super) fn set_colour(
    transport: &mut impl Transport,
    plan: &Plan,
    selector: u8,
    value: u8,
) -> Result<(), CameraError> {
    let Some(colour) = plan.colour else { return Ok(()) };
    let setup = Setup::set_cur(selector, colour.terminal, colour.control);
    write(transport, setup, "set the colour image's exposure", &[value])
}

fn write(
    transport: &mut impl Transport,
    setup: Setup,
    doing: &'static str,
    bytes: &[u8],
) -> Result<(), CameraError> {
    let mut tried = Ok(());
    for _ in 0..3 {
        tried = transport.control_out(setup, bytes, REQUEST);
        match tried {
            Err(UsbError::Stall | UsbError::Timeout) => transport.pause(PAUSE),
            Ok(()) | Err(_) => break,
        }
    }
    tried.map_err(|error| CameraError::Usb { doing, error })
}

/// The payload of a message that [`ask`] has checked.
pub(super) fn payload<'m>(
    command: &Command<'_>,
    asked: &'static str,
    message: &'m [u8],
) -> Result<&'m [u8], CameraError> {
    command.answer(message, 0).map_err(|error: MonitorError| CameraError::Monitor { asked, error })
}
