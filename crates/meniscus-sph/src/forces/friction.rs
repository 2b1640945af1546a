//! Friction as a linear operator on the velocities, for liquids so thick that the explicit step would have to be shorter than
//! sound asks for.
//!
//! At fixed places and viscosities the friction of [`super::momentum`] is linear in the velocities. With `x = x_i - x_j`,
//! `V = m/rho` and `B_w` the matrix that makes the velocity of the image `w` of that of its original `o`:
//! ```text
//! m_i (A v)_i = sum_j w_ij ((v_i - v_j).x) x + sum_w w_iw ((v_i - B_w v_o).x) x
//! w_ij = V_i V_j K (c_i mu_i + c_j mu_j)/2 F / (r^2 + 0.01 h^2) <= 0
//! ```
//! The weights are formed once for a step; [`crate::integration::Stages`] then asks for `A v` several times.
//!
//! The largest rate at which it slows, by `((v_i - v_j).x)^2 <= 2 (v_i.x)^2 + 2 (v_j.x)^2`, is at most
//! ```text
//! lambda <= max_i |sum_j 2 w_ij x x^T + sum_w (1 + |B_w|) w_iw x x^T| / m_i
//! ```

use super::links::{Links, Stiffness};
use super::momentum::Momentum;
use crate::particles::blocks::{BLOCK, PairSum, Panel, Quads, dot, whole};
use crate::particles::lanes::{Lane, Row, Single, Width, row};
use crate::particles::{CHUNKS, Neighbours, Particle};
use crate::walls::{Map, Walls};

/// Velocities or accelerations of all particles.
pub(crate) type Vectors = [[f64; 3]];

/// The operator at one instant, and its memory.
#[derive(Clone, Debug, Default)]
pub(crate) struct Friction {
    /// One for each listed pair of liquid particles, in the order of the list.
    liquid: Links,
    /// One for each listed image of each particle.
    wall: Links,
    /// From the velocities of the originals to those of their images.
    maps: Vec<Map>,
    /// Velocities of the images, m/s.
    rubbing: Vec<[f64; 3]>,
    /// The particles with their `c_i mu_i` in place of their pressures, and with the velocities at which friction is computed.
    particle: Vec<Single<8>>,
    /// The images, as well.
    image: Vec<Single<8>>,
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

    /// Forms the weights of the present places and viscosities.
    pub(super) fn form(&mut self, pairs: &Momentum<'_>, images: &[Particle], mass: &[f64]) {
        let Momentum { kernel, lists, particle, drag, soft, .. } = *pairs;
        let Self { liquid, wall, maps, particle: dragged, image, stiffness, stiffness_buffers, .. } = self;
        dragged.clear();
        dragged.extend(particle.iter().zip(drag).map(|(p, drag)| {
            let [x, y, z, u, v, w, volume, _] = p.0;
            Row([x, y, z, u, v, w, volume, f32::of(*drag)])
        }));
        liquid.form(&kernel, soft, [dragged, dragged], &lists.liquid, lists);
        image.clear();
        image.extend(images.iter().map(|p| row(p, p.p)));
        wall.form(&kernel, soft, [dragged, image], &lists.wall, lists);
        stiffness_buffers.resize(CHUNKS, Vec::new());
        stiffness.resize(particle.len(), [0.0; 6]);
        let shares: Vec<f32> = maps.iter().map(|map| f32::of(share(map))).collect();
        let bounds = Stiffness { lists, liquid, wall, particle: dragged, image, shares: &shares };
        lists.sum(stiffness_buffers, stiffness, &bounds);
        self.rate = stiffness.iter().zip(mass).map(|(s, m)| norm(s) / m).fold(0.0, f64::max);
    }

    /// Returns force (N, 3 numbers) and heat (W) of each particle at the velocities `v`.
    pub(crate) fn act(&mut self, lists: &Neighbours, walls: &Walls, v: &Vectors) -> &[[f64; 4]] {
        walls.mapped(&self.maps, |i| v[i], &mut self.rubbing);
        let Self { liquid, wall, rubbing, buffers, particle, image, out, .. } = self;
        buffers.resize(CHUNKS, Vec::new());
        out.resize(v.len(), [0.0; 4]);
        for (rows, v) in [(&mut *particle, v), (&mut *image, &**rubbing)] {
            rows.iter_mut().zip(v).for_each(|(row, v)| row.0[3..6].copy_from_slice(&v.map(f32::of)));
        }
        lists.sum(buffers, out, &Rub { lists, liquid, wall, particle, image });
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
    particle: &'a [Single<8>],
    image: &'a [Single<8>],
}

/// The columns of a block.
struct Columns {
    near: Panel<f32>,
    /// Force on the particle N (3), and the heat of the friction with its sign changed, W.
    pull: Quads,
}

impl PairSum<4> for Rub<'_> {
    type Columns = Columns;

    fn columns(&self) -> Columns {
        Columns { near: Panel::new(), pull: Quads::new() }
    }

    #[inline(always)]
    fn row<W: Width>(&self, i: usize, columns: &mut Columns, out: &mut [Single<4>]) {
        let Columns { near, pull } = columns;
        let [x, y, z, v_x, v_y, v_z, ..] = self.particle[i].0;
        let (x, own) = ([x, y, z], [v_x, v_y, v_z]);
        for (at, weight) in self.lists.liquid.row(i).chunks(BLOCK).zip(self.liquid.of(i)) {
            near.gather::<W>(self.particle, at);
            for (k, weight) in weight.iter().enumerate().take(whole(at.len())) {
                let apart = near.apart(&x, k);
                let closing = dot(&near.slower(&own, k), &apart);
                let size = weight * closing;
                pull.put(k, [size * apart[0], size * apart[1], size * apart[2], 0.5 * size * closing]);
            }
            let [x, y, z, taken] = pull.exchange::<W>(at, out);
            out[i].give([x, y, z, -taken]);
        }
        for (at, weight) in self.lists.wall.row(i).chunks(BLOCK).zip(self.wall.of(i)) {
            near.gather::<W>(self.image, at);
            for (k, weight) in weight.iter().enumerate().take(whole(at.len())) {
                let apart = near.apart(&x, k);
                let along = dot(&own, &apart);
                let size = weight * (along - dot(&near.velocity(k), &apart));
                // The wall stands still: all that its friction takes is heat.
                pull.put(k, [size * apart[0], size * apart[1], size * apart[2], size * along]);
            }
            let [x, y, z, taken] = pull.totals(at.len());
            out[i].give([x, y, z, -taken]);
        }
    }
}
