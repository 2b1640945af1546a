//! A grid of cells, searched for the points near other points.
//!
//! The points of a row of cells lie side by side in memory, so that their distances are computed in vectors as wide as the
//! processor's. What is near is listed in the order of the cells, whatever the vectors or the number of threads.

use super::lanes::{Eight, Width, Work, widest};
use super::rows::{CHUNKS, Rows};
use rayon::prelude::*;
use std::ops::Range;

/// A box along the axes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Box3 {
    /// Least coordinates, m.
    pub(crate) low: [f64; 3],
    /// Largest coordinates, m.
    pub(crate) high: [f64; 3],
}

/// A grid of cubic cells over a box.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    origin: [f64; 3],
    inverse: f64,
    cells: [usize; 3],
    /// The points of each cell.
    rows: Rows,
    /// Numbers of the points in the order of the cells, and seven more.
    number: Vec<u32>,
    /// Coordinates of the points in the order of the cells, m, and seven more.
    place: [Vec<f64>; 3],
}

impl Grid {
    /// An empty grid over `space` with cells of the length `edge` m.
    pub(super) fn new(space: Box3, edge: f64) -> Self {
        let Box3 { low, high } = space;
        let cells = std::array::from_fn(|d| ((high[d] - low[d]) / edge).floor() as usize + 1);
        let place = [const { Vec::new() }; 3];
        Self { origin: low, inverse: 1.0 / edge, cells, rows: Rows::default(), number: Vec::new(), place }
    }

    fn cell(&self, x: &[f64; 3]) -> [usize; 3] {
        std::array::from_fn(|d| {
            (((x[d] - self.origin[d]) * self.inverse).max(0.0) as usize).min(self.cells[d] - 1)
        })
    }

    fn index(&self, [a, b, c]: [usize; 3]) -> usize {
        (c * self.cells[1] + b) * self.cells[0] + a
    }

    /// Sorts `points` into the cells.
    pub(super) fn fill(&mut self, points: &[[f64; 3]]) {
        let mut cell_of = Rows::default();
        cell_of.clear();
        for x in points {
            cell_of.extend(&[self.index(self.cell(x)) as u32]);
            cell_of.end_row();
        }
        self.rows = cell_of.transposed(self.cells.iter().product());
        // Whole eights are read from any point on.
        self.number.clear();
        self.number.extend(self.rows.entries().iter().chain(&[0; 7]));
        for (axis, place) in self.place.iter_mut().enumerate() {
            place.clear();
            place.extend(self.rows.entries().iter().map(|&i| points[i as usize][axis]));
            place.extend([0.0; 7]);
        }
    }

    /// Calls `visit` with each run of cells next to the cell of `x`, one run for each row of cells.
    #[inline(always)]
    fn around(&self, x: &[f64; 3], mut visit: impl FnMut(Range<usize>)) {
        let [a, b, c] = self.cell(x);
        let span = |i: usize, n: usize| i.saturating_sub(1)..(i + 2).min(n);
        let run = span(a, self.cells[0]);
        for c in span(c, self.cells[2]) {
            for b in span(b, self.cells[1]) {
                let [first, last] = [run.start, run.end - 1].map(|a| self.index([a, b, c]));
                visit(self.rows.rows(first, last));
            }
        }
    }
}

/// A search of a grid for what is near each of some points.
#[derive(Clone, Copy)]
pub(super) struct Search<'a> {
    /// The grid, no finer than the radius.
    pub(super) grid: &'a Grid,
    /// The points.
    pub(super) points: &'a [[f64; 3]],
    /// Square of the radius, m2.
    pub(super) reach2: f64,
    /// Whether only what has a higher number than the point is listed.
    pub(super) after: bool,
    /// A point higher than this has nothing near it, m.
    pub(super) highest_m: f64,
}

impl Search<'_> {
    /// Lists what is near each point, a row for each. `parts` keeps the memory of what the threads find: to ask for it at each call
    /// holds them up.
    pub(super) fn list(&self, parts: &mut [Rows; CHUNKS], rows: &mut Rows) {
        let n = self.points.len();
        parts.par_iter_mut().enumerate().for_each(|(c, part)| {
            part.clear();
            widest(Part { search: *self, points: c * n / CHUNKS..(c + 1) * n / CHUNKS, rows: part });
        });
        rows.join(parts);
    }

    /// Adds to `rows` what of `run` is near the point with the number `i`.
    #[inline(always)]
    fn near<W: Width>(&self, i: usize, run: Range<usize>, rows: &mut Rows) {
        let [x, y, z] = self.points[i];
        let from = if self.after { i as u32 + 1 } else { 0 };
        let Grid { number, place: [xs, ys, zs], .. } = self.grid;
        for start in run.clone().step_by(8) {
            let (Some(numbers), Some(xs), Some(ys), Some(zs)) =
                (eight(number, start), eight(xs, start), eight(ys, start), eight(zs, start))
            else {
                return;
            };
            let mut distance2 = [0.0; 8];
            for k in 0..8 {
                let d = [x - xs[k], y - ys[k], z - zs[k]];
                distance2[k] = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
            }
            let mut found = [0; 8];
            let eight = Eight { numbers, distance2: &distance2, first: run.end - start };
            let count = W::pick(&eight, self.reach2, from, &mut found);
            rows.extend_some(&found, count);
        }
    }
}

/// Eight of `all` from the one with the number `start` on.
#[inline(always)]
fn eight<T>(all: &[T], start: usize) -> Option<&[T; 8]> {
    all.get(start..)?.first_chunk()
}

/// The rows of some of the points.
struct Part<'a> {
    search: Search<'a>,
    points: Range<usize>,
    rows: &'a mut Rows,
}

impl Work for Part<'_> {
    #[inline(always)]
    fn run<W: Width>(self) {
        let Self { search, points, rows } = self;
        for i in points {
            let x = &search.points[i];
            if x[2] <= search.highest_m {
                search.grid.around(x, |run| search.near::<W>(i, run, rows));
            }
            rows.end_row();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_that_is_near_is_listed_once() {
        let jumble = |k: usize, d: f64| 0.5 + 0.5 * (12.9 * k as f64 + 78.2 * d).sin();
        let points: Vec<[f64; 3]> = (0..700).map(|k| [0.0, 1.0, 2.0].map(|d| jumble(k, d))).collect();
        let mut grid = Grid::new(Box3 { low: [0.0; 3], high: [1.0; 3] }, 0.21);
        grid.fill(&points);
        for (after, highest_m) in [(true, f64::INFINITY), (false, 0.6)] {
            let (mut parts, mut rows) = Default::default();
            let search = Search { grid: &grid, points: &points, reach2: 0.2 * 0.2, after, highest_m };
            search.list(&mut parts, &mut rows);
            for (i, x) in points.iter().enumerate() {
                let mut found = rows.row(i).to_vec();
                found.sort_unstable();
                let near = |j: &u32| {
                    let y = &points[*j as usize];
                    let d2: f64 = x.iter().zip(y).map(|(x, y)| (x - y) * (x - y)).sum();
                    d2 < search.reach2 && (!after || *j as usize > i) && x[2] <= highest_m
                };
                assert_eq!(found, (0..700).filter(near).collect::<Vec<u32>>(), "point {i}");
            }
        }
    }
}
