//! The waves at many places, side by side: a column for each profile, so that one formula runs down the places in vectors as
//! wide as the processor's. Each place gets the bits of [`Waves::at`].

use super::waves::{COUNT, Coefficients, NUMBERS, Place, RADIAL, Waves};
use crate::particles::Particle;
use crate::particles::blocks::{BLOCK, Column, Panel, whole};
use crate::particles::lanes::{Row, Width, Work, widest};

/// Columns of the waves.
const PARTS: usize = COUNT / 8;

/// The profiles of the waves at the places of a block.
struct Profiles {
    columns: [Panel; NUMBERS / 8],
    cos: Column,
    sin: Column,
}

/// One wave in a block: value, slope and `m` times the value over the radius, times its azimuth and the derivative of that.
struct One<'a> {
    number: usize,
    profile: [&'a Column; 3],
    order: f64,
    azimuth: &'a Column,
    turned: &'a Column,
}

impl One<'_> {
    /// Value at place `k`.
    #[inline(always)]
    fn value(&self, k: usize) -> f64 {
        self.profile[0][k] * self.azimuth[k]
    }

    /// Slopes along x and y at place `k`, 1/m.
    #[inline(always)]
    fn slope(&self, k: usize, cos: f64, sin: f64) -> [f64; 2] {
        let along = self.profile[1][k] * self.azimuth[k];
        let around = self.order * self.profile[2][k] * self.turned[k];
        [along * cos - around * sin, along * sin + around * cos]
    }
}

impl Profiles {
    fn new() -> Self {
        Self { columns: std::array::from_fn(|_| Panel::new()), cos: [0.0; BLOCK], sin: [0.0; BLOCK] }
    }

    /// Takes the profiles at `places`.
    #[inline(always)]
    fn take<W: Width>(&mut self, waves: &Waves, places: &[Place]) {
        for ((place, cos), sin) in places.iter().zip(&mut self.cos).zip(&mut self.sin) {
            (*cos, *sin) = (place.cos, place.sin);
        }
        for (eight, places) in places.chunks(8).enumerate().take(BLOCK / 8) {
            let mut rows = [Row([0.0; NUMBERS]); 8];
            for (row, place) in rows.iter_mut().zip(places) {
                let (low, high) = (&waves.table[place.step].0, &waves.table[place.step + 1].0);
                for ((to, low), high) in row.0.iter_mut().zip(low).zip(high) {
                    *to = low + place.part * (high - low);
                }
            }
            for (part, panel) in self.columns.iter_mut().enumerate() {
                let from = rows.each_ref().map(|row| &row.0.as_chunks().0[part]);
                W::transpose(from, panel.eight_mut(eight));
            }
        }
    }

    /// Calls `visit` with each wave of the first `rows` places.
    #[inline(always)]
    fn each(&self, rows: usize, mut visit: impl FnMut(One<'_>)) {
        let column = |number: usize| &self.columns[number / 8].0[number % 8];
        // cos m phi and sin m phi.
        let (mut even, mut odd, mut back) = ([1.0; BLOCK], [0.0; BLOCK], [0.0; BLOCK]);
        let (mut number, mut profile) = (0, 0);
        for (m, count) in RADIAL.into_iter().enumerate() {
            for (back, odd) in back.iter_mut().zip(&odd) {
                *back = -odd;
            }
            for _ in 0..count {
                let profile_of = [column(3 * profile), column(3 * profile + 1), column(3 * profile + 2)];
                let one = |number, azimuth, turned| One {
                    number,
                    profile: profile_of,
                    order: m as f64,
                    azimuth,
                    turned,
                };
                visit(one(number, &even, &back));
                if m > 0 {
                    visit(one(number + 1, &odd, &even));
                }
                number += 1 + m.min(1);
                profile += 1;
            }
            for k in 0..whole(rows) {
                let (cos, sin) = (self.cos[k], self.sin[k]);
                (even[k], odd[k]) = (even[k] * cos - odd[k] * sin, even[k] * sin + odd[k] * cos);
            }
        }
    }
}

/// The waves weighed with what moves in them.
pub(super) struct Weigh<'a> {
    pub(super) waves: &'a Waves,
    pub(super) rest_density: f64,
    pub(super) particles: &'a [Particle],
    pub(super) masses: &'a [f64],
    /// Is filled with the places of the particles.
    pub(super) places: &'a mut [Place],
    /// Gets `M`, m3.
    pub(super) sums: &'a mut Coefficients,
    /// Gets its rate, m3/s, where a caller wants it.
    pub(super) rates: Option<&'a mut Coefficients>,
}

impl Weigh<'_> {
    /// Adds up.
    pub(super) fn run(self) {
        widest(self);
    }
}

impl Work for Weigh<'_> {
    #[inline(always)]
    fn run<W: Width>(self) {
        let Weigh { waves, rest_density, particles, masses, places, sums, mut rates } = self;
        let mut profiles = Profiles::new();
        let (mut volume, mut v) = ([0.0; BLOCK], [[0.0; BLOCK]; 2]);
        let mut terms = [Panel::new(); PARTS];
        let mut all = [[[0.0; 8]; PARTS]; 2];
        let parts = particles.chunks(BLOCK).zip(masses.chunks(BLOCK)).zip(places.chunks_mut(BLOCK));
        for ((particles, masses), places) in parts {
            for (k, ((p, m), place)) in particles.iter().zip(masses).zip(&mut *places).enumerate().take(BLOCK)
            {
                *place = waves.place(p.x[0], p.x[1]);
                (volume[k], v[0][k], v[1][k]) = (m / rest_density, p.v[0], p.v[1]);
            }
            profiles.take::<W>(waves, places);
            let rows = places.len();
            profiles.each(rows, |one| {
                let term = &mut terms[one.number / 8].0[one.number % 8];
                for k in 0..whole(rows) {
                    term[k] = volume[k] * one.value(k);
                }
            });
            terms.iter().zip(&mut all[0]).for_each(|(terms, all)| terms.sum::<W>(rows, all));
            if rates.is_some() {
                profiles.each(rows, |one| {
                    let term = &mut terms[one.number / 8].0[one.number % 8];
                    for k in 0..whole(rows) {
                        let [x, y] = one.slope(k, profiles.cos[k], profiles.sin[k]);
                        term[k] = volume[k] * (x * v[0][k] + y * v[1][k]);
                    }
                });
                terms.iter().zip(&mut all[1]).for_each(|(terms, all)| terms.sum::<W>(rows, all));
            }
        }
        sums.as_mut_slice().copy_from_slice(all[0].as_flattened());
        if let Some(rates) = &mut rates {
            rates.as_mut_slice().copy_from_slice(all[1].as_flattened());
        }
    }
}

/// A pressure on the surface, and the accelerations that stand for it.
pub(super) struct Press<'a> {
    pub(super) waves: &'a Waves,
    pub(super) rest_density: f64,
    /// The pressure by its waves, Pa.
    pub(super) pressure: &'a Coefficients,
    pub(super) places: &'a [Place],
    /// Is filled with the pressure (Pa) and the accelerations along x and y (m/s2) at the places.
    pub(super) out: &'a mut [[f64; 3]],
}

impl Press<'_> {
    /// Adds up.
    pub(super) fn run(self) {
        widest(self);
    }
}

impl Work for Press<'_> {
    #[inline(always)]
    fn run<W: Width>(self) {
        let Press { waves, rest_density, pressure, places, out } = self;
        let mut profiles = Profiles::new();
        for (places, out) in places.chunks(BLOCK).zip(out.chunks_mut(BLOCK)) {
            profiles.take::<W>(waves, places);
            let mut sums = [[0.0; BLOCK]; 3];
            let rows = places.len();
            profiles.each(rows, |one| {
                let p = pressure[one.number];
                let [value, x, y] = &mut sums;
                for k in 0..whole(rows) {
                    let [along_x, along_y] = one.slope(k, profiles.cos[k], profiles.sin[k]);
                    value[k] += p * one.value(k);
                    x[k] += p * along_x;
                    y[k] += p * along_y;
                }
            });
            let [value, x, y] = &sums;
            for (out, ((value, x), y)) in out.iter_mut().zip(value.iter().zip(x).zip(y)) {
                *out = [*value, -x / rest_density, -y / rest_density];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_places_have_the_bits_of_each() {
        let waves = Waves::new(0.035);
        let particle = |k: usize| {
            let (turn, r) = (2.4 * k as f64, 0.0352 * (k as f64 / 99.0).sqrt());
            Particle { x: [r * turn.cos(), r * turn.sin(), 0.0], v: [0.3, -0.1, 0.0], volume: 1.0, p: 0.0 }
        };
        let particles: Vec<Particle> = (0..100).map(particle).collect();
        let masses: Vec<f64> = (0..100).map(|k| 1e-4 + 1e-6 * f64::from(k)).collect();
        let pressure = Coefficients::from_fn(|j, _| 3.0 - j as f64);
        let (mut due, mut due_rates) = (Coefficients::zeros(), Coefficients::zeros());
        let mut due_out = Vec::new();
        for (p, m) in particles.iter().zip(&masses) {
            let mut out = [0.0; 3];
            for (j, value) in waves.at(p.x[0], p.x[1]).iter().enumerate() {
                due[j] += m / 998.0 * value[0];
                due_rates[j] += m / 998.0 * (value[1] * p.v[0] + value[2] * p.v[1]);
                out.iter_mut().zip(value).for_each(|(out, value)| *out += pressure[j] * value);
            }
            due_out.push([out[0], -out[1] / 998.0, -out[2] / 998.0]);
        }
        let (mut sums, mut rates) = (Coefficients::zeros(), Coefficients::zeros());
        let mut places = vec![Place::default(); 100];
        Weigh {
            waves: &waves,
            rest_density: 998.0,
            particles: &particles,
            masses: &masses,
            places: &mut places,
            sums: &mut sums,
            rates: Some(&mut rates),
        }
        .run();
        assert_eq!((sums, rates), (due, due_rates));
        let mut out = vec![[0.0; 3]; 100];
        Press { waves: &waves, rest_density: 998.0, pressure: &pressure, places: &places, out: &mut out }
            .run();
        assert_eq!(out, due_out);
    }
}
