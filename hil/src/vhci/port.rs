//! The kernel's side of a port: is it free, is the module there, here is a socket.

use std::fmt;
use std::fs;
use std::io;
use std::os::fd::AsRawFd;
use std::os::unix::net::UnixStream;
use std::time::{Duration, Instant};

/// The virtual host controller.
const CONTROLLER: &str = "/sys/devices/platform/vhci_hcd.0";
/// Bus 1, device 2: any name that is not 0.
const DEVICE: u32 = 65538;
/// Status code of a free port.
const FREE: u32 = 4;
/// Time that a port has to become free after its device has left.
const LIMIT: Duration = Duration::from_secs(3);

/// Why there is no port.
#[derive(Debug)]
pub enum PortError {
    /// The module is missing, or this user may not use it.
    NoController(io::Error),
    /// No port for this speed is free.
    NoneFree(&'static str),
    /// The kernel does not take the socket.
    Refused(io::Error),
}

impl fmt::Display for PortError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoController(error) => {
                write!(
                    f,
                    "{CONTROLLER} cannot be used ({error}): load the module (modprobe vhci-hcd), and be root"
                )
            }
            Self::NoneFree(speed) => {
                write!(f, "no {speed} port of {CONTROLLER} is free: detach what is attached there")
            }
            Self::Refused(error) => write!(f, "{CONTROLLER}/attach does not take the camera: {error}"),
        }
    }
}

impl std::error::Error for PortError {}

/// The first port of a speed in a `status` text that is free.
fn free_port(status: &str, usb2: bool) -> Option<u32> {
    let wanted = if usb2 { "hs" } else { "ss" };
    status.lines().find_map(|line| {
        let mut words = line.split_whitespace();
        let (hub, port, state) = (words.next()?, words.next()?, words.next()?);
        let free = state.parse() == Ok(FREE);
        port.parse().ok().filter(|_| hub == wanted && free)
    })
}

/// Whether every port is free.
pub(super) fn all_free() -> Result<bool, PortError> {
    let status = fs::read_to_string(format!("{CONTROLLER}/status")).map_err(PortError::NoController)?;
    let ports = status.lines().skip(1).filter_map(|line| line.split_whitespace().nth(2));
    Ok(ports.filter(|state| state.parse() != Ok(FREE)).count() == 0)
}

/// Attaches a device at the first free port of its speed; the other end of its socket comes back.
pub(super) fn attach(usb2: bool) -> Result<UnixStream, PortError> {
    let begun = Instant::now();
    let port = loop {
        let status = fs::read_to_string(format!("{CONTROLLER}/status")).map_err(PortError::NoController)?;
        // The port that was left last is free a little later; taking another one would be another plug.
        match free_port(&status, usb2) {
            Some(port) if all_free()? || begun.elapsed() >= LIMIT => break port,
            None if begun.elapsed() >= LIMIT => {
                return Err(PortError::NoneFree(if usb2 { "USB 2" } else { "USB 3" }));
            }
            _ => std::thread::sleep(Duration::from_millis(1)),
        }
    };
    let (ours, kernels) = UnixStream::pair().map_err(PortError::Refused)?;
    let speed = if usb2 { 3 } else { 5 };
    let line = format!("{port} {} {DEVICE} {speed}", kernels.as_raw_fd());
    fs::write(format!("{CONTROLLER}/attach"), line).map_err(PortError::Refused)?;
    // The kernel has its own share of the socket now.
    Ok(ours)
}

#[cfg(test)]
mod tests {
    use super::*;

    const STATUS: &str = "hub port sta spd dev      sockfd local_busid\n\
                          hs  0000 006 003 00010002 000003 1-2\n\
                          hs  0001 004 000 00000000 000000 0-0\n\
                          ss  0015 004 000 00000000 000000 0-0\n";

    #[test]
    fn the_first_free_port_of_the_speed_is_found() {
        assert_eq!(free_port(STATUS, true), Some(1));
        assert_eq!(free_port(STATUS, false), Some(15));
        assert_eq!(free_port("hub port sta\nss 0015 006", false), None);
    }
}
