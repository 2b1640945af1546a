//! The last 16 frames as the encoder reads them, evenly spaced in time.
//!
//! A frame that was lost takes its place as a row of "not seen", so that the spacing stays even.

use crate::surface::{POINTS, SurfaceProfile};
use heapless::Deque;

/// Frames in a window (paper: 16).
pub const WINDOW: usize = 16;

/// Numbers of one frame: height and validity of each point, then the acceleration of the glass.
///
/// The paper gives position and height of each point; the positions are equally spaced by
/// construction and carry nothing, while "was it seen" does, so validity takes their place.
pub const FEATURES: usize = 2 * POINTS + 1;

/// One frame as the encoder reads it.
pub type Row = [f32; FEATURES];

/// Scales that turn metres and metres per second squared into numbers of order one; from the blob.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// Height of the surface at rest, m.
    pub fill_m: f32,
    /// A feature of one is this far above rest, m.
    pub height_m: f32,
    /// A feature of one is this acceleration, m/s2.
    pub acceleration_m_s2: f32,
}

impl Scale {
    /// The row of a frame: its profile (if the surface was seen) and the glass acceleration.
    ///
    /// ```
    /// use meniscus::latent::window::Scale;
    ///
    /// let scale = Scale { fill_m: 0.07, height_m: 0.01, acceleration_m_s2: 2.0 };
    /// // A lost frame: no point was seen, the acceleration is known.
    /// let row = scale.row(None, 1.0);
    /// assert_eq!((row[0], row[1], row[42]), (0.0, 0.0, 0.5));
    /// ```
    #[must_use]
    pub fn row(&self, profile: Option<&SurfaceProfile>, acceleration_m_s2: f32) -> Row {
        let mut row = [0.0; FEATURES];
        if let Some(profile) = profile {
            let seen = profile.height_m.iter().zip(&profile.valid);
            for (pair, (height, &valid)) in row.as_chunks_mut::<2>().0.iter_mut().zip(seen) {
                if valid {
                    *pair = [(height - self.fill_m) / self.height_m, 1.0];
                }
            }
        }
        if let Some(last) = row.last_mut() {
            *last = acceleration_m_s2 / self.acceleration_m_s2;
        }
        row
    }
}

/// Ring of the last [`WINDOW`] rows.
///
/// ```
/// use meniscus::latent::window::{FEATURES, WINDOW, Window};
///
/// let mut window = Window::new();
/// for frame in 0..20 {
///     window.push([frame as f32; FEATURES]);
/// }
/// // The oldest four of twenty rows fell out.
/// assert!(window.is_full());
/// assert_eq!(window.rows().next().map(|row| row[0]), Some(4.0));
/// assert_eq!(window.rows().count(), WINDOW);
/// ```
#[derive(Clone, Debug, Default)]
pub struct Window {
    rows: Deque<Row, WINDOW>,
}

impl Window {
    /// An empty window.
    #[must_use]
    pub const fn new() -> Self {
        Self { rows: Deque::new() }
    }

    /// Appends the newest row; the oldest falls out.
    pub fn push(&mut self, row: Row) {
        if self.rows.is_full() {
            self.rows.pop_front();
        }
        // Cannot fail: there is room now.
        let _room = self.rows.push_back(row);
    }

    /// Returns whether it holds [`WINDOW`] rows, seen or not.
    #[must_use]
    pub fn is_full(&self) -> bool {
        self.rows.is_full()
    }

    /// Returns the number of rows in which the surface was measured.
    #[must_use]
    pub fn measured_rows(&self) -> usize {
        let seen = |row: &&Row| row.iter().skip(1).step_by(2).any(|&valid| valid > 0.0);
        self.rows.iter().filter(seen).count()
    }

    /// Forgets every row.
    pub fn clear(&mut self) {
        self.rows.clear();
    }

    /// The rows, oldest first.
    pub fn rows(&self) -> impl Iterator<Item = &Row> {
        self.rows.iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_come_oldest_first_and_fall_out() {
        let mut window = Window::new();
        for k in 0..20 {
            assert_eq!(window.is_full(), k >= WINDOW);
            window.push([k as f32; FEATURES]);
        }
        let firsts: heapless::Vec<f32, WINDOW> = window.rows().map(|row| row[0]).collect();
        assert_eq!(firsts.first(), Some(&4.0));
        assert_eq!(firsts.last(), Some(&19.0));
        assert_eq!(window.measured_rows(), WINDOW);
        window.push([0.0; FEATURES]);
        assert_eq!(window.measured_rows(), WINDOW - 1);
        window.clear();
        assert_eq!((window.measured_rows(), window.rows().count()), (0, 0));
    }

    #[test]
    fn a_row_tells_seen_from_not_seen() {
        let scale = Scale { fill_m: 0.07, height_m: 0.01, acceleration_m_s2: 2.0 };
        let mut profile = SurfaceProfile {
            height_m: [0.075; POINTS],
            variance_m2: [1e-8; POINTS],
            valid: [true; POINTS],
            glass_x_m: None,
            sequence: 0,
            captured: crate::units::Micros(0),
        };
        profile.valid[3] = false;
        let row = scale.row(Some(&profile), 1.0);
        assert!((row[0] - 0.5).abs() < 1e-5);
        assert_eq!(row[1..2], [1.0]);
        assert_eq!(row[6..8], [0.0, 0.0]);
        assert_eq!(row[42], 0.5);
        assert_eq!(scale.row(None, 0.0), [0.0; FEATURES]);
    }
}
