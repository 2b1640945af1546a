//! The layer at the wall, in time: a column of cells beside the wall, through which momentum diffuses.
//!
//! ```text
//! rho q_t = tau_y,     tau = eta(|q_y|) q_y + G xi,     xi_t = q_y - xi/lambda,     V + q = b q_y at the wall
//! ```
//! q is the velocity of the liquid along the wall less that of potential flow V. A Newtonian liquid on a wall that sticks has Stokes's
//! layer (Stokes 1851). Steps are implicit, with eta at the state before.

use super::glass::Liquid;

/// Cells of a column, the first cell in thicknesses of Stokes's layer, and by how much the next one is thicker.
const CELLS: usize = 26;
const FIRST: f64 = 0.06;
const GROWTH: f64 = 1.14;

/// A column of cells beside the wall.
#[derive(Clone, Debug)]
pub struct Layer {
    /// Velocity less that of potential flow, m/s, from the wall outwards.
    missing: [f64; CELLS],
    /// Strain that the liquid remembers on the inner face of each cell.
    remembered: [f64; CELLS],
    /// Thickness of each cell, m.
    thick_m: [f64; CELLS],
}

impl Layer {
    /// Returns a column at rest for a layer that is `thickness_m` thick.
    #[must_use]
    pub fn new(thickness_m: f64) -> Self {
        let thick_m = std::array::from_fn(|i| FIRST * thickness_m * GROWTH.powi(i as i32));
        Self { missing: [0.0; CELLS], remembered: [0.0; CELLS], thick_m }
    }

    /// Advances it by `dt` seconds beside potential flow of `speed` (m/s) and returns the stress on the wall, Pa.
    pub fn advance(&mut self, liquid: &Liquid, speed: f64, dt: f64) -> f64 {
        let fade = 1.0 + dt / liquid.relaxation_s;
        // Distance over which the shear on the inner face of a cell is taken.
        let apart = |i: usize| match i {
            0 => 0.5 * self.thick_m[0] + liquid.slip_m,
            _ => 0.5 * (self.thick_m[i - 1] + self.thick_m[i]),
        };
        let shear = |missing: &[f64; CELLS], i: usize| match i {
            0 => (speed + missing[0]) / apart(0),
            _ => (missing[i] - missing[i - 1]) / apart(i),
        };
        // Stress on the inner face: `stiff shear + held`.
        let stiff: [f64; CELLS] = std::array::from_fn(|i| {
            liquid.viscosity(shear(&self.missing, i).abs()) + liquid.modulus_pa * dt / fade
        });
        let held: [f64; CELLS] = std::array::from_fn(|i| liquid.modulus_pa * self.remembered[i] / fade);
        // Tridiagonal: cell i has the faces i and i + 1, and beyond the last cell nothing is missing.
        let (mut upper, mut right) = ([0.0; CELLS], [0.0; CELLS]);
        let face = |i: usize| {
            if i < CELLS { stiff[i] / apart(i) } else { stiff[CELLS - 1] / self.thick_m[CELLS - 1] }
        };
        for i in 0..CELLS {
            let weight = dt / (liquid.density_kg_m3 * self.thick_m[i]);
            let (inner, outer) = (weight * face(i), weight * face(i + 1));
            let pushed = if i + 1 < CELLS { held[i + 1] } else { 0.0 } - held[i];
            let wall = if i == 0 { inner * speed } else { 0.0 };
            let lower = if i == 0 { 0.0 } else { inner };
            let pivot = 1.0 + inner + outer - if i == 0 { 0.0 } else { lower * upper[i - 1] };
            upper[i] = outer / pivot;
            let before = if i == 0 { 0.0 } else { lower * right[i - 1] };
            right[i] = (self.missing[i] + weight * pushed - wall + before) / pivot;
        }
        let mut next = 0.0;
        for i in (0..CELLS).rev() {
            next = right[i] + upper[i] * next;
            self.missing[i] = next;
        }
        let sheared: [f64; CELLS] = std::array::from_fn(|i| shear(&self.missing, i));
        for (remembered, shear) in self.remembered.iter_mut().zip(sheared) {
            *remembered = (*remembered + dt * shear) / fade;
        }
        stiff[0] * sheared[0] + held[0]
    }
}

#[cfg(test)]
mod tests {
    use super::super::glass::Liquid;
    use super::*;
    use std::f64::consts::TAU;

    /// Returns the parts of the stress on the wall in phase and a quarter ahead, over `mu U/delta`.
    fn impedance(liquid: &Liquid, frequency: f64) -> [f64; 2] {
        let delta = (2.0 * liquid.consistency / (liquid.density_kg_m3 * frequency)).sqrt();
        let mut layer = Layer::new(delta);
        let steps = 4000;
        let dt = TAU / frequency / f64::from(steps);
        let mut sums = [0.0; 2];
        for n in 0..6 * steps {
            let phase = frequency * dt * f64::from(n + 1);
            let stress = layer.advance(liquid, phase.cos(), dt);
            if n >= 5 * steps {
                sums[0] += stress * phase.cos();
                sums[1] -= stress * phase.sin();
            }
        }
        sums.map(|sum| 2.0 * sum / f64::from(steps) * delta / liquid.consistency)
    }

    #[test]
    fn a_layer_has_the_impedance_of_stokes_and_of_a_wall_that_slips() {
        let liquid = Liquid { consistency: 0.05, ..Liquid::plain(0.05) };
        let [resists, stores] = impedance(&liquid, 21.0);
        // tau = (1 + i) mu U/delta.
        assert!((resists - 1.0).abs() < 0.02 && (stores - 1.0).abs() < 0.02, "{resists} {stores}");
        // (1 + i)/(1 + (1 + i) s) with s = b/delta.
        let delta = (2.0 * 0.05 / (liquid.density_kg_m3 * 21.0)).sqrt();
        let [resists, stores] = impedance(&Liquid { slip_m: delta, ..liquid }, 21.0);
        assert!((resists - 0.6).abs() < 0.02 && (stores - 0.2).abs() < 0.02, "{resists} {stores}");
    }
}
