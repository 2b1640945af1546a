//! Counters of the camera's transfers and of what was done about trouble.

use serde::Serialize;

/// Everything that went another way than a whole frame in a transfer. What is wrong inside of
/// payloads is counted behind, in [`meniscus::usb::uvc::Losses`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct CameraHealth {
    /// Transfers that brought bytes.
    pub completed: u64,
    /// Whole new frames, both streams.
    pub frames: u64,
    /// Transfers damaged on the wire.
    pub errors: u64,
    /// Transfers that met a halted endpoint.
    pub stalls: u64,
    /// Transfers with more bytes than requested.
    pub overflows: u64,
    /// Transfers that missed a time limit.
    pub timed_out: u64,
    /// Transfers that were cancelled by nobody here.
    pub cancelled: u64,
    /// Transfers that ended because the camera had left.
    pub no_device: u64,
    /// Payloads that repeat a frame.
    pub repeated: u64,
    /// Payloads that are no whole frame, have the error bit or a damaged header.
    pub damaged: u64,
    /// Payloads dropped because no spare buffer was there.
    pub starved: u64,
    /// Payloads thrown away with a cancelled queue.
    pub drained: u64,
    /// Buffers that never came back from the bus.
    pub buffers_lost: u64,
    /// Errors that the camera pushed.
    pub pushed_errors: u64,
    /// Status packets or transfers of the interrupt endpoint that made no sense.
    pub interrupt_errors: u64,
    /// Times that each rung of the ladder was taken, from requeue to re-plug.
    pub rungs: [u64; 5],
}
