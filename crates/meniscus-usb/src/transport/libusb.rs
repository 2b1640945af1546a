//! Errors and transfer statuses of libusb as those of the bus.

use super::error::{Status, UsbError};
use rusb::ffi::constants;

/// Error of the bus for an error of libusb.
pub(super) fn usb_error(error: rusb::Error) -> UsbError {
    match error {
        rusb::Error::NoDevice => UsbError::NoDevice,
        rusb::Error::Access => UsbError::Access,
        rusb::Error::Busy => UsbError::Busy,
        rusb::Error::Pipe => UsbError::Stall,
        rusb::Error::Timeout => UsbError::Timeout,
        rusb::Error::Overflow => UsbError::Overflow,
        rusb::Error::Io => UsbError::Io,
        rusb::Error::NotFound => UsbError::NotFound,
        rusb::Error::NoMem => UsbError::NoMemory,
        rusb::Error::InvalidParam => UsbError::Other(-2),
        rusb::Error::Interrupted => UsbError::Other(-10),
        rusb::Error::NotSupported => UsbError::Other(-12),
        rusb::Error::BadDescriptor | rusb::Error::Other => UsbError::Other(-99),
    }
}

/// Error of the bus for libusb's number.
pub(super) fn usb_error_of(number: i32) -> UsbError {
    usb_error(match number {
        constants::LIBUSB_ERROR_NO_DEVICE => rusb::Error::NoDevice,
        constants::LIBUSB_ERROR_BUSY => rusb::Error::Busy,
        constants::LIBUSB_ERROR_NO_MEM => rusb::Error::NoMem,
        constants::LIBUSB_ERROR_IO => rusb::Error::Io,
        constants::LIBUSB_ERROR_NOT_FOUND => rusb::Error::NotFound,
        _ => rusb::Error::Other,
    })
}

/// Status of a transfer by libusb's number.
pub(super) fn transfer_status(status: i32) -> Status {
    match status {
        constants::LIBUSB_TRANSFER_COMPLETED => Status::Completed,
        constants::LIBUSB_TRANSFER_TIMED_OUT => Status::TimedOut,
        constants::LIBUSB_TRANSFER_CANCELLED => Status::Cancelled,
        constants::LIBUSB_TRANSFER_STALL => Status::Stall,
        constants::LIBUSB_TRANSFER_NO_DEVICE => Status::NoDevice,
        constants::LIBUSB_TRANSFER_OVERFLOW => Status::Overflow,
        _ => Status::Error,
    }
}
