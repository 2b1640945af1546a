//! Friction as a linear operator on the velocities, for liquids so thick that the explicit step would have to be shorter than
//! sound asks for.
//!
//! At fixed places and viscosities the friction of [`super::momentum`] is linear in the velocities. With `x = x_i - x_j`,
//! `V = m/rho` and `B_w` the matrix that makes the velocity of the image `w` of that of its original `o`:
//! ```text
//! m_i (A v)_i = -sum_j ((v_i - v_j).y) y - sum_w ((v_i - B_w v_o).y) y
//! y = x sqrt(-w_ij),     w_ij = V_i V_j K (c_i mu_i + c_j mu_j)/2 F / (r^2 + 0.01 h^2) <= 0
//! ```
//! The vectors `y` are formed once for a step; [`crate::integration::Stages`] then asks for `A v` several times.
//!
//! The largest rate at which it slows, by `((v_i - v_j).y)^2 <= 2 (v_i.y)^2 + 2 (v_j.y)^2`, is at most
//! ```text
//! lambda <= max_i |sum_j 2 y y^T + sum_w (1 + |B_w|) y y^T| / m_i
//! ```

use super::links::{Link, Links, Stiffness};
use super::momentum::Momentum;
use crate::particles::blocks::{BLOCK, PairSum, Quads, dot, whole};
use crate::particles::lanes::{Lane, Quad, Row, Single, Width};
use crate::particles::{CHUNKS, Neighbours};
use crate::walls::{Map, Walls};

/// The operator at one instant, and its memory.
#[derive(Clone, Debug, Default)]
pub(crate) struct Friction {
    /// One for each listed pair of liquid particles, in the order of the list.
    liquid: Links,
    /// One for each listed image of each particle.
    wall: Links,
    /// From the velocities of the originals to those of their images.
    maps: Vec<Map>,
    /// The particles with their `c_i mu_i` in place of their pressures.
    dragged: Vec<Single<8>>,
    /// The velocities at which friction is computed, m/s.
    particle_v: Vec<Quad>,
    /// Those of the images, m/s.
    image_v: Vec<Quad>,
    stiffness: Vec<[f64; 6]>,
    stiffness_buffers: Vec<Vec<Single<8>>>,
    buffers: Vec<Vec<Single<4>>>,
    /// Force N (3), and the heat of the friction, W.
    out: Vec<[f64; 4]>,
    /// Largest rate at which anything is slowed, 1/s.
    rate: f64,
}

impl Friction {
    /// Largest rate at which anything is slowed, 1/s.
    pub(crate) fn largest_rate(&self) -> f64 {
        self.rate
    }

    /// The maps of the images, to be filled before [`Self::form`].
    pub(super) fn maps(&mut self) -> &mut Vec<Map> {
        &mut self.maps
    }

    /// Forms the links of the present places and viscosities.
    pub(super) fn form(&mut self, pairs: &Momentum<'_>, mass: &[f64]) {
        let Momentum { kernel, lists, particle, walls, drag, soft, .. } = *pairs;
        let Self { liquid, wall, maps, dragged, stiffness, stiffness_buffers, .. } = self;
        dragged.clear();
        dragged.extend(particle.iter().zip(drag).map(|(p, drag)| {
            let [x, y, z, u, v, w, volume, _] = p.0;
            Row([x, y, z, u, v, w, volume, f32::of(*drag)])
        }));
        liquid.form(&kernel, soft, [dragged, dragged], &lists.liquid, lists);
        wall.form(&kernel, soft, [dragged, &walls.rubbed], &lists.wall, lists);
        stiffness_buffers.resize(CHUNKS, Vec::new());
        stiffness.resize(particle.len(), [0.0; 6]);
        let shares: Vec<f32> = maps.iter().map(|map| f32::of(share(map))).collect();
        let bounds = Stiffness { lists, liquid, wall, shares: &shares };
        lists.sum(stiffness_buffers, stiffness, &bounds);
        self.rate = stiffness.iter().zip(mass).map(|(s, m)| norm(s) / m).fold(0.0, f64::max);
    }

    /// Returns force (N, 3 numbers) and heat (W) of each particle at the velocities `v`.
    pub(crate) fn act(&mut self, lists: &Neighbours, walls: &Walls, v: &[[f64; 3]]) -> &[[f64; 4]] {
        let Self { liquid, wall, maps, particle_v, image_v, buffers, out, .. } = self;
        rayon::join(
            || {
                particle_v.clear();
                particle_v.extend(v.iter().map(Quad::of));
            },
            || {
                image_v.clear();
                image_v.extend(walls.mapped(maps, |i| v[i]).map(|v| Quad::of(&v)));
            },
        );
        buffers.resize(CHUNKS, Vec::new());
        out.resize(v.len(), [0.0; 4]);
        lists.sum(buffers, out, &Rub { lists, liquid, wall, particle: particle_v, image: image_v });
        out
    }
}

/// Largest speed of an image over that of its original.
fn share(map: &Map) -> f64 {
    map.iter().map(|row| row.iter().map(|x| x.abs()).sum()).fold(0.0, f64::max)
}

/// Largest sum of a row's absolute values: no eigenvalue is larger.
fn norm(s: &[f64; 6]) -> f64 {
    let row = |a: usize, b: usize, c: usize| s[a].abs() + s[b].abs() + s[c].abs();
    row(0, 1, 2).max(row(1, 3, 4)).max(row(2, 4, 5))
}

/// Inputs of the sum.
struct Rub<'a> {
    lists: &'a Neighbours,
    liquid: &'a Links,
    wall: &'a Links,
    /// Velocities of the particles, m/s.
    particle: &'a [Quad],
    /// Those of the images, m/s.
    image: &'a [Quad],
}

/// The columns of a block.
struct Columns {
    /// Velocities of the neighbours, m/s.
    near: Quads,
    /// Force on the particle N (3), and the heat of the friction with its sign changed, W.
    pull: Quads,
}

/// The vector of pair `k`.
#[inline(always)]
fn along([x, y, z]: &Link, k: usize) -> [f32; 3] {
    [x[k], y[k], z[k]]
}

impl PairSum<4> for Rub<'_> {
    type Columns = Columns;

    fn columns(&self) -> Columns {
        Columns { near: Quads::new(), pull: Quads::new() }
    }

    #[inline(always)]
    fn row<W: Width>(&self, i: usize, columns: &mut Columns, out: &mut [Single<4>]) {
        let Columns { near, pull } = columns;
        let [v_x, v_y, v_z, _] = self.particle[i].0;
        for (at, link) in self.lists.liquid.row(i).chunks(BLOCK).zip(self.liquid.of(i)) {
            near.gather::<W>(self.particle, at);
            for k in 0..whole(at.len()) {
                let (y, v) = (along(link, k), near.three(k));
                let size = dot(&[v[0] - v_x, v[1] - v_y, v[2] - v_z], &y);
                pull.put(k, [size * y[0], size * y[1], size * y[2], -0.5 * size * size]);
            }
            pull.take::<W>(at, out);
            let [x, y, z, taken] = pull.totals::<W>(at.len());
            out[i].give([x, y, z, -taken]);
        }
        for (at, link) in self.lists.wall.row(i).chunks(BLOCK).zip(self.wall.of(i)) {
            near.gather::<W>(self.image, at);
            for k in 0..whole(at.len()) {
                let y = along(link, k);
                let own = dot(&[v_x, v_y, v_z], &y);
                let size = dot(&near.three(k), &y) - own;
                // The wall stands still: all that its friction takes is heat.
                pull.put(k, [size * y[0], size * y[1], size * y[2], size * own]);
            }
            let [x, y, z, taken] = pull.totals::<W>(at.len());
            out[i].give([x, y, z, -taken]);
        }
    }
}
