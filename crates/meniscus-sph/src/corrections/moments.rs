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

use crate::particles::tensor::Symmetric;
use crate::particles::{CHUNKS, Fluid, Kernel, Neighbours, Particle, pair, retain};
use crate::walls::Walls;

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
    buffers: Vec<Vec<[f64; NUMBERS]>>,
    sums: Vec<[f64; NUMBERS]>,
}

/// A neighbour in the sums of a particle.
#[derive(Clone, Copy)]
struct Term {
    /// Volume of the particle, m3.
    own: f64,
    /// Volume of the neighbour, m3.
    volume: f64,
    /// Its mass, kg.
    mass: f64,
    /// Slope `F` of the kernel at its distance.
    slope: f64,
    /// Value `W` of the kernel there.
    value: f64,
}

/// Adds `term` at the separation `d` with the relative velocity `v`.
#[inline]
fn add(sums: &mut [f64; NUMBERS], term: Term, d: &[f64; 3], v: &[f64; 3]) {
    let Term { own, volume, mass, slope, value } = term;
    let u = volume * slope;
    for (row, v) in sums[..9].chunks_exact_mut(3).zip(v) {
        let uv = u * v;
        for (s, d) in row.iter_mut().zip(d) {
            *s += uv * d;
        }
    }
    let ud = d.map(|d| u * d);
    let moments = [ud[0] * d[0], ud[0] * d[1], ud[0] * d[2], ud[1] * d[1], ud[1] * d[2], ud[2] * d[2]];
    for (s, m) in sums[9..15].iter_mut().zip(moments) {
        *s += m;
    }
    sums[15] += mass * value;
    for (s, d) in sums[16..19].iter_mut().zip(d) {
        *s += mass * value * d;
    }
    for (s, ud) in sums[19..22].iter_mut().zip(ud) {
        *s += ud;
    }
    sums[22] += own * slope * (moments[0] + moments[3] + moments[5]);
}

fn difference(a: &Particle, b: &Particle) -> [f64; 3] {
    [a.v[0] - b.v[0], a.v[1] - b.v[1], a.v[2] - b.v[2]]
}

impl Moments {
    /// Sums for `particles` particles, due at once.
    pub(crate) fn new(particles: usize) -> Self {
        Self {
            age_s: f64::INFINITY,
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
        image_density: impl Fn(f64) -> f64 + Sync,
    ) {
        let Fluid { particle, mass, .. } = liquid;
        lists.sum(&mut self.buffers, &mut self.sums, &|i: usize, out: &mut [[f64; NUMBERS]]| {
            let a = &particle[i];
            let mut own = [0.0; NUMBERS];
            own[15] = mass[i] * kernel.value(0.0);
            for &j in lists.liquid.row(i) {
                let j = j as usize;
                let b = &particle[j];
                let (d, r2, _) = pair(a, b);
                let v = difference(a, b);
                let term = Term {
                    own: a.volume,
                    volume: b.volume,
                    mass: mass[j],
                    slope: kernel.slope(r2),
                    value: kernel.value(r2),
                };
                add(&mut own, term, &d, &v);
                let term = Term { own: b.volume, volume: a.volume, mass: mass[i], ..term };
                add(&mut out[j], term, &d.map(|d| -d), &v.map(|v| -v));
            }
            for &w in lists.wall.row(i) {
                let b = &walls.image[w as usize];
                let (d, r2, _) = pair(a, b);
                let term = Term {
                    own: a.volume,
                    volume: b.volume,
                    mass: b.volume * image_density(b.p),
                    slope: kernel.slope(r2),
                    value: kernel.value(r2),
                };
                add(&mut own, term, &d, &difference(a, b));
            }
            for (o, s) in out[i].iter_mut().zip(own) {
                *o += s;
            }
        });
    }

    /// The sums as they were formed, one entry a particle.
    pub(crate) fn seen(&self) -> impl Iterator<Item = Seen> + Clone {
        self.sums.iter().map(|sums| Seen(*sums))
    }
}
