//! The open destinations and those who read there.

use super::stream::{Fate, Stream};
use super::{Destination, DestinationError, PublishCounters};
use rustix::fs::{OFlags, fcntl_setfl};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};
use serde::Serialize;
use std::fs::{File, OpenOptions, Permissions};
use std::io::ErrorKind;
use std::net::{SocketAddr, UdpSocket};
use std::os::unix::fs::PermissionsExt;
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// Time that the last records may take to leave when the run is over.
const FAREWELL: Duration = Duration::from_millis(200);

/// Readers of all Unix sockets. Each one holds a descriptor and a buffer; a camera that is plugged in again needs some, too.
pub const READERS_MAX: usize = 32;

/// Line for a reader beyond them. It is no record, as it ends with a newline and not with a zero.
const REFUSAL: &[u8] = b"meniscus: 32 readers are connected, which is the limit; end one of them\n";

/// A socket that others connect to; its file goes with it.
#[derive(Debug)]
struct Door {
    listener: UnixListener,
    path: PathBuf,
}

impl Drop for Door {
    fn drop(&mut self) {
        // A file that has gone already is as good.
        let _ = std::fs::remove_file(&self.path);
    }
}

/// Readers of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Readers {
    /// Unix sockets, UDP and serial lines.
    All,
    /// Unix sockets and UDP: more than a serial line carries at 60 Hz.
    Network,
    /// Unix sockets alone: a full field is too large for a datagram, and for a serial line at 60 Hz.
    Sockets,
}

/// Everything that is open.
#[derive(Debug)]
pub(super) struct Targets {
    doors: Vec<Door>,
    readers: Vec<Stream<UnixStream>>,
    datagrams: Vec<(UdpSocket, SocketAddr)>,
    lines: Vec<Stream<File>>,
    counters: Arc<PublishCounters>,
    buffer: Vec<u8>,
}

impl Targets {
    /// Opens `destinations`.
    pub(super) fn open(
        destinations: &[Destination],
        counters: Arc<PublishCounters>,
    ) -> Result<Self, DestinationError> {
        let (doors, readers, datagrams, lines) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let mut targets = Self { doors, readers, datagrams, lines, counters, buffer: Vec::new() };
        for destination in destinations {
            match destination {
                Destination::Unix(path) => targets.doors.push(door(path)?),
                Destination::Udp(address) => targets.datagrams.push((datagrams_to(*address)?, *address)),
                Destination::Serial(path, baud) => targets.lines.push(Stream::new(line(path, *baud)?)),
            }
        }
        Ok(targets)
    }

    /// Lets those in who knock, as far as there is room.
    pub(super) fn welcome(&mut self) {
        for door in &self.doors {
            // Whoever knocks faster than this waits in the system's queue, and holds up nobody.
            for _ in 0..2 * READERS_MAX {
                let Ok((reader, _)) = door.listener.accept() else { break };
                if reader.set_nonblocking(true).is_err() {
                    continue;
                }
                if self.readers.len() >= READERS_MAX {
                    // One that has gone without a word may still hold a place.
                    self.readers.retain(|reader| !has_gone(reader.writer()));
                }
                if self.readers.len() < READERS_MAX {
                    self.readers.push(Stream::new(reader));
                } else {
                    self.counters.readers_refused.fetch_add(1, Ordering::Relaxed);
                    // Its buffer is empty, so the words fit; one that has gone needs none.
                    let _sent = std::io::Write::write(&mut &reader, REFUSAL);
                }
            }
        }
    }

    /// Sends a record to its readers.
    pub(super) fn send(&mut self, record: &impl Serialize, readers: Readers) {
        let Ok(plain) =
            postcard::serialize_with_flavor::<_, _, usize>(record, postcard::ser_flavors::Size::default())
        else {
            return;
        };
        // COBS adds a byte in 254, one at the front and the zero at the end.
        self.buffer.resize(plain + plain / 254 + 3, 0);
        if readers != Readers::Sockets
            && !self.datagrams.is_empty()
            && let Ok(datagram) = postcard::to_slice(record, &mut self.buffer)
        {
            for (socket, address) in &self.datagrams {
                // Nobody there, or no room: a datagram is allowed to be lost.
                match socket.send_to(datagram, address) {
                    Ok(_) => self.counters.sent.fetch_add(1, Ordering::Relaxed),
                    Err(_) => self.counters.reader_slow.fetch_add(1, Ordering::Relaxed),
                };
            }
        }
        let Ok(stuffed) = postcard::to_slice_cobs(record, &mut self.buffer) else { return };
        let counters = &self.counters;
        let kept = |fate| {
            match fate {
                Fate::Taken => &counters.sent,
                Fate::LeftOut => &counters.reader_slow,
                Fate::Gone => &counters.readers_gone,
            }
            .fetch_add(1, Ordering::Relaxed);
            fate != Fate::Gone
        };
        self.readers.retain_mut(|reader| kept(reader.send(stuffed)));
        if readers == Readers::All {
            self.lines.retain_mut(|line| kept(line.send(stuffed)));
        }
    }

    /// Gives the last records a moment to leave.
    pub(super) fn flush(&mut self) {
        let end = Instant::now() + FAREWELL;
        while Instant::now() < end {
            let readers = self.readers.iter_mut().map(Stream::flush);
            if readers.chain(self.lines.iter_mut().map(Stream::flush)).all(|fate| fate != Fate::LeftOut) {
                return;
            }
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}

/// Whether the peer has closed its end. Readers send nothing, so a read ends at once.
fn has_gone(mut reader: &UnixStream) -> bool {
    matches!(std::io::Read::read(&mut reader, &mut [0; 64]), Ok(0))
}

/// A socket at `path` for its owner and group.
fn door(path: &Path) -> Result<Door, DestinationError> {
    let wrong = |why: &str, remedy: &str| DestinationError::new(path.display().to_string(), why, remedy);
    if UnixStream::connect(path).is_ok() {
        return Err(wrong("another program publishes there", "choose another path or end that program"));
    }
    // A socket that nobody listens to was left behind by a run that was killed; anything else is not ours.
    match std::fs::symlink_metadata(path) {
        Ok(there) if std::os::unix::fs::FileTypeExt::is_socket(&there.file_type()) => {
            std::fs::remove_file(path).map_err(|error| wrong(&error.to_string(), "remove it by hand"))?;
        }
        Ok(_) => return Err(wrong("a file that is no socket lies there", "choose another path")),
        Err(_) => {}
    }
    let refused = |error: std::io::Error| {
        let remedy = match error.kind() {
            ErrorKind::NotFound => "make the folder",
            ErrorKind::PermissionDenied => "choose a folder that you may write to",
            _ => "choose another path",
        };
        wrong(&error.to_string(), remedy)
    };
    let listener = UnixListener::bind(path).map_err(refused)?;
    let door = Door { listener, path: path.to_path_buf() };
    std::fs::set_permissions(path, Permissions::from_mode(0o660)).map_err(refused)?;
    door.listener.set_nonblocking(true).map_err(refused)?;
    Ok(door)
}

/// A socket for datagrams to `address`.
fn datagrams_to(address: SocketAddr) -> Result<UdpSocket, DestinationError> {
    let any: SocketAddr = if address.is_ipv4() { ([0, 0, 0, 0], 0).into() } else { ([0_u16; 8], 0).into() };
    let socket = UdpSocket::bind(any).and_then(|socket| socket.set_nonblocking(true).map(|()| socket));
    socket.map_err(|error| {
        DestinationError::new(address.to_string(), error.to_string(), "check the network of this machine")
    })
}

/// A serial line at `path`, raw, at `baud`.
fn line(path: &Path, baud: u32) -> Result<File, DestinationError> {
    let wrong = |why: &dyn ToString, remedy: &str| {
        DestinationError::new(path.display().to_string(), why.to_string(), remedy)
    };
    // Without O_NONBLOCK the opening itself would wait for a modem's carrier.
    let line =
        OpenOptions::new().read(true).write(true).custom_flags_nonblocking().open(path).map_err(|error| {
            wrong(&error, "check the device and that you are in its group (often dialout)")
        })?;
    let mut settings =
        tcgetattr(&line).map_err(|error| wrong(&error, "name a serial device, such as /dev/ttyUSB0"))?;
    settings.make_raw();
    settings.set_speed(baud).map_err(|error| wrong(&error, "choose a speed that the adapter knows"))?;
    tcsetattr(&line, OptionalActions::Now, &settings)
        .map_err(|error| wrong(&error, "choose a speed that the adapter knows"))?;
    fcntl_setfl(&line, OFlags::NONBLOCK).map_err(|error| wrong(&error, "name a serial device"))?;
    Ok(line)
}

/// Opening without waiting.
trait Nonblocking {
    fn custom_flags_nonblocking(&mut self) -> &mut Self;
}

impl Nonblocking for OpenOptions {
    fn custom_flags_nonblocking(&mut self) -> &mut Self {
        let flags = OFlags::NONBLOCK | OFlags::NOCTTY;
        std::os::unix::fs::OpenOptionsExt::custom_flags(self, flags.bits() as i32)
    }
}
