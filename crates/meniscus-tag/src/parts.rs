//! The parts of an image in which a tag is looked for, one in each image: a search of the whole image takes longer than a frame
//! on a small board, and the worker waits for it.
//!
//! Parts lie evenly over the image. Neighbours overlap by the width of the tag with its margin, so that it is whole in one of them
//! wherever it is. Where its size is not known, the image is searched in three sizes: a tag that is too large for a part of the
//! whole one fits into a part of half or of a quarter.

use crate::region::{Part, Region, span_px};

/// Advance of the parts, px. A part is as much wider than the overlap.
const STEP_PX: usize = 64;
/// Overlap where the size of the tag is not known, px: one of 54 pixels with its margin, turned by 45 degrees. It is 27 in half size,
/// which is enough there.
const UNKNOWN_PX: usize = 96;
/// Sizes in which a tag of unknown size is looked for: pixels of the image to one of a part.
const SCALES: [usize; 3] = [1, 2, 4];
/// Overlap for a tag of a known size, in heights or widths of the square around its corners: its margin, and a share more.
const OVERLAP: f64 = 1.5;
/// Images of a round beside a tag that is seen, at the least.
const ROUND: usize = 60;

/// One round over an image.
#[derive(Clone, Debug, Default)]
pub(crate) struct Parts {
    /// The parts, the nearest to some place first.
    parts: Vec<Part>,
    /// Number of the next part.
    next: usize,
    /// Images of this round so far.
    images: usize,
    /// Whether it looks for a second tag beside one that is seen.
    is_beside: bool,
}

/// Returns where `overlap`ping parts of `side` begin along `length`, and where each ends.
fn spans(length: usize, side: usize, overlap: usize) -> Vec<(usize, usize)> {
    if length <= side {
        return vec![(0, length)];
    }
    let count = (length - overlap).div_ceil(side - overlap);
    let start = |part: usize| part * (length - side) / (count - 1);
    (0..count).map(|part| (start(part), start(part) + side)).collect()
}

impl Parts {
    /// Begins a round over an image of `size`, width and height, in `scales`: parts near `place` first.
    fn begin(&mut self, size: (usize, usize), scales: &[usize], overlap: usize, place: [f64; 2]) {
        let side = overlap + STEP_PX;
        self.parts.clear();
        for &scale in scales {
            let (width, height) = (size.0 / scale, size.1 / scale);
            // A small image has no more work than two parts of a larger one.
            let is_whole = width * height <= 2 * side * side;
            let along = |length| if is_whole { vec![(0, length)] } else { spans(length, side, overlap) };
            let across = along(width);
            for (top, bottom) in along(height) {
                self.parts.extend(across.iter().map(|(left, right)| {
                    let [left, right, top, bottom] = [*left, *right, top, bottom].map(|place| scale * place);
                    Part { region: Region { left, right, top, bottom }, scale }
                }));
            }
        }
        let distance_px = |part: &Part| part.region.distance_px(place);
        self.parts.sort_by(|a, b| distance_px(a).total_cmp(&distance_px(b)));
        (self.next, self.images) = (0, 0);
    }

    /// Returns the part in which the next image is searched for a tag that is not seen, and was last at `place`.
    pub(crate) fn search(&mut self, size: (usize, usize), place: Option<[f64; 2]>) -> Part {
        if self.is_beside || self.next >= self.parts.len() {
            self.is_beside = false;
            let middle = [0.5 * size.0 as f64, 0.5 * size.1 as f64];
            self.begin(size, &SCALES, UNKNOWN_PX, place.unwrap_or(middle));
        }
        self.next += 1;
        self.parts[self.next - 1]
    }

    /// Returns the part in which the next image is searched for another tag beside the one with these corners; `None` where this
    /// round has the time to leave it out.
    pub(crate) fn beside(&mut self, size: (usize, usize), corners_px: &[[f64; 2]; 4]) -> Option<Part> {
        if !self.is_beside || self.images >= ROUND.max(self.parts.len()) {
            self.is_beside = true;
            let [width, height] = [0, 1].map(|axis| {
                let [least, most] = span_px(corners_px, axis);
                most - least
            });
            let overlap = (OVERLAP * width.max(height)).ceil() as usize;
            self.begin(size, &[1], overlap, corners_px[0]);
        }
        self.images += 1;
        // Evenly over the round: the last part is due in its last image.
        let due = self.images * self.parts.len() / ROUND.max(self.parts.len());
        (due > self.next).then(|| {
            self.next = due;
            self.parts[due - 1]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: (usize, usize) = (640, 480);

    /// Whether a square of `side_px` at `x`, `y` is whole in one of `parts`, and at least `least_px` of its pixels wide.
    fn holds(parts: &[Part], [x, y]: [usize; 2], side_px: usize, least_px: usize) -> bool {
        parts.iter().any(|Part { region, scale }| {
            let is_inside = region.left <= x
                && x + side_px <= region.right
                && region.top <= y
                && y + side_px <= region.bottom;
            is_inside && side_px >= least_px * scale
        })
    }

    fn places(side_px: usize, step_px: usize) -> impl Iterator<Item = [usize; 2]> {
        let rows = move |x| (0..=SIZE.1 - side_px).step_by(step_px).map(move |y| [x, y]);
        (0..=SIZE.0 - side_px).step_by(step_px).flat_map(rows)
    }

    /// A round of the search for a tag of unknown size.
    const SEARCH: usize = 67;

    #[test]
    fn a_tag_of_any_size_is_whole_in_a_part_wherever_it_is() {
        let mut parts = Parts::default();
        let round: Vec<Part> = (0..SEARCH).map(|_| parts.search(SIZE, None)).collect();
        // With its white margin, turned by 45 degrees: 27 pixels have 48.
        for side_px in (48..=380).step_by(4) {
            let lost = places(side_px, 9).find(|place| !holds(&round, *place, side_px, 48));
            assert_eq!(lost, None, "{side_px}");
        }
        let work = |Part { region: Region { left, right, top, bottom }, scale }: &Part| {
            (right - left) * (bottom - top) / (scale * scale)
        };
        assert!(round.iter().all(|part| 12 * work(part) <= 640 * 480), "a twelfth of the image at the most");
        assert_eq!(parts.search(SIZE, None), round[0], "then from the beginning");
    }

    #[test]
    fn the_first_part_is_around_the_last_place() {
        let Region { left, right, top, bottom } = Parts::default().search(SIZE, Some([100.0, 400.0])).region;
        assert!(left < 60 && right > 140 && top < 360 && bottom > 440, "{left} {right} {top} {bottom}");
    }

    #[test]
    fn a_round_beside_a_tag_comes_to_every_place() {
        let corners_px = [[300.0, 100.0], [340.0, 100.0], [340.0, 140.0], [300.0, 140.0]];
        let mut parts = Parts::default();
        let round: Vec<Part> = (0..70).filter_map(|_| parts.beside(SIZE, &corners_px)).collect();
        assert_eq!(places(50, 5).find(|place| !holds(&round, *place, 50, 48)), None);
        let mut small = Parts::default();
        let due: Vec<bool> = (0..120).map(|_| small.beside((120, 120), &corners_px).is_some()).collect();
        assert_eq!(due.iter().filter(|due| **due).count(), 2, "a small image is one part");
    }
}
