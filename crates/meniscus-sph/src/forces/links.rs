//! Links of [`Friction`](super::Friction): the vector `y` of each listed pair, sqrt(kg/s), in columns.
//!
//! The pairs of a particle are cut into blocks as [`crate::particles::blocks`] computes them. Friction is computed several times in a step: with
//! three numbers a pair kept, it has to turn no more than the velocities of the neighbours into columns.

use super::momentum::K;
use crate::particles::blocks::{BLOCK, Column, LAST, PairSum, Panel, VOLUME, dot, whole};
use crate::particles::lanes::{Lane, Single, Width, Work, widest};
use crate::particles::{CHUNKS, Kernel, Neighbours, Rows};
use rayon::prelude::*;
use std::ops::Range;

/// Column of `c mu`, where a particle has its pressure.
const DRAG: usize = LAST;

/// The vectors of a block of pairs, a column for each component.
pub(super) type Link = [Column<f32>; 3];

/// The links of one list.
#[derive(Clone, Debug, Default)]
pub(super) struct Links {
    /// Where the blocks of each particle begin.
    first: Vec<usize>,
    blocks: Vec<Link>,
}

impl Links {
    /// Forms the links between `particles` and `others` of the list `near`. Pressures are replaced by `c mu`; that of images,
    /// which do not have any, counts as that of the particle.
    pub(super) fn form(
        &mut self,
        kernel: &Kernel<f32>,
        soft: f32,
        [particles, others]: [&[Single<8>]; 2],
        near: &Rows,
        lists: &Neighbours,
    ) {
        self.first.clear();
        self.first.push(0);
        let mut all = 0;
        for i in 0..particles.len() {
            all += near.row(i).len().div_ceil(BLOCK);
            self.first.push(all);
        }
        self.blocks.resize(all, [[0.0; BLOCK]; 3]);
        let mut rest = &mut self.blocks[..];
        let mut parts = Vec::with_capacity(CHUNKS);
        for chunk in &lists.chunks {
            let here = self.first[chunk.end] - self.first[chunk.start];
            let (part, after) = std::mem::take(&mut rest).split_at_mut(here);
            parts.push((chunk.clone(), part));
            rest = after;
        }
        let images = !std::ptr::eq(particles, others);
        parts.into_par_iter().for_each(|(chunk, out)| {
            widest(Form { kernel, soft, particles, others, images, near, chunk, out });
        });
    }

    /// The blocks of particle `i`.
    #[inline(always)]
    pub(super) fn of(&self, i: usize) -> &[Link] {
        &self.blocks[self.first[i]..self.first[i + 1]]
    }
}

/// The links of a chunk of particles.
struct Form<'a> {
    kernel: &'a Kernel<f32>,
    soft: f32,
    particles: &'a [Single<8>],
    others: &'a [Single<8>],
    images: bool,
    near: &'a Rows,
    chunk: Range<usize>,
    out: &'a mut [Link],
}

impl Work for Form<'_> {
    #[inline(always)]
    fn run<W: Width>(self) {
        let Form { kernel, soft, particles, others, images, near, chunk, out } = self;
        let mut panel = Panel::new();
        let mut blocks = out.iter_mut();
        for i in chunk {
            let a = &particles[i].0;
            let (x, volume, own) = ([a[0], a[1], a[2]], a[VOLUME], a[DRAG]);
            for (at, block) in near.row(i).chunks(BLOCK).zip(blocks.by_ref()) {
                panel.gather::<W>(others, at);
                let [y_1, y_2, y_3] = block;
                for k in 0..whole(at.len()) {
                    let d = panel.apart(&x, k);
                    let r2 = dot(&d, &d);
                    let drag = if images { own } else { 0.5 * (own + panel.0[DRAG][k]) };
                    let weight = K * drag * volume * panel.0[VOLUME][k] * kernel.slope(r2) / (r2 + soft);
                    let root = (-weight).positive().root();
                    (y_1[k], y_2[k], y_3[k]) = (root * d[0], root * d[1], root * d[2]);
                }
                // What is beyond the list gives nothing to a sum.
                for column in block {
                    column[at.len()..whole(at.len())].fill(0.0);
                }
            }
        }
    }
}

/// Terms of a bound of the largest rate: `sum_j 2 y y^T + sum_w (1 + |B_w|) y y^T`.
pub(super) struct Stiffness<'a> {
    pub(super) lists: &'a Neighbours,
    pub(super) liquid: &'a Links,
    pub(super) wall: &'a Links,
    /// `|B_w|` of each image.
    pub(super) shares: &'a [f32],
}

/// `y y^T` of row `k`, `times` over.
#[inline(always)]
fn stiff(times: f32, [x, y, z]: &Link, k: usize) -> [f32; 6] {
    let (x, y, z) = (x[k], y[k], z[k]);
    [times * x * x, times * x * y, times * x * z, times * y * y, times * y * z, times * z * z]
}

impl PairSum<8> for Stiffness<'_> {
    type Columns = Panel<f32>;

    fn columns(&self) -> Panel<f32> {
        Panel::new()
    }

    #[inline(always)]
    fn row<W: Width>(&self, i: usize, bound: &mut Panel<f32>, out: &mut [Single<8>]) {
        for (at, link) in self.lists.liquid.row(i).chunks(BLOCK).zip(self.liquid.of(i)) {
            for k in 0..whole(at.len()) {
                bound.put(k, stiff(2.0, link, k));
            }
            bound.scatter::<W, 8>(at, out, 0);
            out[i].give(bound.totals::<W>(at.len()));
        }
        for (at, link) in self.lists.wall.row(i).chunks(BLOCK).zip(self.wall.of(i)) {
            let mut times = [1.0; BLOCK];
            for (times, w) in times.iter_mut().zip(at) {
                *times = 1.0 + self.shares[*w as usize];
            }
            for (k, times) in times.iter().enumerate().take(whole(at.len())) {
                bound.put(k, stiff(*times, link, k));
            }
            out[i].give(bound.totals::<W>(at.len()));
        }
    }
}
