//! A video device of this machine's kernel.

use super::layout::{
    BUFFER_DAMAGED, Buffer, BufferRequest, CAN_CAPTURE, CAN_STREAM, CAPTURE, Control, EXPOSURE_AUTO_PRIORITY,
    Format, HAS_DEVICE_CAPS, MMAP, PixFormat, StreamParameters,
};
use super::uapi::Mapping;
use super::{Offers, RatePriority, Video, VideoError, VideoFrame, offers, uapi};
use crate::mode::{Mode, PixelFormat};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fd::{AsFd, BorrowedFd, OwnedFd};
use rustix::fs::{FileType, Mode as Rights, OFlags, fstat};
use rustix::io::Errno;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Buffers of the driver: a frame may wait while the one before is decoded.
const BUFFERS: u32 = 4;
/// A device by its path.
#[derive(Debug)]
pub struct Machine {
    path: PathBuf,
    device: Option<OwnedFd>,
    buffers: Vec<Mapping>,
    /// Buffer that was lent with the last frame.
    lent: Option<u32>,
    bytes_per_row: usize,
    started: Instant,
}

impl Machine {
    /// The device at `path`, closed.
    #[must_use]
    pub fn new(path: PathBuf) -> Self {
        Self {
            path,
            device: None,
            buffers: Vec::new(),
            lent: None,
            bytes_per_row: 0,
            started: Instant::now(),
        }
    }

    fn fd(&self) -> Result<BorrowedFd<'_>, VideoError> {
        self.device.as_ref().map(AsFd::as_fd).ok_or(VideoError::Gone)
    }

    /// Gives the lent buffer back to the driver.
    fn give_back(&mut self) -> Result<(), VideoError> {
        let Some(index) = self.lent.take() else { return Ok(()) };
        let mut buffer = Buffer { index, kind: CAPTURE, memory: MMAP, ..Buffer::default() };
        uapi::queue(self.fd()?, &mut buffer).map_err(refused("give a buffer back to the camera"))
    }
}

/// Returns what an error of the system stands for.
fn refused(doing: &'static str) -> impl Fn(Errno) -> VideoError {
    move |error| match error {
        Errno::NOENT | Errno::NXIO => VideoError::NotThere,
        Errno::ACCESS | Errno::PERM => VideoError::NoAccess,
        Errno::BUSY => VideoError::Busy,
        Errno::NOSPC => VideoError::NoBandwidth,
        Errno::NODEV => VideoError::Gone,
        Errno::NOTTY => VideoError::NotCapture,
        error => VideoError::System { doing, code: error.raw_os_error() },
    }
}

impl Video for Machine {
    fn open(&mut self) -> Result<String, VideoError> {
        self.close();
        let flags = OFlags::RDWR | OFlags::CLOEXEC | OFlags::NONBLOCK;
        let device = rustix::fs::open(&self.path, flags, Rights::empty()).map_err(|error| match error {
            // A camera that was unplugged an instant ago.
            Errno::NODEV => VideoError::NotThere,
            Errno::ISDIR => VideoError::NotCapture,
            error => refused("open it")(error),
        })?;
        let kind = fstat(&device).map_err(refused("look at it"))?.st_mode;
        if FileType::from_raw_mode(kind) != FileType::CharacterDevice {
            return Err(VideoError::NotCapture);
        }
        let capability = uapi::capability(device.as_fd()).map_err(refused("ask what it is"))?;
        let can = if capability.capabilities & HAS_DEVICE_CAPS == 0 {
            capability.capabilities
        } else {
            capability.device_caps
        };
        if can & CAN_CAPTURE == 0 || can & CAN_STREAM == 0 {
            return Err(VideoError::NotCapture);
        }
        self.device = Some(device);
        let name: Vec<u8> = capability.card.into_iter().take_while(|byte| *byte != 0).collect();
        // The name is the device's own, and a terminal would carry out what is written there.
        Ok(String::from_utf8_lossy(&name).chars().filter(|sign| !sign.is_control()).collect())
    }

    fn offers(&mut self) -> Result<Offers, VideoError> {
        Ok(offers::of(self.fd()?))
    }

    fn set(&mut self, mode: Mode) -> Result<Result<Mode, [u8; 4]>, VideoError> {
        let [width, height] = mode.size.map(u32::from);
        let pixel_format = u32::from_le_bytes(mode.format.code());
        let mut format = Format::of(PixFormat { width, height, pixel_format, ..PixFormat::default() });
        uapi::set_format(self.fd()?, &mut format).map_err(refused("set the size of its images"))?;
        let got = format.pix;
        let Some(same) =
            PixelFormat::ALL.into_iter().find(|one| u32::from_le_bytes(one.code()) == got.pixel_format)
        else {
            return Ok(Err(got.pixel_format.to_le_bytes()));
        };
        self.bytes_per_row = got.bytes_per_line as usize;
        let mut parameters = StreamParameters::of(mode.interval);
        let interval = match uapi::set_parameters(self.fd()?, &mut parameters) {
            Ok(()) => parameters.interval,
            // A driver with one rate has no such request.
            Err(Errno::NOTTY | Errno::INVAL) => mode.interval,
            Err(error) => return Err(refused("set its rate")(error)),
        };
        let size = [got.width, got.height].map(|pixels| u16::try_from(pixels).unwrap_or(0));
        Ok(Ok(Mode { format: same, size, interval }))
    }

    fn hold_rate(&mut self) -> RatePriority {
        let Ok(fd) = self.fd() else { return RatePriority::Unknown };
        let mut control = Control { id: EXPOSURE_AUTO_PRIORITY, value: 0 };
        if uapi::get_control(fd, &mut control).is_err() {
            return RatePriority::Unknown;
        }
        if control.value == 0 {
            return RatePriority::Held;
        }
        control.value = 0;
        match uapi::set_control(fd, &mut control) {
            Ok(()) => RatePriority::Held,
            Err(_) => RatePriority::MayFall,
        }
    }

    fn start(&mut self) -> Result<(), VideoError> {
        let mut request =
            BufferRequest { count: BUFFERS, kind: CAPTURE, memory: MMAP, ..BufferRequest::default() };
        uapi::request_buffers(self.fd()?, &mut request).map_err(refused("get buffers"))?;
        for index in 0..request.count {
            let mut buffer = Buffer { index, kind: CAPTURE, memory: MMAP, ..Buffer::default() };
            uapi::query_buffer(self.fd()?, &mut buffer).map_err(refused("find a buffer"))?;
            let mapping = Mapping::new(self.fd()?, &buffer).map_err(refused("map a buffer"))?;
            self.buffers.push(mapping);
            uapi::queue(self.fd()?, &mut buffer).map_err(refused("queue a buffer"))?;
        }
        uapi::stream_on(self.fd()?).map_err(refused("start the stream"))
    }

    fn next(&mut self, limit: Duration) -> Result<Option<VideoFrame<'_>>, VideoError> {
        self.give_back()?;
        let fd = self.fd()?;
        let mut waited = [PollFd::new(&fd, PollFlags::IN)];
        let limit = Timespec { tv_sec: limit.as_secs() as i64, tv_nsec: i64::from(limit.subsec_nanos()) };
        match poll(&mut waited, Some(&limit)) {
            Ok(0) | Err(Errno::INTR) => return Ok(None),
            Ok(_) => {}
            Err(error) => return Err(refused("wait for an image")(error)),
        }
        let mut buffer = Buffer { kind: CAPTURE, memory: MMAP, ..Buffer::default() };
        match uapi::dequeue(fd, &mut buffer) {
            Ok(()) => {}
            Err(Errno::AGAIN | Errno::INTR) => return Ok(None),
            Err(error) => return Err(refused("take an image")(error)),
        }
        self.lent = Some(buffer.index);
        let (bytes_per_row, [seconds, micros]) = (self.bytes_per_row, buffer.timestamp);
        let captured_us =
            u64::try_from(seconds.saturating_mul(1_000_000).saturating_add(micros)).unwrap_or(0);
        let used = buffer.bytes_used as usize;
        let bytes = self.buffers.get(buffer.index as usize).map_or(&[][..], |mapping| mapping.bytes(used));
        let damaged = buffer.flags & BUFFER_DAMAGED != 0;
        Ok(Some(VideoFrame { bytes, bytes_per_row, captured_us, sequence: buffer.sequence, damaged }))
    }

    fn stop(&mut self) {
        if let Ok(fd) = self.fd() {
            // A camera that has gone streams no more.
            let _stopped = uapi::stream_off(fd);
        }
        self.buffers.clear();
        self.lent = None;
        if let Ok(fd) = self.fd() {
            let mut none = BufferRequest { kind: CAPTURE, memory: MMAP, ..BufferRequest::default() };
            let _freed = uapi::request_buffers(fd, &mut none);
        }
    }

    fn close(&mut self) {
        if self.device.is_some() {
            self.stop();
        }
        self.device = None;
    }

    fn now(&self) -> Duration {
        self.started.elapsed()
    }

    fn pause(&mut self, time: Duration) {
        std::thread::sleep(time);
    }
}

impl Drop for Machine {
    fn drop(&mut self) {
        self.close();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_camera_is_refused_by_its_kind() {
        let open = |path: &str| Machine::new(path.into()).open();
        assert_eq!(open("/dev/video-that-is-not-there"), Err(VideoError::NotThere));
        assert_eq!(open("/dev"), Err(VideoError::NotCapture), "a folder");
        assert_eq!(open("/dev/null"), Err(VideoError::NotCapture), "a device that knows no such request");
    }
}
