//! Action of a contact line, held or sliding under the first mode, on the second-order waves.
//!
//! Dry friction does not add up: where the first mode drags the line along, a small wave beside it finds a line that
//! is already sliding. Dahl's law, `z' = v - |v| z/reach`, about the first mode's way, sector by sector of the wall:
//! ```text
//! v = v1 + s',   |s'| << |v1|:     z' = (1 - sgn(v1) z1/reach) s' - |v1| z/reach
//! force on the wave j              -(f/reach) int z_j phi_j R dtheta,     phi_j = 1, cos 2 theta, sin 2 theta
//! ```
//! so the line is stiff where the first mode turns round, or stands still, and lets go in between. One that never slides
//! has no end of its reach.

use super::modes::{BOUND_WAVE_SHAPES, RADIAL};
use crate::math::{sincos, sqrt};
use core::f64::consts::TAU;

/// Sectors of the wall.
pub const SECTORS: usize = 16;

/// Contact line along the wall, in sectors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ContactLineFriction {
    /// Spring of one sector over the mass of each (0,n) and (2,n), 1/s2.
    pub square: [[f64; RADIAL]; 2],
    /// Deflection of the contact line at which it slides, m.
    pub reach_m: f64,
    /// Cosine and sine of the middle of each sector.
    turn: [[f64; 2]; SECTORS],
}

/// One sector during a step.
#[derive(Clone, Copy, Debug, Default)]
struct Sector {
    /// Shapes of the waves here.
    shape: [f64; BOUND_WAVE_SHAPES],
    /// Deflection in the middle of the step without the motion of the waves, m.
    caught: f64,
    /// Change of the deflection with the speed of the waves, s.
    gives: f64,
}

/// The contact line as the first mode drags it, along x and y.
#[derive(Clone, Copy, Debug)]
pub(super) struct Dragged {
    /// Speed of the liquid at the wall, m/s.
    pub(super) speed: [f64; 2],
    /// Deflection of the line, m.
    pub(super) held: [f64; 2],
}

/// The sectors during a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sliding([Sector; SECTORS]);

impl ContactLineFriction {
    /// A line whose spring along the wall is `spring` N/m2 and which slides after `reach_m`, in a glass of
    /// `radius_m`, beside waves of `mass_kg`.
    #[must_use]
    pub(super) fn new(spring: f64, reach_m: f64, radius_m: f64, mass_kg: [[f64; RADIAL]; 2]) -> Self {
        let width = TAU / SECTORS as f64;
        let turn = core::array::from_fn(|i| {
            let (sin, cos) = sincos(width * (i as f64 + 0.5));
            [cos, sin]
        });
        Self {
            square: mass_kg.map(|row| row.map(|m| spring * radius_m * width / m)),
            reach_m: reach_m.max(1e-9),
            turn,
        }
    }

    /// Returns the sectors during a step of `dt` beside the first mode `first`, where the other waves deflect the line by
    /// `caught` (m).
    pub(super) fn slide(&self, dt: f64, caught: &[f64; SECTORS], first: &Dragged) -> Sliding {
        let Dragged { speed, held } = first;
        let mut sectors = [Sector::default(); SECTORS];
        let way = |pair: &[f64; 2], [cos, sin]: [f64; 2]| pair[0] * cos + pair[1] * sin;
        let whole = sqrt(held[0] * held[0] + held[1] * held[1]);
        for (slot, (turn, caught)) in sectors.iter_mut().zip(self.turn.iter().zip(caught)) {
            let (v, z) = (way(speed, *turn), way(held, *turn));
            // All of the line is caught as far as its foremost point, on the side that it has come to.
            let full = (whole / self.reach_m).min(1.0) * if v * z < 0.0 { -1.0 } else { 1.0 };
            let catch = 1.0 + 0.5 * dt * v.abs() / self.reach_m;
            let [cos, sin] = *turn;
            *slot = Sector {
                shape: [1.0, cos * cos - sin * sin, 2.0 * sin * cos],
                caught: caught / catch,
                gives: 0.5 * dt * (1.0 - full) / catch,
            };
        }
        Sliding(sectors)
    }
}

impl Sliding {
    /// Pull on a wave of shape `j` by sectors of one unit of spring, without what it does by its `own` rate, and what its
    /// own rate adds; `rates` of all waves in the middle of the step, m/s.
    pub(super) fn pull(&self, j: usize, own: f64, rates: &[[f64; RADIAL]; BOUND_WAVE_SHAPES]) -> [f64; 2] {
        let mut sum = [0.0; 2];
        let mut all = totals(rates);
        all.iter_mut().skip(j).take(1).for_each(|rate| *rate -= own);
        for sector in &self.0 {
            let shape = sector.shape.get(j).copied().unwrap_or(0.0);
            sum[0] += shape * (sector.caught + sector.gives * sector.moved(&all));
            sum[1] += shape * shape * sector.gives;
        }
        sum
    }

    /// Moves what is `caught` to the end of the step at the `rates` of its middle.
    pub(super) fn finish(&self, caught: &mut [f64; SECTORS], rates: &[[f64; RADIAL]; BOUND_WAVE_SHAPES]) {
        let all = totals(rates);
        for (caught, sector) in caught.iter_mut().zip(&self.0) {
            *caught = 2.0 * (sector.caught + sector.gives * sector.moved(&all)) - *caught;
        }
    }
}

impl Sector {
    /// Rate of the waves here that have the rates `all` in each shape, m/s.
    fn moved(&self, all: &[f64; BOUND_WAVE_SHAPES]) -> f64 {
        self.shape.iter().zip(all).map(|(shape, rate)| shape * rate).sum()
    }
}

/// Rates at the wall in each shape, m/s.
fn totals(rates: &[[f64; RADIAL]; BOUND_WAVE_SHAPES]) -> [f64; BOUND_WAVE_SHAPES] {
    rates.map(|row| row.iter().sum())
}

#[cfg(test)]
#[allow(clippy::disallowed_methods, reason = "a test may take the platform's functions")]
mod tests {
    use super::*;

    const DT: f64 = 1e-4;

    fn rim() -> ContactLineFriction {
        ContactLineFriction::new(60.0, 5e-4, 0.035, [[0.044; RADIAL], [0.02; RADIAL]])
    }

    /// Returns the deflection of every sector after the ring has moved by `way` m beside a first mode at `speed` m/s
    /// whose contact line is deflected by `held` m.
    fn caught_by(way: f64, speed: f64, held: f64) -> [f64; SECTORS] {
        let mut caught = [0.0; SECTORS];
        let mut rates = [[0.0; RADIAL]; BOUND_WAVE_SHAPES];
        rates[0][0] = way / (1000.0 * DT);
        for _ in 0..1000 {
            rim()
                .slide(DT, &caught, &Dragged { speed: [speed, 0.0], held: [held, 0.0] })
                .finish(&mut caught, &rates);
        }
        caught
    }

    #[test]
    fn a_line_at_rest_is_a_spring_all_round() {
        let caught = caught_by(1e-5, 0.0, 0.0);
        assert!(caught.iter().all(|z| (z / 1e-5 - 1.0).abs() < 1e-9), "{caught:?}");
        // 2 pi R f/reach on the ring, and nothing on the saddles.
        let sliding = rim().slide(DT, &caught, &Dragged { speed: [0.0; 2], held: [0.0; 2] });
        let still = [[0.0; RADIAL]; BOUND_WAVE_SHAPES];
        let [ring, saddle] = [0, 1].map(|j| rim().square[j][0] * sliding.pull(j, 0.0, &still)[0]);
        assert!((ring / (TAU * 0.035 * 60.0 / 0.044 * 1e-5) - 1.0).abs() < 1e-9, "{ring}");
        assert!(saddle.abs() < 1e-9 * ring, "{saddle}");
    }

    #[test]
    fn a_line_that_is_dragged_along_lets_go_of_the_small_waves() {
        // Slid as far as it goes, in the first mode's way: a wave beside it is not caught.
        let ahead = |caught: [f64; SECTORS]| caught[0].abs();
        assert!(ahead(caught_by(1e-5, 0.1, 5e-4)) < 1e-12);
        // Turned round: caught twice as fast, and lost again after a reach.
        assert!((ahead(caught_by(1e-7, -1e-7, 5e-4)) / 2e-7 - 1.0).abs() < 1e-3);
        let mut caught = [1e-5; SECTORS];
        let steps = (5e-4 / 0.1 / DT) as usize;
        for _ in 0..steps {
            let still = [[0.0; RADIAL]; BOUND_WAVE_SHAPES];
            rim()
                .slide(DT, &caught, &Dragged { speed: [0.1, 0.0], held: [5e-4, 0.0] })
                .finish(&mut caught, &still);
        }
        let cos = (TAU / 32.0).cos();
        assert!((caught[0] / (1e-5 * (-cos).exp()) - 1.0).abs() < 1e-3, "{}", caught[0]);
    }
}
