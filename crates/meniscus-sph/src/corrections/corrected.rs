//! Corrected gradients: exact for what is linear in space, up to the free surface.
//!
//! A plain gradient lacks the neighbours above a free surface: it takes the divergence of a flow that grows linearly
//! with height for a part of what it is, over the support of the kernel below the surface. The surface of a short wave
//! then yields too easily (second mode 12 % too slow at 5 mm). With `N` of [`super::moments`]
//! ```text
//! L_i = (N_i^4 + E^4)^-1 (N_i^3 + E^4)      -> N_i^-1
//! continuity   rho_i' = rho_i tr( L_i sum_j V_j F x (x) v )
//! momentum     m_i v_i' = -sum_j V_i V_j (p_i L_i + p_j L_j) F x
//! ```
//! (Bonet and Lok 1999, Comput. Methods Appl. Mech. Eng. 180, 97) pressure and continuity stay conjugate, so that the pairs
//! still exchange energy exactly, but for rounding. `E` keeps `L` finite where neighbours are few: 1 for a lone drop, and `N^-1` to
//! 1 part in 100 at a flat surface, where the least eigenvalue of `N` is about a half. Liquid that stands at the rim or above, where no
//! wall completes it, keeps the plain gradient: its edges would swing up under the step of the rest.
//!
//! A particle that moves alone by `xi` changes its own density by `rho (L_i b_i).xi` and that of its neighbour `j` by
//! `rho V_i F (L_j x).xi`. Their pressures push it back, so that it swings with
//! ```text
//! omega_i^2 = c^2 ( |L_i b_i|^2 + sum_j V_i V_j F^2 |L_j x|^2 )  ~  c^2 ( |L_i b_i|^2 + |L_i|^2 k_i/3 ),   |L| by Frobenius
//! ```
//! with `b` and `k` of [`super::moments`]. In a splash, where few neighbours stand close, this is faster than sound between layers.
//!
//! What they cost: such a density follows the flow and no longer the positions of the particles, and has to be called back to
//! them ([`super::positions`]).

use super::moments::Seen;
use crate::particles::blocks::dot;
use crate::particles::lanes::Single;
use crate::particles::tensor::{Symmetric, UNIT, times};
use crate::particles::{LIGHT, Particle, retain};
use nalgebra::Matrix3;
use rayon::prelude::*;

/// `E`.
const SOFT: f64 = 0.2;

/// The matrices `L`, and what the pressure makes of them.
#[derive(Clone, Debug)]
pub(crate) struct Corrected {
    /// `L` of every particle.
    pub(crate) l: Vec<Symmetric>,
    /// `L` of every particle (6), then the pressure on the surface above it, Pa.
    pub(crate) pressed: Vec<Single<8>>,
    /// `p L` of every particle, Pa (6), then its `c_i mu_i`, Pa s.
    pub(crate) pressure: Vec<Single<8>>,
}

/// `L` from `N`.
fn inverse(n: &Symmetric) -> Symmetric {
    let n = Matrix3::new(n[0], n[1], n[2], n[1], n[3], n[4], n[2], n[4], n[5]);
    let soft = Matrix3::identity() * SOFT.powi(4);
    let square = n * n;
    // Positive definite, so that it has an inverse.
    (square * square + soft).try_inverse().map_or(UNIT, |inverse| {
        let l = inverse * (square * n + soft);
        [l[(0, 0)], l[(0, 1)], l[(0, 2)], l[(1, 1)], l[(1, 2)], l[(2, 2)]]
    })
}

impl Corrected {
    /// Unit matrices for `particles` particles.
    pub(crate) fn new(particles: usize) -> Self {
        Self {
            l: vec![UNIT; particles],
            pressed: vec![Single::default(); particles],
            pressure: vec![Single::default(); particles],
        }
    }

    /// Keeps the particles that are in `keep`.
    pub(crate) fn retain(&mut self, keep: &[bool]) {
        retain(&mut self.l, keep);
        retain(&mut self.pressed, keep);
        retain(&mut self.pressure, keep);
    }

    /// Takes `L` from what the particles see; of those higher than `highest_m` it is the unit matrix.
    pub(crate) fn update(
        &mut self,
        seen: impl IndexedParallelIterator<Item = Seen>,
        particle: &[Particle],
        highest_m: f64,
    ) {
        let all = self.l.par_iter_mut().zip(seen).zip(particle).with_min_len(128);
        all.for_each(|((l, seen), p)| {
            *l = if p.x[2] > highest_m { UNIT } else { inverse(&seen.moments()) };
        });
    }

    /// Returns the largest `omega` of all particles, 1/s, in a liquid of the speed of sound `sound` m/s.
    pub(crate) fn fastest(&self, seen: impl IndexedParallelIterator<Item = Seen>, sound: f64) -> f64 {
        let square = |(l, seen): (&Symmetric, Seen)| {
            let lean = times(l, &seen.lean());
            let [xx, xy, xz, yy, yz, zz] = *l;
            let norm2 = xx * xx + yy * yy + zz * zz + 2.0 * (xy * xy + xz * xz + yz * yz);
            dot(&lean, &lean) + norm2 / 3.0 * seen.stiffness()
        };
        sound * self.l.par_iter().zip(seen).with_min_len(512).map(square).reduce(|| 0.0, f64::max).sqrt()
    }

    /// Fills `pressure` from the present pressures and `drag`, `c_i mu_i` of every particle.
    pub(crate) fn weigh(&mut self, particle: &[Particle], drag: &[f64]) {
        let parts = self.pressure.par_iter_mut().zip(&self.l).zip(particle).zip(drag).with_min_len(LIGHT);
        parts.for_each(|(((out, l), p), drag)| {
            let [xx, xy, xz, yy, yz, zz] = l.map(|l| p.p * l);
            *out = Single::of([xx, xy, xz, yy, yz, zz, *drag, 0.0]);
        });
    }

    /// Fills `pressed` from what presses on the surface above each particle; `above` is empty where nothing does.
    pub(crate) fn press(&mut self, above: &[[f64; 3]]) {
        let parts = self.pressed.par_iter_mut().zip(&self.l).enumerate().with_min_len(LIGHT);
        parts.for_each(|(i, (out, [xx, xy, xz, yy, yz, zz]))| {
            let above = above.get(i).map_or(0.0, |[p, ..]| *p);
            *out = Single::of([*xx, *xy, *xz, *yy, *yz, *zz, above, 0.0]);
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::forces::Forces;
    use crate::frame::Body;
    use crate::particles::{Box3, Fluid, Kernel, Neighbours};
    use crate::walls::{Sticking, Walls};
    use meniscus_data::glass::WallShape;
    use meniscus_data::motion::Kinematics;
    use meniscus_data::recording::Glass;

    const GLASS: Glass = Glass { radius_m: 9.0, fill_m: 7.0, rim_m: 9.0, wall: WallShape::UPRIGHT };

    /// A block of 7^3 particles with uneven positions that move with `flow` and have the pressure `p`, and its sums.
    fn block(flow: impl Fn([f64; 3]) -> [f64; 3], p: impl Fn(usize) -> f64) -> (Fluid, Forces) {
        let particle = (0..343_usize).map(|k| {
            let place = [k % 7, k / 7 % 7, k / 49].map(|n| n as f64);
            let x: [f64; 3] = std::array::from_fn(|d| place[d] + 0.1 * (k as f64 * (1.7 + d as f64)).sin());
            Particle { x, v: flow(x), volume: 1.0, p: p(k) }
        });
        let fluid = Fluid {
            particle: particle.collect(),
            mass: vec![1.0; 343],
            density: vec![1.0; 343],
            viscosity: vec![0.0; 343],
            acceleration: vec![[0.0; 3]; 343],
            heat: vec![0.0; 343],
        };
        let lists = Neighbours::new(&fluid.particle, &[], Box3 { low: [-1.0; 3], high: [8.0; 3] }, 2.8, 0.1);
        let mut forces = Forces::new(Kernel::new(1.4), 7.0, 1.0, 343);
        let mut walls = Walls::default();
        let sticking = Sticking::new(&GLASS, 0.0, |_| [0.0; 2]);
        forces.forces(&lists, &fluid, &mut walls, &GLASS, sticking, 1e-4);
        forces.density_rates(&lists, &fluid, &walls, &Body::of(&Kinematics::default()));
        forces.forces(&lists, &fluid, &mut walls, &GLASS, sticking, 1e-4);
        (fluid, forces)
    }

    #[test]
    fn a_linear_flow_has_its_divergence_up_to_the_surface() {
        let g = [[0.3, -0.2, 0.5], [0.1, 0.4, -0.6], [-0.7, 0.2, 0.1]];
        let flow = |x: [f64; 3]| g.map(|row| row.iter().zip(x).map(|(g, x)| g * x).sum::<f64>());
        let (_, forces) = block(flow, |_| 0.0);
        // The middles of the six faces have half of their neighbours; the density falls as the volume grows.
        for face in [24, 318, 168, 174, 150, 192] {
            assert!((forces.rate[face][0] / -0.8 - 1.0).abs() < 0.02, "{}", forces.rate[face][0]);
            assert!(forces.rate[face][2] < 2.4, "particle {face} sees {} of 3", forces.rate[face][2]);
        }
    }

    #[test]
    fn what_the_pressure_does_to_the_pairs_is_what_it_takes_from_compression() {
        let jumble = |k: f64| (12.9 * k).sin();
        let flow = |x: [f64; 3]| x.map(|c| jumble(x[0] + 3.1 * x[1] + 7.3 * x[2] + c));
        let (fluid, forces) = block(flow, |k| 5.0 + jumble(k as f64));
        let (mut power, mut size) = (0.0, 0.0);
        for ((p, force), rate) in fluid.particle.iter().zip(&forces.force).zip(&forces.rate) {
            let kinetic: f64 = p.v.iter().zip(force).map(|(v, f)| v * f).sum();
            power += kinetic + force[3] + p.p * p.volume * rate[0];
            size += kinetic.abs();
        }
        // Rounding of single precision.
        assert!(power.abs() < 1e-8 * size, "{power} of {size}");
    }

    #[test]
    fn a_particle_that_moves_alone_swings_as_fast_as_it_is_said_to() {
        let rest = block(|_| [0.0; 3], |_| 0.0).1;
        let sound2 = rest.sound * rest.sound;
        let mut largest = 0.0_f64;
        // One particle after the other moves along each axis; its density rates are pressures of the next instant.
        for i in (0..343).step_by(29).chain([171, 24]) {
            let rates: [[f64; 3]; 3] = std::array::from_fn(|axis| {
                let (mut fluid, mut forces) = block(|_| [0.0; 3], |_| 0.0);
                fluid.particle[i].v[axis] = 1.0;
                let space = Box3 { low: [-1.0; 3], high: [8.0; 3] };
                let lists = Neighbours::new(&fluid.particle, &[], space, 2.8, 0.1);
                let (mut walls, still) = (Walls::default(), Body::of(&Kinematics::default()));
                forces.density_rates(&lists, &fluid, &walls, &still);
                for (p, rate) in fluid.particle.iter_mut().zip(&forces.rate) {
                    (p.v, p.p) = ([0.0; 3], sound2 * rate[0]);
                }
                let sticking = Sticking::new(&GLASS, 0.0, |_| [0.0; 2]);
                forces.forces(&lists, &fluid, &mut walls, &GLASS, sticking, 1e-9);
                std::array::from_fn(|k| -forces.force[i][k])
            });
            let square = Matrix3::from_fn(|row, column| 0.5 * (rates[row][column] + rates[column][row]));
            largest = largest.max(square.symmetric_eigenvalues().max().sqrt());
        }
        println!("{largest} 1/s for {} of all", rest.fastest);
        assert!(largest < rest.fastest && largest > 0.5 * rest.fastest, "{largest} for {}", rest.fastest);
    }

    #[test]
    fn a_lone_drop_has_the_unit_matrix_and_few_neighbours_a_bounded_one() {
        assert_eq!(inverse(&[0.0; 6]), UNIT);
        let largest = (0..=100).map(|k| inverse(&[0.01 * f64::from(k), 0.0, 0.0, 1.0, 0.0, 1.0])[0]);
        let largest = largest.fold(0.0, f64::max);
        assert!(largest < 3.6, "{largest}");
        let half = inverse(&[0.5, 0.0, 0.0, 1.0, 0.0, 1.0]);
        assert!((half[0] / 2.0 - 1.0).abs() < 0.015 && (half[3] - 1.0).abs() < 1e-12, "{half:?}");
    }
}
