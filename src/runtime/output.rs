//! Output packet of a turn: one postcard record. `firmware-config/SPEC.md` has the bytes.

use crate::blob::{Header, KnownGroups};
use crate::runtime::{Estimate, Turn};
use crate::units::Micros;
use serde::{Deserialize, Serialize};

/// First byte of every packet: the version of this format.
pub const OUTPUT_VERSION: u8 = 3;

/// Largest packet, bytes: every variable-length number at its longest.
pub const OUTPUT_MAX: usize = 848;

/// One packet of output.
///
/// ```
/// # #[repr(C, align(64))]
/// # struct Aligned<T: ?Sized>(T);
/// # static BLOB: &Aligned<[u8]> =
/// #     &Aligned(*include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/models/glycerine.blob")));
/// # struct NoClock;
/// # impl meniscus::runtime::Clock for NoClock {
/// #     fn now_us(&mut self) -> u64 { 0 }
/// # }
/// use meniscus::blob::Model;
/// use meniscus::runtime::output::{OUTPUT_MAX, Packet};
/// use meniscus::runtime::{Estimator, Memory, Turn, TurnInput};
/// use meniscus::units::Micros;
///
/// let model = Model::load(&BLOB.0)?;
/// let mut memory = Memory::default();
/// let estimate = Estimator::new(&model).turn(&mut memory, TurnInput::default(), &mut NoClock, &mut []);
/// let turn = Turn { time: Micros(16_667), stamp: None, profile: None, estimate };
///
/// // The seventh packet of this run, from a board that has no clock beside the camera's.
/// let packet = Packet::of(&turn, 6, &model.header);
/// let mut buffer = [0; OUTPUT_MAX];
/// let bytes = packet.write(&mut buffer).expect("OUTPUT_MAX is enough");
/// assert_eq!(Packet::read(bytes), Ok(packet));
/// assert!(packet.host.is_none() && packet.sequence.is_none());
/// # Ok::<(), meniscus::blob::LoadError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Packet {
    /// [`OUTPUT_VERSION`].
    pub version: u8,
    /// Number of the packet since the start of the run, from 0 without gaps: a gap at a reader is a lost packet.
    pub number: u64,
    /// Instant of the turn on the camera's clock.
    pub time: Micros,
    /// Frame counter of the camera; `None` where the frame was lost.
    pub sequence: Option<u32>,
    /// The same instant on the host's clock; `None` on a board without a clock of its own.
    pub host: Option<HostTime>,
    /// Version of the model, from the blob: it grows with every correction.
    pub model_version: u64,
    /// Field groups that the model is valid for. The others belong to another liquid.
    pub known: KnownGroups,
    /// Result of the turn.
    pub estimate: Estimate,
}

/// An instant of the camera on the host's clock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct HostTime {
    /// Nanoseconds since 1970-01-01 00:00 UTC.
    pub unix_ns: u64,
    /// Standard deviation of `unix_ns`, nanoseconds: what is not known of the offset between the two clocks.
    pub std_ns: u64,
    /// Time from this instant to the end of its turn and, in a packet, to publishing, microseconds.
    pub latency_us: u64,
}

/// Refusal to write or read a packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutputError {
    /// The buffer is shorter than the packet; [`OUTPUT_MAX`] bytes are always enough.
    BufferTooSmall,
    /// The bytes are not a packet of this version.
    Malformed,
}

impl Packet {
    /// Returns packet `number` of a run for `turn` with the model of `header`, without host time. What the model does not know
    /// is not a number ([`Estimate::known_only`]).
    #[must_use]
    pub fn of(turn: &Turn, number: u64, header: &Header) -> Self {
        Self {
            version: OUTPUT_VERSION,
            number,
            time: turn.time,
            sequence: turn.stamp.map(|stamp| stamp.sequence),
            host: None,
            model_version: header.model_version,
            known: header.known(),
            estimate: turn.estimate.known_only(header.known()),
        }
    }

    /// Writes the packet to the front of `buffer`. Returns the written part.
    ///
    /// # Errors
    /// [`OutputError::BufferTooSmall`].
    pub fn write<'b>(&self, buffer: &'b mut [u8]) -> Result<&'b [u8], OutputError> {
        postcard::to_slice(self, buffer).map(|part| &*part).map_err(|_| OutputError::BufferTooSmall)
    }

    /// Returns the packet in `bytes`.
    ///
    /// # Errors
    /// [`OutputError::Malformed`].
    pub fn read(bytes: &[u8]) -> Result<Self, OutputError> {
        // The first byte is checked first: another version has another layout behind it.
        if bytes.first() != Some(&OUTPUT_VERSION) {
            return Err(OutputError::Malformed);
        }
        postcard::from_bytes(bytes).map_err(|_| OutputError::Malformed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::latent::generic::{Audit, LATENTS};
    use crate::runtime::{Mode, Stages};
    use crate::surface::POINTS;
    use crate::uncertainty::intervals::Interval;
    use crate::uncertainty::latent_covariance::LatentCovariance;

    /// A packet whose variable-length numbers all have their longest form.
    fn packet() -> Packet {
        let estimate = Estimate {
            mode: Mode::Tracking,
            latent: [-1.25e300; LATENTS],
            covariance: LatentCovariance::from_fn(|row, column| (row + column) as f32),
            surface_m: [0.07; POINTS],
            interval: Interval::default(),
            acceleration_m_s2: 1.0,
            port: 0.5,
            slosh_j: 1e-3,
            heat_j: 1e-4,
            corrected_j: -1e-6,
            audit: Audit { iterations: u32::MAX, ..Audit::default() },
            field_fresh: true,
            stages: Stages {
                surface_us: u64::MAX,
                predict_us: u64::MAX,
                encode_us: u64::MAX,
                correct_us: u64::MAX,
                field_us: u64::MAX,
            },
        };
        Packet {
            version: OUTPUT_VERSION,
            number: u64::MAX,
            time: Micros(u64::MAX),
            sequence: Some(u32::MAX),
            host: Some(HostTime { unix_ns: u64::MAX, std_ns: u64::MAX, latency_us: u64::MAX }),
            model_version: u64::MAX,
            known: KnownGroups::ALL,
            estimate,
        }
    }

    #[test]
    fn packets_come_back_and_the_largest_fits() {
        let mut buffer = [0; OUTPUT_MAX];
        let bytes = packet().write(&mut buffer).expect("OUTPUT_MAX is enough");
        assert_eq!(bytes.first(), Some(&OUTPUT_VERSION));
        assert!(bytes.len() + 16 > OUTPUT_MAX, "the room is close to the {} bytes needed", bytes.len());
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
        assert_eq!(Packet::read(&[]), Err(OutputError::Malformed));
    }
}
