//! What leaves the camera side: one postcard frame a turn. `firmware-config/SPEC.md` has the bytes.

use crate::runtime::Estimate;
use crate::units::Micros;
use serde::{Deserialize, Serialize};

/// First byte of every frame: the version of this format.
pub const OUTPUT_VERSION: u8 = 2;

/// Bytes that a frame can take at most: 13 latents, 21 heights, the half-widths of both, the books and
/// the stage times, each at its longest.
pub const OUTPUT_MAX: usize = 640;

/// One frame of output.
///
/// ```
/// # #[repr(align(64))]
/// # struct Aligned<T: ?Sized>(T);
/// # static BLOB: &Aligned<[u8]> =
/// #     &Aligned(*include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/models/glycerine.blob")));
/// # struct NoClock;
/// # impl meniscus::runtime::Clock for NoClock {
/// #     fn now_us(&mut self) -> u64 {
/// #         0
/// #     }
/// # }
/// # let model = meniscus::blob::Model::load(&BLOB.0)?;
/// use meniscus::runtime::output::{OUTPUT_MAX, OUTPUT_VERSION, OutputError, Packet};
/// use meniscus::runtime::{Estimator, Memory, TurnInput};
/// use meniscus::units::Micros;
///
/// let mut memory = Memory::default();
/// let estimate = Estimator::new(&model).turn(&mut memory, TurnInput::default(), &mut NoClock, &mut []);
/// let packet = Packet { version: OUTPUT_VERSION, time: Micros(16_667), sequence: None, estimate };
/// let mut buffer = [0; OUTPUT_MAX];
/// let bytes = packet.write(&mut buffer).expect("OUTPUT_MAX is enough");
/// assert_eq!(Packet::read(bytes), Ok(packet));
/// assert_eq!(Packet::read(&bytes[1..]), Err(OutputError::Malformed));
/// # Ok::<(), meniscus::blob::LoadError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Packet {
    /// [`OUTPUT_VERSION`].
    pub version: u8,
    /// Instant of the turn, in the camera's time.
    pub time: Micros,
    /// The camera's frame counter; `None` where the frame was lost.
    pub sequence: Option<u32>,
    /// What the turn knows.
    pub estimate: Estimate,
}

/// The frame cannot be written or read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutputError {
    /// The buffer is shorter than the frame; [`OUTPUT_MAX`] bytes always do.
    BufferTooSmall,
    /// The bytes are not a frame of this version.
    Malformed,
}

impl Packet {
    /// Writes the frame to the front of `buffer` and gives the part written.
    ///
    /// # Errors
    /// [`OutputError::BufferTooSmall`].
    pub fn write<'b>(&self, buffer: &'b mut [u8]) -> Result<&'b [u8], OutputError> {
        postcard::to_slice(self, buffer).map(|part| &*part).map_err(|_| OutputError::BufferTooSmall)
    }

    /// Reads a frame.
    ///
    /// # Errors
    /// [`OutputError::Malformed`].
    pub fn read(bytes: &[u8]) -> Result<Self, OutputError> {
        let packet: Self = postcard::from_bytes(bytes).map_err(|_| OutputError::Malformed)?;
        (packet.version == OUTPUT_VERSION).then_some(packet).ok_or(OutputError::Malformed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::latent::generic::{Audit, LATENTS};
    use crate::runtime::{Mode, Stages};
    use crate::surface::POINTS;
    use crate::uncertainty::intervals::Interval;

    fn packet() -> Packet {
        let estimate = Estimate {
            mode: Mode::Tracking,
            latent: [-1.25e300; LATENTS],
            surface_m: [0.07; POINTS],
            interval: Interval::default(),
            acceleration_m_s2: 1.0,
            port: 0.5,
            slosh_j: 1e-3,
            heat_j: 1e-4,
            corrected_j: -1e-6,
            audit: Audit { iterations: u32::MAX, ..Audit::default() },
            field_fresh: true,
            stages: Stages { surface_us: u64::MAX, predict_us: u64::MAX, ..Stages::default() },
        };
        Packet { version: OUTPUT_VERSION, time: Micros(u64::MAX), sequence: Some(u32::MAX), estimate }
    }

    #[test]
    fn frames_come_back_and_fit() {
        let mut buffer = [0; OUTPUT_MAX];
        let bytes = packet().write(&mut buffer).expect("OUTPUT_MAX is enough");
        assert_eq!(bytes.first(), Some(&OUTPUT_VERSION));
        assert_eq!(Packet::read(bytes), Ok(packet()));
        assert_eq!(Packet::read(&bytes[..bytes.len() - 1]), Err(OutputError::Malformed));
        let mut short = [0; 64];
        assert_eq!(packet().write(&mut short), Err(OutputError::BufferTooSmall));
    }

    #[test]
    fn another_version_is_refused() {
        let mut buffer = [0; OUTPUT_MAX];
        let mut bytes = packet().write(&mut buffer).expect("fits").to_vec();
        bytes[0] = OUTPUT_VERSION + 1;
        assert_eq!(Packet::read(&bytes), Err(OutputError::Malformed));
    }
}
