//! A plate with an AprilTag above the rim, as on a gripper that holds the glass; it moves with the glass.
//!
//! The patterns are those of the family 36h11 (E. Olson, AprilTag, ICRA 2011): 6 x 6 squares of data in a black border a square
//! wide, in a white margin as wide. The reader's own table is another one.

use super::Window;
use super::view::View;

/// Codes of the family.
const CODES: &str = include_str!("tag36h11.txt");
/// Column and row of each bit, most significant first, among the 8 x 8 squares of border and data: the order in which the family's
/// squares spiral around the centre, a quarter at a time.
const BITS: [[u8; 2]; 36] = bits();
/// Squares on a side, with the white margin.
pub(crate) const SQUARES: usize = 10;
/// Grey levels of the print.
const BLACK: f64 = 35.0;
const WHITE: f64 = 205.0;
/// Rays through a pixel, each in a row and a column of its own: an edge along the pixels is found to a sixteenth of one.
const RAYS: usize = 16;
/// Rows from a ray to the next, without a divisor of their number.
const STRIDE: usize = 7;

/// Squares of a tag with its white margin, row by row from the top left; whether each is white.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TagPattern([[bool; SQUARES]; SQUARES]);

/// A plate with a tag.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TagPlate {
    /// The tag.
    pub pattern: TagPattern,
    /// Width of its black border, m.
    pub size_m: f64,
    /// Height of its centre above the inner bottom of the glass, m. It stands above the front of the glass.
    pub height_m: f64,
    /// Angle by which it leans back, rad.
    pub lean_rad: f64,
}

/// The bits of a quarter, turned three times: (x, y) becomes (7 - y, x).
const fn bits() -> [[u8; 2]; 36] {
    let quarter = [[1, 1], [2, 1], [3, 1], [4, 1], [5, 1], [2, 2], [3, 2], [4, 2], [3, 3]];
    let mut all = [[0; 2]; 36];
    let mut place = 0;
    while place < 36 {
        all[place] = if place < 9 { quarter[place] } else { [7 - all[place - 9][1], all[place - 9][0]] };
        place += 1;
    }
    all
}

impl TagPattern {
    /// Returns the pattern of a number; `None` for one that the family does not have.
    #[must_use]
    pub fn of(number: u32) -> Option<Self> {
        let words = CODES.lines().filter(|line| !line.starts_with('#')).flat_map(str::split_whitespace);
        let code = u64::from_str_radix(words.clone().nth(number as usize)?, 16).ok()?;
        let mut squares = [[false; SQUARES]; SQUARES];
        for (row, line) in squares.iter_mut().enumerate() {
            for (column, square) in line.iter_mut().enumerate() {
                *square = row == 0 || column == 0 || row == SQUARES - 1 || column == SQUARES - 1;
            }
        }
        for (place, [column, row]) in BITS.iter().enumerate() {
            squares[usize::from(*row) + 1][usize::from(*column) + 1] = (code >> (35 - place)) & 1 == 1;
        }
        Some(Self(squares))
    }

    /// Returns the squares row by row from the top left; whether each is white.
    pub(crate) fn squares(&self) -> &[[bool; SQUARES]; SQUARES] {
        &self.0
    }

    /// Grey level at a place in squares from the top left corner; `None` beside the tag.
    fn grey(&self, right: f64, down: f64) -> Option<f64> {
        let square = |place: f64| (0.0..SQUARES as f64).contains(&place).then_some(place as usize);
        let is_white = self.0[square(down)?][square(right)?];
        Some(if is_white { WHITE } else { BLACK })
    }
}

impl TagPlate {
    /// Highest point, m.
    pub(super) fn top_m(&self) -> f64 {
        self.height_m + 0.5 * self.size_m * SQUARES as f64 / (SQUARES - 2) as f64
    }

    /// Paints the plate over the sharp picture of `window`.
    pub(super) fn paint(&self, view: &View, axis_m: f64, radius_m: f64, window: Window, sharp: &mut [f32]) {
        let (sin, cos) = self.lean_rad.sin_cos();
        let centre = [axis_m, -radius_m, self.height_m];
        let (down, normal) = ([0.0, -sin, -cos], [0.0, cos, -sin]);
        let square_m = self.size_m / (SQUARES - 2) as f64;
        let middle = 0.5 * SQUARES as f64;
        let columns = window.width();
        for (row, line) in sharp.chunks_exact_mut(columns).enumerate() {
            for (column, pixel) in line.iter_mut().enumerate() {
                let [u, v] = [window.left + column, window.top + row].map(|place| place as f64);
                // Nothing of the plate is in most pixels: a look at the pixel's centre says so.
                let at = |du: f64, dv: f64| {
                    let [x, y, z] = view.on_plane(view.ray(u + du, v + dv), centre, normal)?;
                    let across = (x - centre[0]) / square_m;
                    let along = ((y - centre[1]) * down[1] + (z - centre[2]) * down[2]) / square_m;
                    Some((middle + across, middle + along))
                };
                let near = |(right, down): (f64, f64)| right.max(down) < 11.0 && right.min(down) > -1.0;
                if !at(0.0, 0.0).is_some_and(near) {
                    continue;
                }
                let ray = |k: usize| (k as f64 + 0.5) / RAYS as f64 - 0.5;
                let under = f64::from(*pixel);
                let places = (0..RAYS).map(|k| at(ray(k), ray(k * STRIDE % RAYS)));
                let greys = places.map(|place| {
                    place.and_then(|(right, down)| self.pattern.grey(right, down)).unwrap_or(under)
                });
                *pixel = (greys.sum::<f64>() / RAYS as f64) as f32;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_of_the_family_has_a_pattern_of_its_own() {
        let all: Vec<TagPattern> =
            (0..587).map(|number| TagPattern::of(number).expect("a pattern")).collect();
        assert!(TagPattern::of(587).is_none());
        // At least 11 squares apart, also from the other turned.
        let apart = |a: &TagPattern, b: &TagPattern| {
            a.0.iter().flatten().zip(b.0.iter().flatten()).filter(|(a, b)| a != b).count()
        };
        for (place, one) in all.iter().enumerate().take(40) {
            for other in &all[place + 1..] {
                let mut turned = *other;
                for _ in 0..4 {
                    turned =
                        TagPattern(std::array::from_fn(|row| std::array::from_fn(|c| turned.0[9 - c][row])));
                    assert!(apart(one, &turned) >= 11, "{place}");
                }
            }
        }
    }
}
