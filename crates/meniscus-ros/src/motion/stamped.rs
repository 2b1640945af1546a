//! A stamped sample of the motion, as messages give it.

use crate::message::Header;
use meniscus_service::commanded_motion::{MotionFrame, SampleFault, StampClock};

/// A stamped sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sample {
    pub(super) stamp_ns: u64,
    pub(super) position_m: [f64; 3],
    pub(super) velocity_m_s: Option<[f64; 3]>,
    pub(super) acceleration_m_s2: Option<[f64; 3]>,
}

/// Receiver of samples and faults.
pub(super) type Give<'g> = &'g mut dyn FnMut(Result<Sample, SampleFault>);

impl Sample {
    /// Returns a sample of a position alone.
    pub(super) fn at(header: &Header, position_m: [f64; 3]) -> Result<Self, SampleFault> {
        let stamp_ns = stamp_ns(header)?;
        Ok(Self { stamp_ns, position_m, velocity_m_s: None, acceleration_m_s2: None })
    }

    /// Returns the sample as the source takes it.
    pub(super) fn frame(self, clock: StampClock, sequence: u32) -> MotionFrame {
        let Self { stamp_ns, position_m, velocity_m_s, acceleration_m_s2 } = self;
        MotionFrame { clock, sequence, stamp_ns, position_m, velocity_m_s, acceleration_m_s2 }
    }
}

/// Returns the stamp of a header; one of zero is refused.
pub(super) fn stamp_ns(header: &Header) -> Result<u64, SampleFault> {
    match header.stamp.unix_ns() {
        Some(0) => Err(SampleFault::Unstamped),
        Some(stamp_ns) => Ok(stamp_ns),
        None => {
            Err(SampleFault::Malformed("its stamp is before 1970, or its nanoseconds are a second".into()))
        }
    }
}
