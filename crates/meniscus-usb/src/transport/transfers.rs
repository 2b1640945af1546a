//! Queued transfers over libusb: the one file of `unsafe` for this need.
//!
//! The safe crate has no queued transfers, and a blocking read leaves none queued between two calls,
//! so frames are lost there. The argument for soundness:
//!
//! 1. A [`Slot`] owns its `libusb_transfer`, the bytes of its [`Buffer`] and its [`Flag`] through raw
//!    pointers: all three lie on the heap, do not move when the slot does, and no reference to the bytes
//!    exists while the transfer is in flight.
//! 2. libusb writes to the buffer and to the transfer only between a successful submit and the callback.
//!    The slot reads either only before the submit or after it has seen the flag that the callback sets
//!    with release and the slot reads with acquire.
//! 3. The callback touches nothing but the flag, through a shared reference to atomics. It neither
//!    allocates, frees, panics nor submits; a transfer is never freed inside of a callback.
//! 4. A transfer is freed only when it is not in flight. A slot that is dropped in flight, because its
//!    cancellation did not come back in time, leaks its transfer, buffer, flag and its share of the
//!    handle, so that libusb never meets freed memory and the handle is never closed under a transfer.
//! 5. The context outlives the handle (rusb keeps it inside), the handle outlives the transfers (each
//!    slot has a share).
#![allow(unsafe_code, reason = "libusb's queued transfers are raw pointers; the argument stands above")]

use super::error::{Status, UsbError};
use super::libusb::{transfer_status, usb_error_of};
use super::{NotQueued, Pipe};
use crate::buffer::Buffer;
use rusb::ffi;
use rusb::{Context, DeviceHandle};
use std::mem::ManuallyDrop;
use std::ptr::NonNull;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// The order in which transfers ended: counts up, never 0.
static ENDED: AtomicU64 = AtomicU64::new(0);

/// End of a transfer, written by the callback: 0 in flight, then the transfer's number in the order of ends.
#[derive(Debug, Default)]
struct Flag(AtomicU64);

/// One transfer with all that it needs.
#[derive(Debug)]
pub(super) struct Slot {
    transfer: NonNull<ffi::libusb_transfer>,
    /// From `Box::into_raw`; `None` when the buffer has been taken.
    room: Option<NonNull<[u8]>>,
    /// From `Box::into_raw`.
    flag: NonNull<Flag>,
    /// `ManuallyDrop`, because a slot that is dropped in flight must not let the handle be closed.
    handle: ManuallyDrop<Arc<DeviceHandle<Context>>>,
    /// Its endpoint.
    pub(super) endpoint: u8,
}

// SAFETY: libusb's functions may be called from any thread; a slot has no thread-bound part, and all
// access to it goes through `&mut self` or through the flag's atomics.
unsafe impl Send for Slot {}

/// Runs on the thread that handles events.
extern "system" fn ended(transfer: *mut ffi::libusb_transfer) {
    // SAFETY: libusb calls back with the transfer that was submitted, which is alive by points 1 and 4.
    let flag = unsafe { (*transfer).user_data }.cast::<Flag>();
    // SAFETY: `user_data` is the slot's flag, alive as long as the transfer is in flight (1, 4).
    let flag = unsafe { &*flag };
    flag.0.store(ENDED.fetch_add(1, Ordering::Relaxed) + 1, Ordering::Release);
}

impl Slot {
    /// Queues a read into `buffer`.
    pub(super) fn submit(
        handle: &Arc<DeviceHandle<Context>>,
        pipe: Pipe,
        endpoint: u8,
        buffer: Buffer,
    ) -> Result<Self, NotQueued> {
        let Ok(length) = i32::try_from(buffer.size()) else {
            return Err(NotQueued { error: UsbError::Overflow, buffer });
        };
        // SAFETY: no packets are asked for; a null result is handled.
        let Some(transfer) = NonNull::new(unsafe { ffi::libusb_alloc_transfer(0) }) else {
            return Err(NotQueued { error: UsbError::NoMemory, buffer });
        };
        let room = NonNull::from(Box::leak(buffer.into_room()));
        let flag = NonNull::from(Box::leak(Box::<Flag>::default()));
        let fill = match pipe {
            Pipe::Bulk => ffi::libusb_fill_bulk_transfer,
            Pipe::Interrupt => ffi::libusb_fill_interrupt_transfer,
        };
        let (bytes, user_data) = (room.as_ptr().cast(), flag.as_ptr().cast());
        // SAFETY: the transfer is fresh, `bytes` has `length` bytes, the callback fits; timeout 0 is none.
        unsafe { fill(transfer.as_ptr(), handle.as_raw(), endpoint, bytes, length, ended, user_data, 0) };
        let handle = ManuallyDrop::new(Arc::clone(handle));
        let mut slot = Self { transfer, room: Some(room), flag, handle, endpoint };
        // SAFETY: filled above; everything it points to lives in the slot (1).
        let answer = unsafe { ffi::libusb_submit_transfer(slot.transfer.as_ptr()) };
        if answer == 0 {
            return Ok(slot);
        }
        // It never was in flight: the flag says "ended", so that the slot frees what it has.
        slot.flag().0.store(u64::MAX, Ordering::Release);
        Err(NotQueued { error: usb_error_of(answer), buffer: slot.take_buffer() })
    }

    fn flag(&self) -> &Flag {
        // SAFETY: it is freed in `drop` only, and everybody shares it only by reference (3).
        unsafe { self.flag.as_ref() }
    }

    /// The number of its end, if it has ended.
    pub(super) fn end(&self) -> Option<u64> {
        Some(self.flag().0.load(Ordering::Acquire)).filter(|end| *end != 0)
    }

    /// Asks it to end; its callback still comes.
    pub(super) fn cancel(&self) {
        // SAFETY: the transfer is alive. One that has just ended is answered with an error, which
        // changes nothing: its end is seen by the flag.
        let _answer = unsafe { ffi::libusb_cancel_transfer(self.transfer.as_ptr()) };
    }

    /// Returns the end of the transfer and its buffer with the bytes received; `None`, with all of it leaked, if it has not
    /// ended.
    pub(super) fn finish(mut self) -> Option<(Status, Buffer)> {
        self.end()?;
        // SAFETY: it has ended, so libusb writes to it no more (2).
        let (status, length) =
            unsafe { ((*self.transfer.as_ptr()).status, (*self.transfer.as_ptr()).actual_length) };
        let mut buffer = self.take_buffer();
        buffer.set_filled(usize::try_from(length).unwrap_or(0));
        Some((transfer_status(status), buffer))
    }

    /// The buffer of a transfer that has ended; an empty one if it has not, or the second time.
    fn take_buffer(&mut self) -> Buffer {
        let room = if self.end().is_some() { self.room.take() } else { None };
        // SAFETY: it came from a box (`submit`), is taken once, and libusb is done with it (2).
        room.map_or_else(|| Buffer::new(0), |room| Buffer::from_room(unsafe { Box::from_raw(room.as_ptr()) }))
    }
}

impl Drop for Slot {
    fn drop(&mut self) {
        if self.end().is_none() {
            // In flight: leaked on purpose (4).
            return;
        }
        drop(self.take_buffer());
        // SAFETY: it has ended or never began, and it is freed once, here.
        unsafe { ffi::libusb_free_transfer(self.transfer.as_ptr()) };
        // SAFETY: the transfer that pointed to them is gone, and each is dropped once, here.
        unsafe {
            drop(Box::from_raw(self.flag.as_ptr()));
            ManuallyDrop::drop(&mut self.handle);
        }
    }
}
