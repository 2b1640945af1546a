//! Binary frame of one stamped sample of the glass's motion, little-endian.
//!
//! | offset | type | field |
//! |---|---|---|
//! | 0 | 4 bytes | `MNSM` |
//! | 4 | u8 | version, 1 |
//! | 5 | u8 | flags: bit 0 the stamp is of this computer's clock (else of the sender's), bit 1 velocity, bit 2 acceleration follow |
//! | 6 | u16 | 0 |
//! | 8 | u32 | sequence number, which rises by one a frame |
//! | 12 | u64 | stamp, ns: since 1970 UTC, or by the sender's own clock |
//! | 20 | 3 f64 | position, m |
//! | 44 | 3 f64 | velocity, m/s, and then acceleration, m/s2, as far as the flags announce them |

use subtle::ConstantTimeEq;

/// First bytes of a frame.
const MAGIC: [u8; 4] = *b"MNSM";
/// Version of the frames.
pub const MOTION_FRAME_VERSION: u8 = 1;
/// Flags.
const HOST_CLOCK: u8 = 1;
const VELOCITY: u8 = 2;
const ACCELERATION: u8 = 4;
/// Largest magnitudes that are accepted: m, m/s and m/s2, the last twenty times gravity.
const LARGEST: [f64; 3] = [100.0, 20.0, 200.0];

/// Clock of a stamp.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StampClock {
    /// This computer's wall clock.
    Host,
    /// The sender's own.
    Sender,
}

/// Stamped sample of the motion of the glass in three dimensions.
///
/// ```
/// use meniscus_service::commanded_motion::{MotionFrame, StampClock};
///
/// let frame = MotionFrame {
///     clock: StampClock::Sender,
///     sequence: 7,
///     stamp_ns: 1_250_000_000,
///     position_m: [0.1, 0.0, 0.0],
///     velocity_m_s: None,
///     acceleration_m_s2: Some([1.5, 0.0, 0.0]),
/// };
/// let bytes = frame.to_bytes();
/// assert_eq!((&bytes[..4], bytes.len()), (&b"MNSM"[..], 68));
/// assert_eq!(MotionFrame::read(&bytes), Ok(frame));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionFrame {
    /// Clock of the stamp.
    pub clock: StampClock,
    /// Number that rises by one a frame.
    pub sequence: u32,
    /// Instant of the sample, ns.
    pub stamp_ns: u64,
    /// Position of the glass in the sender's axes, m.
    pub position_m: [f64; 3],
    /// Velocity, m/s.
    pub velocity_m_s: Option<[f64; 3]>,
    /// Acceleration, m/s2.
    pub acceleration_m_s2: Option<[f64; 3]>,
}

/// Fault of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameFault {
    /// It has another version.
    Version(u8),
    /// Its length is not that of its flags, or it sets flags that nobody knows.
    Layout,
    /// A number is not finite or beyond what a glass bears.
    Range,
}

impl std::fmt::Display for FrameFault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Version(version) => write!(
                f,
                "it has version {version}, and this program reads version {MOTION_FRAME_VERSION}: update the sender"
            ),
            Self::Layout => f.write_str("its length does not fit its flags: docs/robots.md has the layout"),
            Self::Range => {
                f.write_str("a number is not finite, or above 100 m, 20 m/s or 200 m/s2: check the units")
            }
        }
    }
}

impl MotionFrame {
    /// Returns the frame in `bytes`.
    ///
    /// # Errors
    /// [`FrameFault`].
    pub fn read(bytes: &[u8]) -> Result<Self, FrameFault> {
        let (head, mut rest) = bytes.split_first_chunk::<20>().ok_or(FrameFault::Layout)?;
        let [_, _, _, _, version, flags, ..] = *head;
        if version != MOTION_FRAME_VERSION {
            return Err(FrameFault::Version(version));
        }
        let sequence = u32::from_le_bytes([head[8], head[9], head[10], head[11]]);
        let stamp_ns = u64::from_le_bytes(*head.last_chunk::<8>().ok_or(FrameFault::Layout)?);
        if flags > (HOST_CLOCK | VELOCITY | ACCELERATION) || head[6..8] != [0, 0] {
            return Err(FrameFault::Layout);
        }
        let position_m = vector(&mut rest)?;
        let velocity_m_s = (flags & VELOCITY != 0).then(|| vector(&mut rest)).transpose()?;
        let acceleration_m_s2 = (flags & ACCELERATION != 0).then(|| vector(&mut rest)).transpose()?;
        if !rest.is_empty() {
            return Err(FrameFault::Layout);
        }
        let clock = if flags & HOST_CLOCK != 0 { StampClock::Host } else { StampClock::Sender };
        let frame = Self { clock, sequence, stamp_ns, position_m, velocity_m_s, acceleration_m_s2 };
        frame.check()?;
        Ok(frame)
    }

    /// Refuses numbers that no glass has.
    ///
    /// # Errors
    /// [`FrameFault::Range`].
    pub fn check(&self) -> Result<(), FrameFault> {
        let vectors = [Some(self.position_m), self.velocity_m_s, self.acceleration_m_s2];
        let mut numbers = LARGEST
            .into_iter()
            .zip(vectors)
            .flat_map(|(largest, vector)| vector.into_iter().flatten().map(move |number| (largest, number)));
        // False of what is no number.
        let in_range = numbers.all(|(largest, number)| number.abs() <= largest);
        if in_range { Ok(()) } else { Err(FrameFault::Range) }
    }

    /// Returns the bytes of the frame.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let flag = |set: bool, bit: u8| if set { bit } else { 0 };
        let flags = flag(self.clock == StampClock::Host, HOST_CLOCK)
            | flag(self.velocity_m_s.is_some(), VELOCITY)
            | flag(self.acceleration_m_s2.is_some(), ACCELERATION);
        let mut bytes = MAGIC.to_vec();
        bytes.extend([MOTION_FRAME_VERSION, flags, 0, 0]);
        bytes.extend(self.sequence.to_le_bytes());
        bytes.extend(self.stamp_ns.to_le_bytes());
        let vectors = [Some(self.position_m), self.velocity_m_s, self.acceleration_m_s2];
        vectors.into_iter().flatten().flatten().for_each(|number| bytes.extend(number.to_le_bytes()));
        bytes
    }
}

/// Takes three numbers from the front of `bytes`.
fn vector(bytes: &mut &[u8]) -> Result<[f64; 3], FrameFault> {
    let mut numbers = [0.0; 3];
    for number in &mut numbers {
        let (eight, rest) = bytes.split_first_chunk::<8>().ok_or(FrameFault::Layout)?;
        (*number, *bytes) = (f64::from_le_bytes(*eight), rest);
    }
    Ok(numbers)
}

/// Returns the frame in a datagram without its `token`; `None` where the datagram is no frame or lacks the token.
pub(crate) fn in_datagram<'b>(bytes: &'b [u8], token: Option<&str>, magic: [u8; 4]) -> Option<&'b [u8]> {
    let frame = match token {
        None => bytes,
        Some(token) => {
            let (word, rest) = bytes.split_at_checked(token.len())?;
            let same: bool = word.ct_eq(token.as_bytes()).into();
            rest.strip_prefix(b" ").filter(|_| same)?
        }
    };
    frame.starts_with(&magic).then_some(frame)
}

/// Returns the motion frame in a datagram; `None` where it is of another kind or lacks the token.
pub(super) fn read(bytes: &[u8], token: Option<&str>) -> Option<Result<MotionFrame, FrameFault>> {
    in_datagram(bytes, token, MAGIC).map(MotionFrame::read)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame() -> MotionFrame {
        MotionFrame {
            clock: StampClock::Host,
            sequence: 3,
            stamp_ns: 1_790_000_000_000_000_001,
            position_m: [0.1, -0.2, 0.3],
            velocity_m_s: Some([1.0, 2.0, 3.0]),
            acceleration_m_s2: None,
        }
    }

    #[test]
    fn a_frame_comes_back_and_a_damaged_one_is_named() {
        let bytes = frame().to_bytes();
        assert_eq!(MotionFrame::read(&bytes), Ok(frame()));
        let with = |at: usize, byte: u8| {
            let mut bytes = bytes.clone();
            bytes[at] = byte;
            MotionFrame::read(&bytes)
        };
        assert_eq!(with(4, 2), Err(FrameFault::Version(2)));
        assert_eq!(with(5, 0x80), Err(FrameFault::Layout));
        assert_eq!(with(5, 7), Err(FrameFault::Layout), "an acceleration is announced and lacks");
        assert_eq!(with(27, 0x7f), Err(FrameFault::Range));
        assert_eq!(MotionFrame::read(&bytes[..30]), Err(FrameFault::Layout));
        let nan = MotionFrame { position_m: [f64::NAN; 3], ..frame() };
        assert_eq!(MotionFrame::read(&nan.to_bytes()), Err(FrameFault::Range));
    }

    #[test]
    fn a_token_is_wanted_whole_before_the_frame() {
        let (bytes, token) = (frame().to_bytes(), Some("0123456789abcdef"));
        assert_eq!(read(&bytes, None), Some(Ok(frame())));
        assert_eq!(read(&[b"0123456789abcdef ", &bytes[..]].concat(), token), Some(Ok(frame())));
        for wrong in [&b""[..], b"0123456789abcdeX ", b"0123456789abcdef", b"0123456789abcdef1 "] {
            assert_eq!(read(&[wrong, &bytes[..]].concat(), token), None);
        }
        assert_eq!(read(b"1.25", None), None);
    }
}
