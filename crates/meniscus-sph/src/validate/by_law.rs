//! The first mode of a liquid whose viscosity depends on the rate of shear, in the time domain.
//!
//! The velocities of [`super::viscous`] carry the liquid's own law, in place of one viscosity:
//! ```text
//! M c' + C(c) c + K x = 0,    x' = c,         u = c in the basis,    x: its displacement
//! C_ij = int mu(rate)/rho 2 D(v_i):D(v_j) dV,          rate^2 = 2 D(u):D(u)
//! ```
//! The viscosity is taken at every place and instant, so that the wall layer has the profile of the law. (One equivalent viscosity
//! that dissipates as much in the layer of a Newtonian liquid, by Krylov and Bogoliubov 1937, makes the decay of `k rate^0.5` 4 to
//! 7 % larger.) Of the stress only the part that drives one azimuthal period is kept: the third harmonic, which the
//! law also excites, is left out, and so is all that is not linear in the wave. Steps follow the midpoint rule with `C` extrapolated to the
//! middle.

use super::theory::Mode;
use super::viscous::{COARSE, Problem};
use meniscus::units::GRAVITY_M_S2;
use meniscus_data::liquids::Rheology;
use meniscus_data::recording::Glass;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::FRAC_PI_2;

/// Points around a quarter of the glass; the squares of strain repeat from there on.
const AROUND: usize = 6;

/// Step, s. Half of it changes the decay of `k rate^0.5` by 0.1 %.
const STEP_S: f64 = 2e-3;

/// A liquid that sticks to the walls of its glass, and its law.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scene {
    pub(super) glass: Glass,
    pub(super) density_kg_m3: f64,
    pub(super) rheology: Rheology,
}

/// One instant of a ringing.
#[derive(Clone, Copy, Debug)]
pub(super) struct Instant {
    /// Time, s.
    pub(super) time_s: f64,
    /// Modal momentum as a part of that of the inviscid mode at the start.
    pub(super) momentum: f64,
    /// Root of the kinetic energy as a part of the same.
    pub(super) speed: f64,
}

/// Lets the inviscid first mode of `speed_m_s` at the top of the wall ring in `scene` for `seconds`, from a flat surface.
///
/// Returns `None` where a number is not finite.
pub(super) fn ring_by_law(scene: &Scene, speed_m_s: f64, seconds: f64) -> Option<Vec<Instant>> {
    let Scene { glass, density_kg_m3, rheology } = *scene;
    // Without dimension by R and sqrt(g/R), as the problem is.
    let (radius, rate) = (glass.radius_m, (GRAVITY_M_S2 / glass.radius_m).sqrt());
    let (unit_m_s, unit_pa_s) = (radius * rate, density_kg_m3 * radius * radius * rate);
    let problem = Problem::new(glass.fill_m / radius, 0.0, COARSE);
    let mode = Mode::first(glass);
    let inviscid = problem.field(|r, z| {
        let (r, z) = (r * radius, z * radius);
        // (U, V, W): the azimuth of zero has U and W, a right angle has V along -x.
        let [u, _, w] = mode.velocity([r, 0.0, z]);
        [u, -mode.velocity([0.0, r, z])[0], w].map(|v| v * speed_m_s / unit_m_s)
    });
    let onto = problem.velocity.tr_mul(&inviscid);
    let whole = inviscid.norm_squared();
    let mut velocity = problem.mass.clone().cholesky()?.solve(&onto);
    let mut displacement = DVector::zeros(velocity.len());
    let mut before = velocity.clone();
    let dt = STEP_S * rate;
    let mut series = Vec::new();
    for step in 0..=(seconds / STEP_S).ceil() as usize {
        series.push(Instant {
            time_s: STEP_S * step as f64,
            momentum: onto.dot(&velocity) / whole,
            speed: (velocity.dot(&(&problem.mass * &velocity)) / whole).sqrt(),
        });
        let middle = &velocity * 1.5 - &before * 0.5;
        let friction = friction(&problem, &middle, |strain| rheology.viscosity(strain * rate) / unit_pa_s);
        let left = &problem.mass + friction * (0.5 * dt) + &problem.stiffness * (0.25 * dt * dt);
        let right = &problem.mass * &velocity - &problem.stiffness * &displacement * (0.5 * dt);
        let halfway = left.cholesky()?.solve(&right);
        displacement += &halfway * dt;
        before = velocity;
        velocity = halfway * 2.0 - &before;
    }
    Some(series)
}

/// `C` at the velocity `c`, for a viscosity over density as a function of the rate of shear.
fn friction(problem: &Problem, c: &DVector<f64>, viscosity: impl Fn(f64) -> f64) -> DMatrix<f64> {
    let strain = &problem.strain * c;
    let mut scaled = problem.strain.clone();
    for (node, weight) in problem.weights.iter().enumerate() {
        // rr, aa, zz, rz go with the cosine of the azimuth, ra and az with its sine.
        let square = |k: usize| strain[6 * node + k].powi(2) / weight;
        let even = square(0) + square(1) + square(2) + square(4);
        let odd = square(3) + square(5);
        let (mut with_cos, mut with_sin) = (0.0, 0.0);
        for around in 0..AROUND {
            let (sin, cos) = (FRAC_PI_2 * (around as f64 + 0.5) / AROUND as f64).sin_cos();
            let mu = viscosity((even * cos * cos + odd * sin * sin).sqrt());
            // The mean of a square of either is one half.
            with_cos += 2.0 * mu * cos * cos / AROUND as f64;
            with_sin += 2.0 * mu * sin * sin / AROUND as f64;
        }
        for k in 0..6 {
            let mu = if matches!(k, 3 | 5) { with_sin } else { with_cos };
            scaled.row_mut(6 * node + k).scale_mut(mu);
        }
    }
    problem.strain.tr_mul(&scaled)
}

#[cfg(test)]
mod tests {
    use super::super::fit::fit;
    use super::super::viscous::viscous_mode;
    use super::*;
    use meniscus_data::glass::WallShape;
    use std::f64::consts::TAU;

    const GLASS: Glass = Glass { radius_m: 0.035, fill_m: 0.07, rim_m: 0.11, wall: WallShape::UPRIGHT };

    fn ring(rheology: Rheology, speed_m_s: f64) -> Vec<(f64, f64)> {
        let scene = Scene { glass: GLASS, density_kg_m3: 1261.0, rheology };
        let series = ring_by_law(&scene, speed_m_s, 0.5).expect("finite numbers");
        series.iter().map(|instant| (instant.time_s, instant.momentum)).collect()
    }

    #[test]
    fn a_newtonian_liquid_rings_as_its_eigenvalue_says() {
        let theory = viscous_mode(&GLASS, 0.95 / 1261.0, true).expect("it oscillates");
        let series = ring(Rheology::newtonian(0.95), 0.2);
        let found = fit(&series[100..], theory, &[]).expect("it is determined").tone;
        println!("{found:?} for {theory:?}");
        assert!((found.hz / theory.hz - 1.0).abs() < 0.01, "{found:?} for {theory:?}");
        assert!((found.decay / theory.decay - 1.0).abs() < 0.02, "{found:?} for {theory:?}");
    }

    #[test]
    fn friction_takes_as_much_power_as_the_stress_around_the_whole_glass() {
        let problem = Problem::new(2.0, 0.0, COARSE);
        let c = DVector::from_fn(problem.mass.nrows(), |i, _| (i as f64).sin() / (1.0 + i as f64));
        let thinning = |rate: f64| (1e-3 + rate).powf(-0.5);
        let power = c.dot(&(friction(&problem, &c, thinning) * &c));
        // int mu(rate) rate^2 over the section, the mean of the whole turn counted twice.
        let strain = &problem.strain * &c;
        let points = 720;
        let mut around = 0.0;
        for (node, weight) in problem.weights.iter().enumerate() {
            for point in 0..points {
                let (sin, cos) = (TAU * f64::from(point) / f64::from(points)).sin_cos();
                let by = [cos, cos, cos, sin, cos, sin];
                let rate2: f64 = (0..6).map(|k| (strain[6 * node + k] * by[k]).powi(2) / weight).sum();
                around += 2.0 * weight * thinning(rate2.sqrt()) * rate2 / f64::from(points);
            }
        }
        assert!((power / around - 1.0).abs() < 1e-3, "{power} for {around}");
    }
}
