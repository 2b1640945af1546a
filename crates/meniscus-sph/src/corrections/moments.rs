//! Moments of the neighbourhood of a particle: sums over its neighbours that change as slowly as the flow does, so that they are
//! formed every few milliseconds and hold until the next time.
//!
//! With `x = x_i - x_j`, `v = v_i - v_j`, `V = m/rho`, `grad W = F x`:
//! ```text
//! velocity   R_i = -sum_j V_j F v (x) x        moments   N_i = -sum_j V_j F x (x) x        (1 in the bulk)
//! positions  s_i =  sum_j m_j W                          m_i = -sum_j m_j W x              (itself among them)
//! sound      b_i =  sum_j V_j F x                        k_i =  sum_j V_i V_j F^2 x.x
//! ```
//! [`super::corrected`] makes exact gradients of `N`, [`super::smooth`] the smooth part of the velocity of `R` and `N`,
//! [`super::positions`] a density of `s` and `m`, [`super::corrected`] how fast a particle swings of `b` and `k`.

use crate::particles::blocks::{BLOCK, LAST, PairSum, Panel, VOLUME, add, dot, whole};
use crate::particles::lanes::{Single, Width, row};
use crate::particles::tensor::Symmetric;
use crate::particles::{CHUNKS, Fluid, Kernel, Neighbours, retain};
use crate::walls::Walls;
use rayon::prelude::*;

/// Lifetime of the sums, s: a seventieth of the first mode of the glass of the recordings.
const HOLD_S: f64 = 0.004;

/// Lifetime in a splash, s: neighbours that part with 1 m/s are a fifth of a spacing farther apart.
const SPLASH_HOLD_S: f64 = 0.001;

/// Numbers of one particle.
pub(crate) const NUMBERS: usize = 23;

/// The sums of one particle, with the minus signs still to come: `R` (9, rows by component of the velocity), `N` (6), `s`
/// kg/m3, `m` (3) kg/m2, `b` (3) 1/m, `k` 1/m2.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seen(pub(crate) [f64; NUMBERS]);

impl Seen {
    /// `R`, 1/s, rows by component of the velocity.
    pub(crate) fn velocity(&self) -> [f64; 9] {
        std::array::from_fn(|k| -self.0[k])
    }

    /// `N`.
    pub(crate) fn moments(&self) -> Symmetric {
        std::array::from_fn(|k| -self.0[9 + k])
    }

    /// `s`, kg/m3.
    pub(crate) fn density(&self) -> f64 {
        self.0[15]
    }

    /// `|m|/s`, m.
    pub(crate) fn offset(&self) -> f64 {
        let [x, y, z] = [self.0[16], self.0[17], self.0[18]];
        (x * x + y * y + z * z).sqrt() / self.0[15]
    }

    /// `b`, 1/m.
    pub(crate) fn lean(&self) -> [f64; 3] {
        [self.0[19], self.0[20], self.0[21]]
    }

    /// `k`, 1/m2.
    pub(crate) fn stiffness(&self) -> f64 {
        self.0[22]
    }
}

/// The sums and the memory to form them.
#[derive(Clone, Debug)]
pub(crate) struct Moments {
    /// Time since they were formed, s.
    age_s: f64,
    /// The particles with their masses in place of their pressures.
    particle: Vec<Single<8>>,
    /// The images, as well.
    image: Vec<Single<8>>,
    buffers: Vec<Vec<Single<24>>>,
    sums: Vec<[f64; NUMBERS]>,
}

/// Inputs of the sums.
struct Sums<'a> {
    kernel: Kernel<f32>,
    lists: &'a Neighbours,
    particle: &'a [Single<8>],
    image: &'a [Single<8>],
}

/// The columns of a block.
struct Columns {
    near: Panel<f32>,
    /// Sums for the neighbours.
    theirs: [Panel<f32>; 3],
    /// Sums from them.
    mine: [Panel<f32>; 3],
}

/// Column of the mass, where a particle has its pressure.
const MASS: usize = LAST;

/// The terms of a sum: of a neighbour of volume `volume` and mass `mass` at the separation `d`, which approaches with `v`, in the
/// sums of one of volume `own`, with slope and value of the kernel.
#[inline(always)]
fn terms(
    [own, volume, mass]: [f32; 3],
    [slope, value]: [f32; 2],
    d: &[f32; 3],
    v: &[f32; 3],
) -> [[f32; 8]; 3] {
    let u = volume * slope;
    let [x, y, z] = *d;
    let [uv, vv, wv] = [u * v[0], u * v[1], u * v[2]];
    let [ux, uy, uz] = [u * x, u * y, u * z];
    let moments = [ux * x, ux * y, ux * z, uy * y, uy * z, uz * z];
    let heavy = mass * value;
    let stiffness = own * slope * (moments[0] + moments[3] + moments[5]);
    [
        [uv * x, uv * y, uv * z, vv * x, vv * y, vv * z, wv * x, wv * y],
        [wv * z, moments[0], moments[1], moments[2], moments[3], moments[4], moments[5], heavy],
        [heavy * x, heavy * y, heavy * z, ux, uy, uz, stiffness, 0.0],
    ]
}

impl Sums<'_> {
    /// Fills `mine` with what the gathered rows give a particle, `theirs` with what they get.
    #[inline(always)]
    fn fill<const BOTH: bool>(&self, a: &[f32; 8], rows: usize, columns: &mut Columns) {
        let Columns { near, theirs, mine } = columns;
        let (x, v) = ([a[0], a[1], a[2]], [a[3], a[4], a[5]]);
        for k in 0..whole(rows) {
            let (d, v) = (near.apart(&x, k), near.slower(&v, k));
            let r2 = dot(&d, &d);
            let kernel = [self.kernel.slope(r2), self.kernel.value(r2)];
            let (volume, mass) = (near.0[VOLUME][k], near.0[MASS][k]);
            let to_me = terms([a[VOLUME], volume, mass], kernel, &d, &v);
            // Loops, since a closure would not be compiled for wide vectors.
            for (mine, numbers) in mine.iter_mut().zip(to_me) {
                mine.put(k, numbers);
            }
            if BOTH {
                let to_them = terms([volume, a[VOLUME], a[MASS]], kernel, &d.map(|d| -d), &v.map(|v| -v));
                for (theirs, numbers) in theirs.iter_mut().zip(to_them) {
                    theirs.put(k, numbers);
                }
            }
        }
    }
}

impl PairSum<24> for Sums<'_> {
    type Columns = Columns;

    fn columns(&self) -> Columns {
        Columns { near: Panel::new(), theirs: [Panel::new(); 3], mine: [Panel::new(); 3] }
    }

    #[inline(always)]
    fn row<W: Width>(&self, i: usize, columns: &mut Columns, out: &mut [Single<24>]) {
        let a = &self.particle[i].0;
        let mut own = [[0.0; 8]; 3];
        own[1][7] = a[MASS] * self.kernel.value(0.0);
        for at in self.lists.liquid.row(i).chunks(BLOCK) {
            columns.near.gather::<W>(self.particle, at);
            self.fill::<true>(a, at.len(), columns);
            for (part, panel) in columns.theirs.iter().enumerate() {
                panel.scatter::<W, 24>(at, out, part);
            }
            for (own, mine) in own.iter_mut().zip(&columns.mine) {
                add(own, &mine.totals::<W>(at.len()));
            }
        }
        for at in self.lists.wall.row(i).chunks(BLOCK) {
            columns.near.gather::<W>(self.image, at);
            self.fill::<false>(a, at.len(), columns);
            for (own, mine) in own.iter_mut().zip(&columns.mine) {
                add(own, &mine.totals::<W>(at.len()));
            }
        }
        for (to, own) in out[i].0.as_chunks_mut().0.iter_mut().zip(&own) {
            add(to, own);
        }
    }
}

impl Moments {
    /// Sums for `particles` particles, due at once.
    pub(crate) fn new(particles: usize) -> Self {
        Self {
            age_s: f64::INFINITY,
            particle: Vec::new(),
            image: Vec::new(),
            buffers: vec![Vec::new(); CHUNKS],
            sums: vec![[0.0; NUMBERS]; particles],
        }
    }

    /// Keeps the particles that are in `keep`.
    pub(crate) fn retain(&mut self, keep: &[bool]) {
        retain(&mut self.sums, keep);
    }

    /// Whether they are due after a further step of `dt` seconds, in a splash or not.
    pub(crate) fn due(&mut self, dt: f64, splash: bool) -> bool {
        self.age_s += dt;
        let life_s = if splash { SPLASH_HOLD_S } else { HOLD_S };
        // Half a step before is nearer than half a step after.
        let due = life_s - self.age_s < 0.5 * dt;
        if due {
            self.age_s = 0.0;
        }
        due
    }

    /// Forms the sums of the present state; `image_density` gives the density of an image of a pressure.
    pub(crate) fn form(
        &mut self,
        kernel: &Kernel,
        lists: &Neighbours,
        liquid: &Fluid,
        walls: &Walls,
        image_density: impl Fn(f64) -> f64,
    ) {
        let Self { particle, image, buffers, sums, .. } = self;
        particle.clear();
        particle.extend(liquid.particle.iter().zip(&liquid.mass).map(|(p, m)| row(p, *m)));
        image.clear();
        image.extend(walls.image.iter().map(|p| row(p, p.volume * image_density(p.p))));
        lists.sum(buffers, sums, &Sums { kernel: kernel.single(), lists, particle, image });
    }

    /// The sums as they were formed, one entry a particle.
    pub(crate) fn seen(&self) -> impl IndexedParallelIterator<Item = Seen> + Clone {
        self.sums.par_iter().map(|sums| Seen(*sums))
    }
}
