//! Video4Linux's requests: the calls on the structures of `layout`.
//!
//! Source: the kernel's user interface, `linux/videodev2.h`. The numbers at the end of this file are those of that header on 64-bit
//! systems.
#![allow(unsafe_code, reason = "requests to a driver are untyped memory; the argument stands at each call")]

use super::layout::{
    Buffer, BufferRequest, CAPTURE, Capability, Control, Format, FormatDescription, FrameInterval, FrameSize,
    StreamParameters,
};
use rustix::fd::{AsFd, BorrowedFd};
use rustix::io::Result;
use rustix::ioctl::{Getter, Setter, Updater, ioctl, opcode};
use rustix::mm::{MapFlags, ProtFlags, mmap, munmap};
use std::ptr::null_mut;

/// Group of all requests.
const V: u8 = b'V';

macro_rules! updating {
    ($(#[$doc:meta])* $name:ident, $type:ty, $number:literal) => {
        $(#[$doc])*
        pub(super) fn $name(fd: BorrowedFd<'_>, value: &mut $type) -> Result<()> {
            // SAFETY: the request with this number reads and writes one `$type` of the kernel's header, whose size and layout
            // `$type` has; it is exclusively borrowed for the call and holds no pointer.
            unsafe { ioctl(fd, Updater::<{ opcode::read_write::<$type>(V, $number) }, $type>::new(value)) }
        }
    };
}

updating!(
    /// VIDIOC_ENUM_FMT.
    enumerate_format,
    FormatDescription,
    2
);
updating!(
    /// VIDIOC_S_FMT.
    set_format,
    Format,
    5
);
updating!(
    /// VIDIOC_REQBUFS.
    request_buffers,
    BufferRequest,
    8
);
updating!(
    /// VIDIOC_QUERYBUF.
    query_buffer,
    Buffer,
    9
);
updating!(
    /// VIDIOC_QBUF.
    queue,
    Buffer,
    15
);
updating!(
    /// VIDIOC_DQBUF.
    dequeue,
    Buffer,
    17
);
updating!(
    /// VIDIOC_S_PARM.
    set_parameters,
    StreamParameters,
    22
);
updating!(
    /// VIDIOC_G_CTRL.
    get_control,
    Control,
    27
);
updating!(
    /// VIDIOC_S_CTRL.
    set_control,
    Control,
    28
);
updating!(
    /// VIDIOC_ENUM_FRAMESIZES.
    enumerate_size,
    FrameSize,
    74
);
updating!(
    /// VIDIOC_ENUM_FRAMEINTERVALS.
    enumerate_interval,
    FrameInterval,
    75
);

/// VIDIOC_QUERYCAP.
pub(super) fn capability(fd: BorrowedFd<'_>) -> Result<Capability> {
    // SAFETY: the request writes one `v4l2_capability`, whose size and layout `Capability` has.
    unsafe { ioctl(fd, Getter::<{ opcode::read::<Capability>(V, 0) }, Capability>::new()) }
}

/// VIDIOC_STREAMON.
pub(super) fn stream_on(fd: BorrowedFd<'_>) -> Result<()> {
    // SAFETY: the request reads one `int`.
    unsafe { ioctl(fd, Setter::<{ opcode::write::<i32>(V, 18) }, i32>::new(CAPTURE as i32)) }
}

/// VIDIOC_STREAMOFF.
pub(super) fn stream_off(fd: BorrowedFd<'_>) -> Result<()> {
    // SAFETY: the request reads one `int`.
    unsafe { ioctl(fd, Setter::<{ opcode::write::<i32>(V, 19) }, i32>::new(CAPTURE as i32)) }
}

/// A buffer of the driver, mapped for reading.
#[derive(Debug)]
pub(super) struct Mapping {
    start: *mut std::ffi::c_void,
    length: usize,
}

// SAFETY: the mapping belongs to the process and to this value alone; no thread owns it.
unsafe impl Send for Mapping {}

impl Mapping {
    /// Maps the buffer that [`query_buffer`] has described.
    pub(super) fn new(fd: impl AsFd, buffer: &Buffer) -> Result<Self> {
        let length = buffer.length as usize;
        // The offset is the lower half of the union, which is the first one on a little-endian machine.
        let offset = u64::from(u32::from_ne_bytes(first_four(buffer.place)));
        // SAFETY: a new mapping at a place of the kernel's choice touches no memory of the program.
        let start = unsafe { mmap(null_mut(), length, ProtFlags::READ, MapFlags::SHARED, fd, offset)? };
        Ok(Self { start, length })
    }

    /// The first `used` bytes. The driver writes here only while the buffer is queued, and the caller looks only while it is not.
    pub(super) fn bytes(&self, used: usize) -> &[u8] {
        // SAFETY: `start` is mapped for reading over `length` bytes until `self` is dropped, and every byte is a `u8`.
        unsafe { std::slice::from_raw_parts(self.start.cast(), used.min(self.length)) }
    }
}

impl Drop for Mapping {
    fn drop(&mut self) {
        // SAFETY: the range was mapped by `new`, and `bytes` lends it no longer than `self` lives.
        let unmapped = unsafe { munmap(self.start, self.length) };
        if let Err(error) = unmapped {
            log::warn!("a buffer of the camera stays mapped: {error}");
        }
    }
}

/// First four bytes of a number in memory.
fn first_four(number: u64) -> [u8; 4] {
    let [a, b, c, d, ..] = number.to_ne_bytes();
    [a, b, c, d]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers as the kernel's header expands them on x86-64 and arm64.
    #[test]
    fn the_requests_have_the_kernels_numbers() {
        assert_eq!(opcode::read::<Capability>(V, 0), 0x8068_5600);
        assert_eq!(opcode::read_write::<FormatDescription>(V, 2), 0xc040_5602);
        assert_eq!(opcode::read_write::<Format>(V, 5), 0xc0d0_5605);
        assert_eq!(opcode::read_write::<BufferRequest>(V, 8), 0xc014_5608);
        assert_eq!(opcode::read_write::<Buffer>(V, 17), 0xc058_5611);
        assert_eq!(opcode::write::<i32>(V, 18), 0x4004_5612);
        assert_eq!(opcode::read_write::<StreamParameters>(V, 22), 0xc0cc_5616);
        assert_eq!(opcode::read_write::<Control>(V, 28), 0xc008_561c);
        assert_eq!(opcode::read_write::<FrameSize>(V, 74), 0xc02c_564a);
        assert_eq!(opcode::read_write::<FrameInterval>(V, 75), 0xc034_564b);
    }
}
