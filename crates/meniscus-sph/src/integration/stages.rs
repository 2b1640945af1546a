//! A step of friction in stages, as long as the step of sound, however thick the liquid is.
//!
//! ```text
//! v' = a + A v        over dt, from v_0,   a all other accelerations,   A of `forces::friction`
//! ```
//! by the stages of [`crate::forces::Factors`]. No system has to be solved, so that nothing hangs on a tolerance, and where friction balances
//! the other forces every stage stands still, so that a liquid that creeps or rests does so as with short steps.
//!
//! The step in time kicks from `v(t - dt/2)` to `v(t + dt/2)`: what the stages reach, less `v(t - dt/2)`, over `dt`, is the
//! acceleration `k` of that kick. What its friction `k - a` takes from the kinetic energy is booked as heat by each half of the kick,
//! ```text
//! heat = -dt/2 sum_i m_i (k - a)_i.(v + dt/4 k)_i
//! ```
//! and shared among the particles as the pairs dissipate at the velocities of the stages, each for the part of the step that it stands for.

use crate::forces::{Factors, Friction, nearest_part, needed};
use crate::particles::{Fluid, Neighbours, PIECE};
use crate::walls::Walls;
use rayon::prelude::*;

/// Memory of the stages.
#[derive(Clone, Debug, Default)]
pub(crate) struct Stages {
    start: Vec<[f64; 3]>,
    rate: Vec<[f64; 3]>,
    before: Vec<[f64; 3]>,
    last: Vec<[f64; 3]>,
    /// Mean acceleration by friction over the kick, m/s2.
    friction: Vec<[f64; 3]>,
    /// Heat of the friction of each particle over the step, W.
    power: Vec<f64>,
    /// Part of the heat of the friction that a kilogram of each particle gains, 1/kg.
    shares: Vec<f64>,
}

impl Stages {
    /// Adds the mean acceleration by friction over the kick of `dt` to the accelerations of `fluid`, which hold all others.
    pub(crate) fn rub(
        &mut self,
        dt: f64,
        friction: &mut Friction,
        lists: &Neighbours,
        walls: &Walls,
        fluid: &mut Fluid,
    ) {
        let stages = needed(dt * friction.largest_rate());
        let Self { start, rate, before, last, friction: pull, power, shares } = self;
        let Fluid { particle, mass, acceleration, .. } = &mut *fluid;
        start.clear();
        start.extend(particle.iter().map(|p| p.v));
        let slope =
            |f: &[f64; 4], m: f64, a: &[f64; 3]| -> [f64; 3] { std::array::from_fn(|k| a[k] + f[k] / m) };
        let (first, part) = (Factors::first(stages) * dt, nearest_part(0, stages));
        rate.clear();
        last.clear();
        power.clear();
        let found = friction.act(lists, walls, start);
        for ((f, v), (m, a)) in found.iter().zip(&*start).zip(mass.iter().zip(&*acceleration)) {
            let r = slope(f, *m, a);
            last.push(std::array::from_fn(|k| v[k] + first * r[k]));
            rate.push(r);
            power.push(part * f[3]);
        }
        before.clone_from(start);
        for j in 2..=stages {
            let found = friction.act(lists, walls, last);
            let (f, part) = (Factors::of(j, stages), nearest_part(j - 1, stages));
            let rest = 1.0 - f.last - f.before;
            let ends = start.par_iter().zip(&*rate).zip(&*last);
            let own = found.par_iter().zip(&*mass).zip(&*acceleration);
            let parts = before.par_iter_mut().zip(&mut *power).zip(ends).zip(own).with_min_len(PIECE);
            parts.for_each(|(((before, power), ((start, rate), last)), ((friction, m), a))| {
                let slope = slope(friction, *m, a);
                for k in 0..3 {
                    before[k] = f.last * last[k]
                        + f.before * before[k]
                        + rest * start[k]
                        + dt * (f.rate * slope[k] + f.first_rate * rate[k]);
                }
                *power += part * friction[3];
            });
            std::mem::swap(before, last);
        }
        pull.clear();
        for (a, (start, last)) in acceleration.iter_mut().zip(start.iter().zip(&*last)) {
            let kick: [f64; 3] = std::array::from_fn(|k| (last[k] - start[k]) / dt);
            pull.push(std::array::from_fn(|k| kick[k] - a[k]));
            *a = kick;
        }
        let whole: f64 = power.iter().sum();
        let all: f64 = mass.iter().sum();
        shares.clear();
        // At rest nothing dissipates, and what is booked is nothing but rounding.
        let share = |(power, m): (&f64, &f64)| if whole > 0.0 { power / (whole * m) } else { 1.0 / all };
        shares.extend(power.iter().zip(&*mass).map(share));
    }

    /// Books the heat of half a kick that the liquid is about to take, for `half` a step.
    pub(crate) fn warm(&self, half: f64, fluid: &mut Fluid) {
        let Fluid { particle, mass, heat, acceleration, .. } = fluid;
        let parts = particle.iter().zip(&*mass).zip(&*acceleration).zip(&self.friction);
        let power = parts
            .map(|(((p, m), a), f)| m * (0..3).map(|k| f[k] * (p.v[k] + 0.5 * half * a[k])).sum::<f64>());
        let taken = -half * power.sum::<f64>();
        for (heat, share) in heat.iter_mut().zip(&self.shares) {
            *heat += taken * share;
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::setup::small_glass;
    use crate::validate::Mode;
    use crate::{Setup, Simulator, closure};
    use meniscus_data::liquids::Rheology;
    use meniscus_data::motion::Kinematics;

    /// A small glass of a liquid with a yield stress.
    fn plastic() -> Setup {
        small_glass(1261.0, Rheology { consistency: 0.2, index: 1.0, yield_stress: 3.0, largest: 60.0 })
    }

    #[test]
    fn the_operator_is_the_friction_of_the_momentum_sum_and_no_faster_than_its_bound() {
        let mut simulator = Simulator::new(&plastic()).expect("the glass settles");
        let mode = Mode::first(simulator.glass);
        simulator.set_velocity(|x| mode.velocity(x).map(|v| 0.1 * v));
        let Simulator { forces, lists, walls, fluid, glass, sticking, .. } = &mut simulator;
        let mut friction = forces.friction.take().expect("this liquid is thick");
        // Without pressures the sum is friction alone.
        fluid.particle.iter_mut().chain(&mut walls.image).for_each(|p| p.p = 0.0);
        forces.forces(lists, fluid, walls, glass, *sticking, 0.0);
        let v: Vec<[f64; 3]> = fluid.particle.iter().map(|p| p.v).collect();
        let found = friction.act(lists, walls, &v).to_vec();
        let largest = found.iter().map(|f| f[0].abs()).fold(0.0, f64::max);
        for (found, due) in found.iter().zip(&forces.force) {
            for (k, (found, due)) in found.iter().zip(due).enumerate() {
                // Rounding of single precision.
                assert!((found - due).abs() < 1e-6 * largest, "{found} for {due}, number {k}");
            }
        }
        // The largest rate by power iteration.
        let mut v: Vec<[f64; 3]> =
            (0..v.len()).map(|i| [0, 1, 2].map(|k| (7.3 * i as f64 + f64::from(k)).sin())).collect();
        let mut rate = 0.0;
        for _ in 0..200 {
            let size = v.iter().flatten().map(|v| v * v).sum::<f64>().sqrt();
            v.iter_mut().flatten().for_each(|v| *v /= size);
            let next = friction.act(lists, walls, &v).iter().zip(&fluid.mass);
            v = next.map(|(f, m)| [-f[0] / m, -f[1] / m, -f[2] / m]).collect();
            rate = v.iter().flatten().map(|v| v * v).sum::<f64>().sqrt();
        }
        let bound = friction.largest_rate();
        println!("{rate} 1/s of at most {bound}");
        assert!(rate < bound && rate > 0.3 * bound, "{rate} 1/s of at most {bound}");
    }

    #[test]
    fn long_steps_in_stages_ring_as_short_explicit_ones_do() {
        let end = |staged: bool| {
            let mut simulator = Simulator::new(&plastic()).expect("the glass settles");
            let mode = Mode::first(simulator.glass);
            if !staged {
                simulator.forces.friction = None;
                simulator.dt *= 0.1;
            }
            simulator.set_velocity(|x| mode.velocity(x).map(|v| 0.3 * v));
            let start = simulator.energy().kinetic;
            let mut series = Vec::new();
            while simulator.time_s() < 0.12 {
                simulator.step_moving(|_| Kinematics::default()).expect("it stays in the glass");
                series.push((simulator.time_s(), simulator.energy().kinetic / start));
            }
            (series, closure(&simulator.energy()) / start, simulator.fluid.heat)
        };
        let (long, books, warmed) = end(true);
        let (short, _, due) = end(false);
        assert!(long.len() * 9 < short.len(), "{} and {} steps", long.len(), short.len());
        let mut worst = 0.0_f64;
        for (t, kinetic) in &long {
            let near = short.partition_point(|(at, _)| at < t).min(short.len() - 1);
            worst = worst.max((kinetic.sqrt() - short[near].1.sqrt()).abs());
        }
        println!("{worst} of the first speed apart; books off by {books}");
        assert!(worst < 0.02, "speeds are {worst} of the first apart");
        assert!(books.abs() < 1e-3, "the books are off by {books}");
        // Each particle has the heat that it has with short steps; shared evenly, it would be further off.
        let off =
            |of: &dyn Fn(usize) -> f64| (0..due.len()).map(|i| (of(i) - due[i]).powi(2)).sum::<f64>().sqrt();
        let mean = due.iter().sum::<f64>() / due.len() as f64;
        let (apart, even) = (off(&|i| warmed[i]) / off(&|_| 0.0), off(&|_| mean) / off(&|_| 0.0));
        println!("heats are {apart} apart, and {even} if all had the same");
        assert!(apart < 0.02 && even > 0.5, "heats are {apart} apart, and {even} if all had the same");
    }
}
