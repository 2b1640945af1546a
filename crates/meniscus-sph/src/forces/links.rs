//! Links of [`Friction`](super::Friction): the weight of each listed pair, kg/m2/s, in columns.
//!
//! The pairs of a particle are cut into blocks as [`crate::particles::blocks`] computes them. Separations are not kept: friction is computed
//! several times in a step, and four numbers a pair would be more than the caches near to the processor hold.

use super::momentum::K;
use crate::particles::blocks::{BLOCK, Column, LAST, PairSum, Panel, VOLUME, dot, whole};
use crate::particles::lanes::{Single, Width, Work, widest};
use crate::particles::{CHUNKS, Kernel, Neighbours, Rows};
use rayon::prelude::*;
use std::ops::Range;

/// Column of `c mu`, where a particle has its pressure.
const DRAG: usize = LAST;

/// The links of one list.
#[derive(Clone, Debug, Default)]
pub(super) struct Links {
    /// Where the blocks of each particle begin.
    first: Vec<usize>,
    blocks: Vec<Column<f32>>,
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
        self.blocks.resize(all, [0.0; BLOCK]);
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
    pub(super) fn of(&self, i: usize) -> &[Column<f32>] {
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
    out: &'a mut [Column<f32>],
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
                for (k, weight) in block.iter_mut().enumerate().take(whole(at.len())) {
                    let d = panel.apart(&x, k);
                    let r2 = dot(&d, &d);
                    let drag = if images { own } else { 0.5 * (own + panel.0[DRAG][k]) };
                    *weight = K * drag * volume * panel.0[VOLUME][k] * kernel.slope(r2) / (r2 + soft);
                }
                // What is beyond the list gives nothing to a sum.
                block[at.len()..whole(at.len())].fill(0.0);
            }
        }
    }
}

/// Terms of a bound of the largest rate: `sum_j 2 w_ij x x^T + sum_w (1 + |B_w|) w_iw x x^T`.
pub(super) struct Stiffness<'a> {
    pub(super) lists: &'a Neighbours,
    pub(super) liquid: &'a Links,
    pub(super) wall: &'a Links,
    pub(super) particle: &'a [Single<8>],
    pub(super) image: &'a [Single<8>],
    /// `|B_w|` of each image.
    pub(super) shares: &'a [f32],
}

/// `w x x^T` times `-times`.
#[inline(always)]
fn stiff(times: f32, weight: f32, [x, y, z]: [f32; 3]) -> [f32; 6] {
    let w = -times * weight;
    [w * x * x, w * x * y, w * x * z, w * y * y, w * y * z, w * z * z]
}

impl PairSum<8> for Stiffness<'_> {
    type Columns = [Panel<f32>; 2];

    fn columns(&self) -> [Panel<f32>; 2] {
        [Panel::new(); 2]
    }

    #[inline(always)]
    fn row<W: Width>(&self, i: usize, [near, bound]: &mut [Panel<f32>; 2], out: &mut [Single<8>]) {
        let [x, y, z, ..] = self.particle[i].0;
        for (at, weight) in self.lists.liquid.row(i).chunks(BLOCK).zip(self.liquid.of(i)) {
            near.gather::<W>(self.particle, at);
            for (k, weight) in weight.iter().enumerate().take(whole(at.len())) {
                bound.put(k, stiff(2.0, *weight, near.apart(&[x, y, z], k)));
            }
            bound.scatter::<W, 8>(at, out, 0);
            out[i].give::<6>(bound.totals(at.len()));
        }
        for (at, weight) in self.lists.wall.row(i).chunks(BLOCK).zip(self.wall.of(i)) {
            let mut times = [1.0; BLOCK];
            for (times, w) in times.iter_mut().zip(at) {
                *times = 1.0 + self.shares[*w as usize];
            }
            near.gather::<W>(self.image, at);
            for (k, weight) in weight.iter().enumerate().take(whole(at.len())) {
                bound.put(k, stiff(times[k], *weight, near.apart(&[x, y, z], k)));
            }
            out[i].give::<6>(bound.totals(at.len()));
        }
    }
}
