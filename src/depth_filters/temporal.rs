//! The temporal filter on Z16: each pixel against its own past. It blurs what moves, by design: do not
//! put it before a moving liquid.
//!
//! Per pixel there are the last value and eight bits of history, one a frame modulo 8.
//!
//! | pixel `c`, last `l` | |
//! |---|---|
//! | valid, none | `l = c`, the history begins |
//! | valid, `abs(c - l) < delta` | `l = trunc(alpha c + (1 - alpha) l)`, given out; the frame's bit is set |
//! | valid, otherwise | `l = c`, the history begins again |
//! | hole | `l` is given out if the history is persistent enough; the frame's bit is cleared |
//!
//! Source: librealsense 2.56.5, temporal filter, as measured.

use super::{SizeError, check};

/// Number of valid frames after which the last value of a pixel stands in for a hole.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Persistence {
    /// Never.
    Disabled,
    /// In all of the last 8 frames.
    In8Of8,
    /// In 2 of the last 3.
    In2Of3,
    /// In 2 of the last 4.
    #[default]
    In2Of4,
    /// In 2 of the last 8.
    In2Of8,
    /// In 1 of the last 2.
    In1Of2,
    /// In 1 of the last 5.
    In1Of5,
    /// In 1 of the last 8.
    In1Of8,
    /// Always.
    Always,
}

impl Persistence {
    /// Returns whether `seen`, newest frame in the highest bit, is enough.
    fn holds(self, seen: u8) -> bool {
        let of = |frames: u32, least: u32| (seen >> (8 - frames)).count_ones() >= least;
        match self {
            Self::Disabled => false,
            Self::In8Of8 => of(8, 8),
            Self::In2Of3 => of(3, 2),
            Self::In2Of4 => of(4, 2),
            Self::In2Of8 => of(8, 2),
            Self::In1Of2 => of(2, 1),
            Self::In1Of5 => of(5, 1),
            Self::In1Of8 => of(8, 1),
            Self::Always => true,
        }
    }
}

/// Settings of the filter; [`Temporal::default`] are the library's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Temporal {
    /// Share of the new value, 0 to 1.
    pub alpha: f32,
    /// Differences below this are smoothed, depth units, 1 to 100.
    pub delta: u16,
    /// Condition for filling a hole.
    pub persistence: Persistence,
}

impl Default for Temporal {
    fn default() -> Self {
        Self { alpha: 0.4, delta: 20, persistence: Persistence::default() }
    }
}

/// The filter's memory, in the caller's buffers: last values and histories, zero at the start.
///
/// ```
/// use meniscus::depth_filters::{Temporal, TemporalState};
///
/// let (mut last, mut history) = ([0; 1], [0; 1]);
/// let mut state = TemporalState::new(&mut last, &mut history);
/// let filter = Temporal::default();
/// let mut frame = [400];
/// filter.apply(&mut frame, &mut state)?;
/// frame = [410];
/// filter.apply(&mut frame, &mut state)?;
/// // 0.4 of the new value and 0.6 of the old one.
/// assert_eq!(frame, [404]);
/// # Ok::<(), meniscus::depth_filters::SizeError>(())
/// ```
#[derive(Debug)]
pub struct TemporalState<'b> {
    last: &'b mut [u16],
    history: &'b mut [u8],
    frame: u32,
}

impl<'b> TemporalState<'b> {
    /// A memory for images of as many pixels as both buffers have elements; they are cleared.
    pub fn new(last: &'b mut [u16], history: &'b mut [u8]) -> Self {
        last.fill(0);
        history.fill(0);
        Self { last, history, frame: 0 }
    }
}

impl Temporal {
    /// Filters the next image in place.
    ///
    /// # Errors
    /// [`SizeError`] if the memory is not of the image's size; nothing is changed then.
    pub fn apply(&self, image: &mut [u16], state: &mut TemporalState<'_>) -> Result<(), SizeError> {
        check("memory of last values", state.last.len(), image.len(), false)?;
        check("memory of histories", state.history.len(), image.len(), false)?;
        let phase = state.frame % 8;
        let bit = 1_u8 << phase;
        for ((pixel, last), history) in image.iter_mut().zip(&mut *state.last).zip(&mut *state.history) {
            match (*pixel, *last) {
                (0, 0) => *history &= !bit,
                (0, kept) => {
                    // The bit of this frame still tells of the one eight frames ago.
                    if self.persistence.holds(history.rotate_right(phase)) {
                        *pixel = kept;
                    }
                    *history &= !bit;
                }
                (c, l) if l != 0 && c.abs_diff(l) < self.delta => {
                    let mixed = self.alpha * f32::from(c) + (1.0 - self.alpha) * f32::from(l);
                    (*pixel, *last) = (mixed as u16, mixed as u16);
                    *history |= bit;
                }
                (c, _) => (*last, *history) = (c, bit),
            }
        }
        state.frame = state.frame.wrapping_add(1);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs one pixel through frames.
    fn pixel<const N: usize>(settings: Temporal, frames: [u16; N]) -> [u16; N] {
        let (mut last, mut history) = ([9], [9]);
        let mut state = TemporalState::new(&mut last, &mut history);
        frames.map(|z| {
            let mut image = [z];
            settings.apply(&mut image, &mut state).expect("one pixel");
            image[0]
        })
    }

    #[test]
    fn near_values_are_mixed_and_far_ones_begin_again() {
        // 0.4 * 1010 + 0.6 * 1000 = 1004, truncated; 1100 is too far away.
        assert_eq!(pixel(Temporal::default(), [1000, 1010, 1100, 1100]), [1000, 1004, 1100, 1100]);
    }

    #[test]
    fn holes_are_filled_as_long_as_the_history_persists() {
        let with = |persistence| Temporal { persistence, ..Temporal::default() };
        // Seen twice, then gone: two of the last four holds for two more frames.
        let frames = [500, 500, 0, 0, 0, 0];
        assert_eq!(pixel(with(Persistence::In2Of4), frames), [500, 500, 500, 500, 500, 0]);
        assert_eq!(pixel(with(Persistence::In1Of2), frames), [500, 500, 500, 500, 0, 0]);
        assert_eq!(pixel(with(Persistence::Disabled), frames), [500, 500, 0, 0, 0, 0]);
        assert_eq!(pixel(with(Persistence::Always), frames), [500; 6]);
        let mut long = [0; 10];
        long[..8].fill(500);
        assert_eq!(pixel(with(Persistence::In8Of8), long)[8..], [500, 0]);
    }
}
