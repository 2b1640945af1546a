//! Neighbour lists: Verlet lists with a skin, rebuilt from a grid of cells only when some particle has moved half the skin.
//!
//! Liquid pairs are listed once (`j > i`). The list is cut into a fixed number of chunks of nearly
//! equal work; each chunk sums into its own buffer and the buffers are added in order. The order of
//! every addition is thus the same for any number of threads, and results are equal bit for bit.

use super::blocks::{PairSum, add_rows};
use super::grid::{Box3, Grid, Search};
use super::lanes::{Lane, Row};
use super::rows::{CHUNKS, PIECE, Rows};
use super::state::Particle;
use rayon::prelude::*;
use std::ops::Range;

/// Skin of the images in units of the skin of the particles: behind a round wall an image may move
/// up to twice as far as its original.
pub(crate) const IMAGE_SKIN: f64 = 1.5;

/// The lists of one moment.
#[derive(Clone, Debug)]
pub(crate) struct Neighbours {
    /// Liquid neighbours `j > i` of liquid particle `i`.
    pub(crate) liquid: Rows,
    /// Images near each liquid particle.
    pub(crate) wall: Rows,
    /// Ranges of liquid particles of nearly equal work.
    pub(crate) chunks: [Range<usize>; CHUNKS],
    /// The particles that the pairs of a chunk can give something to.
    touched: [Range<usize>; CHUNKS],
    reach2: f64,
    wall_reach2: f64,
    allowed2: f64,
    grid: Grid,
    wall_grid: Grid,
    built_at: Vec<[f64; 3]>,
    wall_at: Vec<[f64; 3]>,
    /// Memory of the searches of the two grids.
    parts: [[Rows; CHUNKS]; 2],
}

impl Neighbours {
    /// Lists for `particles` and the images `wall` in `space`, good for the radius
    /// `support` plus `skin`.
    pub(crate) fn new(
        particles: &[Particle],
        wall: &[Particle],
        space: Box3,
        support: f64,
        skin: f64,
    ) -> Self {
        let reach = support + skin;
        let wall_reach = support + IMAGE_SKIN * skin;
        let mut lists = Self {
            liquid: Rows::default(),
            wall: Rows::default(),
            chunks: std::array::from_fn(|_| 0..0),
            touched: std::array::from_fn(|_| 0..0),
            reach2: reach * reach,
            wall_reach2: wall_reach * wall_reach,
            allowed2: 0.25 * skin * skin,
            grid: Grid::new(space, reach),
            wall_grid: Grid::new(space, wall_reach),
            built_at: Vec::new(),
            wall_at: Vec::new(),
            parts: Default::default(),
        };
        lists.rebuild(particles, wall, f64::INFINITY);
        lists
    }

    /// Whether some particle has moved half the skin since the lists were built.
    pub(crate) fn stale(&self, particles: &[Particle]) -> bool {
        particles.iter().zip(&self.built_at).any(|(p, b)| distance2(&p.x, b) > self.allowed2)
    }

    /// Builds the lists anew; particles higher than `rim_m` see no images.
    pub(crate) fn rebuild(&mut self, particles: &[Particle], wall: &[Particle], rim_m: f64) {
        let Self { liquid, wall: near_wall, grid, wall_grid, built_at, wall_at, parts, .. } = self;
        let [liquid_parts, wall_parts] = parts;
        built_at.clear();
        built_at.extend(particles.iter().map(|p| p.x));
        let points = &*built_at;
        rayon::join(
            || {
                grid.fill(points);
                let reach2 = self.reach2;
                let search = Search { grid, points, reach2, after: true, highest_m: f64::INFINITY };
                search.list(liquid_parts, liquid);
            },
            || {
                wall_at.clear();
                wall_at.extend(wall.iter().map(|w| w.x));
                wall_grid.fill(wall_at);
                let reach2 = self.wall_reach2;
                let search = Search { grid: wall_grid, points, reach2, after: false, highest_m: rim_m };
                search.list(wall_parts, near_wall);
            },
        );
        self.cut(particles.len());
    }

    /// Cuts the particles into chunks of nearly the same number of listed pairs.
    fn cut(&mut self, particles: usize) {
        let work = |i: usize| self.liquid.start[i] as usize + self.wall.start[i] as usize;
        let all = work(particles);
        let bounds: [usize; CHUNKS] = std::array::from_fn(|c| {
            // The work up to a particle only grows, so that the first that has enough before it can be searched by halves.
            let (mut low, mut high) = (0, particles);
            while low < high {
                let middle = usize::midpoint(low, high);
                (low, high) =
                    if work(middle) * CHUNKS < c * all { (middle + 1, high) } else { (low, middle) };
            }
            low
        });
        self.chunks = std::array::from_fn(|c| bounds[c]..bounds.get(c + 1).copied().unwrap_or(particles));
        let liquid = &self.liquid;
        self.touched.par_iter_mut().zip(&self.chunks).for_each(|(touched, Range { start, end })| {
            let pairs = &liquid.entry[liquid.start[*start] as usize..liquid.start[*end] as usize];
            // Pairs are listed with the lower of the two.
            let behind = pairs.iter().fold(0, |behind, &j| behind.max(j + 1)) as usize;
            *touched = *start..behind.max(*end);
        });
    }

    /// Sums over all pairs: what particle `i` and its listed partners get is added to the buffer of its chunk; `buffers`
    /// keeps the memory between calls. The first `M` of the `N` numbers of each sum land in `out`.
    pub(crate) fn sum<const N: usize, const M: usize, T: Lane>(
        &self,
        buffers: &mut [Vec<Row<N, T>>],
        out: &mut [[f64; M]],
        pairs: &impl PairSum<N, T>,
    ) {
        let rows = out.len();
        buffers.par_iter_mut().zip(&self.chunks).zip(&self.touched).for_each(|((buffer, chunk), touched)| {
            buffer.resize(rows, Row::default());
            buffer[touched.clone()].fill(Row::default());
            add_rows(pairs, chunk.clone(), buffer);
        });
        out.par_chunks_mut(PIECE).enumerate().for_each(|(piece, out)| {
            out.fill([0.0; M]);
            let here = piece * PIECE..piece * PIECE + out.len();
            for (buffer, touched) in buffers.iter().zip(&self.touched) {
                let both = touched.start.max(here.start)..touched.end.min(here.end);
                if both.is_empty() {
                    continue;
                }
                let out = &mut out[both.start - here.start..both.end - here.start];
                for (o, b) in out.iter_mut().zip(&buffer[both]) {
                    for (o, b) in o.iter_mut().zip(b.0) {
                        *o += b.into();
                    }
                }
            }
        });
    }
}

/// Squared distance of two points.
#[inline]
pub(crate) fn distance2(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    let d = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    d[0] * d[0] + d[1] * d[1] + d[2] * d[2]
}
