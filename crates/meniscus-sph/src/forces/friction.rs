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

use super::momentum::Momentum;
use crate::particles::blocks::{BLOCK, Column, PairSum, add, dot, gather, put, row, scatter, sum};
use crate::particles::{CHUNKS, Kernel, Neighbours, Particle};
use crate::walls::{Map, Walls};

/// Velocities or accelerations of all particles.
pub(crate) type Vectors = [[f64; 3]];

/// One listed pair: its weight, kg/m2/s, and its separation, m.
#[derive(Clone, Copy, Debug, Default)]
struct Link {
    weight: f64,
    apart: [f64; 3],
}

/// The operator at one instant, and its memory.
#[derive(Clone, Debug, Default)]
pub(crate) struct Friction {
    /// One for each listed pair of liquid particles, in the order of the list.
    liquid: Vec<Link>,
    /// One for each listed image of each particle.
    wall: Vec<Link>,
    /// From the velocities of the originals to those of their images.
    maps: Vec<Map>,
    /// Velocities of the images, m/s.
    rubbing: Vec<[f64; 3]>,
    buffers: Vec<Vec<[f64; 4]>>,
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
    pub(super) fn form(&mut self, pairs: &Momentum<'_>, mass: &[f64]) {
        let Momentum { kernel, lists, particle, walls, drag, soft, .. } = *pairs;
        let mut stiffness = vec![[0.0; 6]; particle.len()];
        self.liquid.clear();
        self.wall.clear();
        for (i, a) in particle.iter().enumerate() {
            for &j in lists.liquid.row(i) {
                let (j, b) = (j as usize, &particle[j as usize]);
                let link = Link::new(&kernel, soft, 0.5 * (drag[i] + drag[j]), [a, b]);
                self.liquid.push(link);
                link.stiffen(2.0, &mut stiffness[i]);
                link.stiffen(2.0, &mut stiffness[j]);
            }
            for &w in lists.wall.row(i) {
                let link = Link::new(&kernel, soft, drag[i], [a, &walls.image[w as usize]]);
                self.wall.push(link);
                link.stiffen(1.0 + share(&self.maps[w as usize]), &mut stiffness[i]);
            }
        }
        self.rate = stiffness.iter().zip(mass).map(|(s, m)| norm(s) / m).fold(0.0, f64::max);
    }

    /// Returns force (N, 3 numbers) and heat (W) of each particle at the velocities `v`.
    pub(crate) fn act(&mut self, lists: &Neighbours, walls: &Walls, v: &Vectors) -> &[[f64; 4]] {
        walls.mapped(&self.maps, |i| v[i], &mut self.rubbing);
        let Self { liquid, wall, rubbing, buffers, out, .. } = self;
        buffers.resize(CHUNKS, Vec::new());
        out.resize(v.len(), [0.0; 4]);
        let pairs = Links { lists, liquid, wall, rubbing, v };
        lists.sum(buffers, out, &pairs);
        out
    }
}

impl Link {
    fn new(kernel: &Kernel, soft: f64, drag: f64, [a, b]: [&Particle; 2]) -> Self {
        let apart: [f64; 3] = std::array::from_fn(|k| a.x[k] - b.x[k]);
        let r2 = dot(&apart, &apart);
        let weight = super::momentum::K * drag * a.volume * b.volume * kernel.slope(r2) / (r2 + soft);
        Self { weight, apart }
    }

    /// Adds the bound of what the pair takes from one of its particles.
    fn stiffen(&self, times: f64, to: &mut [f64; 6]) {
        let [x, y, z] = self.apart;
        let w = -times * self.weight;
        add(to, &[w * x * x, w * x * y, w * x * z, w * y * y, w * y * z, w * z * z]);
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
struct Links<'a> {
    lists: &'a Neighbours,
    liquid: &'a [Link],
    wall: &'a [Link],
    rubbing: &'a [[f64; 3]],
    v: &'a Vectors,
}

/// The columns of a block.
struct Columns {
    v: [Column; 3],
    mine: [Column; 4],
    theirs: [Column; 4],
}

impl PairSum<4> for Links<'_> {
    type Columns = Columns;

    fn columns(&self) -> Columns {
        let empty = [0.0; BLOCK];
        Columns { v: [empty; 3], mine: [empty; 4], theirs: [empty; 4] }
    }

    #[inline(always)]
    fn row(&self, i: usize, columns: &mut Columns, out: &mut [[f64; 4]]) {
        let Columns { v, mine, theirs } = columns;
        let own = &self.v[i];
        let links = &self.liquid[self.lists.liquid.range(i)];
        for (at, links) in self.lists.liquid.row(i).chunks(BLOCK).zip(links.chunks(BLOCK)) {
            gather(v, self.v, at);
            for (k, link) in links.iter().enumerate().take(BLOCK) {
                let other = row(v, k);
                let slower = [own[0] - other[0], own[1] - other[1], own[2] - other[2]];
                let closing = dot(&slower, &link.apart);
                let pull = link.weight * closing;
                let [x, y, z] = [pull * link.apart[0], pull * link.apart[1], pull * link.apart[2]];
                let heat = -0.5 * pull * closing;
                put(mine, k, [x, y, z, heat]);
                put(theirs, k, [-x, -y, -z, heat]);
            }
            scatter(theirs, at, out);
            add(&mut out[i], &sum(mine, at.len()));
        }
        let links = &self.wall[self.lists.wall.range(i)];
        for (at, links) in self.lists.wall.row(i).chunks(BLOCK).zip(links.chunks(BLOCK)) {
            gather(v, self.rubbing, at);
            for (k, link) in links.iter().enumerate().take(BLOCK) {
                let along = dot(own, &link.apart);
                let pull = link.weight * (along - dot(&row(v, k), &link.apart));
                // The wall stands still: all that its friction takes is heat.
                let [x, y, z] = [pull * link.apart[0], pull * link.apart[1], pull * link.apart[2]];
                put(mine, k, [x, y, z, -pull * along]);
            }
            add(&mut out[i], &sum(mine, at.len()));
        }
    }
}
