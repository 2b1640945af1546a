//! Capture timing of a frame, from the metadata of its payload header.
//!
//! The D400's blocks carry `version: u32, flags: u32` first in the body; a field without its flag bit has no value.
//! Source: the Linux kernel's `V4L2_META_FMT_D4XX`.

use super::bytes::u32_at;
use super::header::PayloadHeader;

/// Block that holds frame counter, sensor time and exposure.
const CAPTURE_TIMING: u32 = 0x8000_0001;

/// The capture timing of a frame; a field that the camera did not vouch for is `None`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Timing {
    /// The camera's frame counter.
    pub counter: Option<u32>,
    /// Microseconds from mid-exposure to the PTS (half the exposure, in spite of the vendor's name "sensor timestamp").
    pub sensor_us: Option<u32>,
    /// Read-out time, microseconds.
    pub readout_us: Option<u32>,
    /// Exposure, microseconds.
    pub exposure_us: Option<u32>,
    /// Frame interval, microseconds.
    pub interval_us: Option<u32>,
    /// Latency of the camera's own pipeline, microseconds.
    pub latency_us: Option<u32>,
}

impl Timing {
    /// The capture timing in a header's metadata, all `None` if there is none.
    ///
    /// ```
    /// use meniscus::usb::uvc::{PayloadHeader, Timing};
    ///
    /// let mut payload = [0; 2 + 8 + 12];
    /// payload[0] = 22;
    /// // Block 0x80000001 of 20 bytes: version, flags (only the counter is valid), counter 42.
    /// payload[2..10].copy_from_slice(&[1, 0, 0, 0x80, 20, 0, 0, 0]);
    /// payload[14] = 1;
    /// payload[18] = 42;
    /// let (header, _pixels) = PayloadHeader::split(&payload)?;
    /// let timing = Timing::of(&header);
    /// assert_eq!((timing.counter, timing.exposure_us), (Some(42), None));
    /// # Ok::<(), meniscus::usb::uvc::HeaderError>(())
    /// ```
    #[must_use]
    pub fn of(header: &PayloadHeader<'_>) -> Self {
        let block = header.blocks().find(|block| block.id == CAPTURE_TIMING);
        block.map(|block| Self::parse(block.body)).unwrap_or_default()
    }

    /// Body: version 0, flags 4, then one `u32` a field from 8 on, flag bits in the order of the fields.
    fn parse(body: &[u8]) -> Self {
        let flags = u32_at(body, 4).unwrap_or(0);
        let field = |index: usize| {
            let vouched = flags & (1 << index) != 0;
            u32_at(body, 8 + 4 * index).filter(|_| vouched)
        };
        Self {
            counter: field(0),
            sensor_us: field(1),
            readout_us: field(2),
            exposure_us: field(3),
            interval_us: field(4),
            latency_us: field(5),
        }
    }
}
