//! A contact line that is held by the wall: a spring that yields to dry friction.
//!
//! In each of 32 sectors of the wall the line has a deflection `z` from where it is held and moves with
//! the velocity `v` of the surface there (Dahl 1968; in the numbers of Viola, Brun and Gallaire 2018):
//! ```text
//! force per length  f = k z,        z' = v - |v| z/z_max
//! stored            k z^2/2,        heat  k |v| z^2/z_max >= 0          f v = (stored)' + heat
//! ```
//! with `k z_max = F` the value of the effect: the force of a line that slides, `sigma` times half the
//! difference of the cosines of the receding and the advancing angle. Small waves feel the spring alone,
//! which raises their frequency; large ones lose `F` times the path and stop in finite time. The update
//! is implicit, because the explicit one overshoots `z_max`, and solved together with the answer of the
//! liquid to the force (see `Wall::slow`):
//! ```text
//! z <- (z + dt v) / (1 + dt |v|/z_max)
//! ```

use super::laws::Line;
use super::waves::{COUNT, Coefficients, Square, Waves};

/// Sectors of the wall.
pub(super) const SECTORS: usize = 32;

/// The waves' values along the wall, one row a sector.
#[derive(Clone, Debug)]
pub(super) struct Wall {
    values: Vec<Coefficients>,
    /// Length of a sector, m.
    pub(super) length_m: f64,
}

impl Wall {
    /// The wall around a circle of radius `radius_m`.
    pub(super) fn new(radius_m: f64, waves: &Waves) -> Self {
        let turn = std::f64::consts::TAU / SECTORS as f64;
        let place = |k: usize| (turn * (k as f64 + 0.5)).sin_cos();
        let values = (0..SECTORS).map(place).map(|(sin, cos)| {
            let all = waves.at(radius_m * cos, radius_m * sin);
            Coefficients::from_fn(|j, _| all[j][0])
        });
        Self { values: values.collect(), length_m: turn * radius_m }
    }

    /// Velocity of the surface in each sector, m/s, from the rates of the waves.
    pub(super) fn velocity(&self, rate: &Coefficients) -> [f64; SECTORS] {
        std::array::from_fn(|s| self.values[s].dot(rate))
    }

    /// Returns the rates of the waves at which to evaluate, over a step `dt`, the force of a wall with the forces
    /// per length `bias + slope v`, which oppose `v`; `None` where there is no solution. With
    /// `X v = dt B q(slope v)` and `Y = dt B q(bias)`:
    /// ```text
    /// c'* = (1 + X + X^2)^-1 [ (1 + X) c' - X Y ]
    /// ```
    /// `B` is the answer of a liquid without pressure, so that the implicit step, `(1 + X)^-1 (c' - Y)`, is less than what
    /// the liquid will have: asked there, the wall loses `X` of its friction, and a spring relaxes at the rate
    /// `dt B k`. This keeps `c'` up to `X^2`, and is as stable: a spring alone has, with `a = X`, the step
    /// `z <- (1 - a Q) z + P dt v, dt v <- dt v - a z` of determinant `1 - a Q = (1 + a)/(1 + a + a^2)` and of trace
    /// `2 - a Q - a P > -2 + a Q`, with `P = (1 + a)/(1 + a + a^2)` and `Q = a/(1 + a + a^2)`.
    pub(super) fn slow(
        &self,
        rate: &Coefficients,
        mobility: &Square,
        dt: f64,
        law: &[[f64; 2]; SECTORS],
    ) -> Option<Coefficients> {
        let mut bias = Coefficients::zeros();
        let mut slope = Square::zeros();
        for (values, [b, s]) in self.values.iter().zip(law) {
            bias += values * (b * self.length_m);
            slope.ger(s * self.length_m, values, values, 1.0);
        }
        let x = mobility * slope * dt;
        let right = rate + x * (rate - mobility * bias * dt);
        (Square::identity() + x + x * x).lu().solve(&right)
    }

    /// Adds the generalised forces of a force per length (N/m) in each sector.
    pub(super) fn press(&self, force: &[f64; SECTORS], q: &mut Coefficients) {
        for (values, force) in self.values.iter().zip(force) {
            for j in 0..COUNT {
                q[j] += force * self.length_m * values[j];
            }
        }
    }
}

/// The held line.
#[derive(Clone, Debug)]
pub(super) struct ContactLine {
    stiffness: f64,
    reach_m: f64,
    z: [f64; SECTORS],
}

impl ContactLine {
    /// A line at rest that obeys `line`.
    pub(super) fn new(line: Line) -> Self {
        let Line { force_n_m, reach_m } = line;
        Self { stiffness: force_n_m / reach_m, reach_m, z: [0.0; SECTORS] }
    }

    /// Force per length as `bias + slope v` after a step `dt`, with the sliding at velocities `v`.
    pub(super) fn law(&self, dt: f64, v: &[f64; SECTORS]) -> [[f64; 2]; SECTORS] {
        std::array::from_fn(|s| {
            let over = self.stiffness / (1.0 + dt * v[s].abs() / self.reach_m);
            [over * self.z[s], over * dt]
        })
    }

    /// Moves the line for `dt` to where its force per length is `force`; returns the stored energy that it
    /// gains, J.
    pub(super) fn advance(&mut self, force: &[f64; SECTORS], length_m: f64) -> f64 {
        let before = self.stored(length_m);
        self.z = force.map(|force| force / self.stiffness);
        self.stored(length_m) - before
    }

    /// Stored energy, J.
    pub(super) fn stored(&self, length_m: f64) -> f64 {
        0.5 * self.stiffness * length_m * self.z.iter().map(|z| z * z).sum::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::super::columns::Columns;
    use super::*;
    use crate::particles::{Fluid, Particle};
    use meniscus::math::bessel_j;

    #[test]
    fn the_line_springs_then_slides_and_never_makes_energy() {
        let mut line = ContactLine::new(Line { force_n_m: 0.05, reach_m: 1e-3 });
        let (dt, length) = (1e-3, 0.01);
        let mut heat = 0.0;
        for step in 0..4000 {
            let v = [0.05 * (20.0 * dt * f64::from(step)).cos(); SECTORS];
            let law = line.law(dt, &v);
            let force: [f64; SECTORS] = std::array::from_fn(|s| law[s][0] + law[s][1] * v[s]);
            let work = dt * length * force.iter().zip(&v).map(|(f, v)| f * v).sum::<f64>();
            let part = work - line.advance(&force, length);
            assert!(part >= -1e-15, "{part} J of heat");
            heat += part;
            assert!(line.z.iter().all(|z| z.abs() <= 1e-3));
        }
        // Path 4 v/w a period; the work of friction alone is F times it.
        let path = 4.0 * 0.05 / 20.0 * (4.0 * 20.0 / std::f64::consts::TAU);
        let whole = 0.05 * path * length * SECTORS as f64;
        assert!((0.4..1.0).contains(&(heat / whole)), "{heat} J of {whole}");
        // A push of a tenth of the reach: the spring takes it.
        let line = ContactLine::new(Line { force_n_m: 0.05, reach_m: 1e-3 });
        let [bias, slope] = line.law(1e-3, &[0.1; SECTORS])[0];
        assert!((bias + slope * 0.1 - 50.0 * 1e-4 / 1.1).abs() < 1e-12);
    }

    #[test]
    fn the_velocity_is_kept_where_the_friction_is_weak_and_stopped_where_it_is_strong() {
        let wall = Wall::new(0.035, &Waves::new(0.035));
        let rate = Coefficients::from_fn(|j, _| if j == 2 { 0.1 } else { 0.0 });
        let lost = |friction: f64| {
            let law = [[0.0, friction]; SECTORS];
            let found = wall.slow(&rate, &Square::identity(), 1e-3, &law).expect("it is determined");
            1.0 - wall.velocity(&found)[0] / wall.velocity(&rate)[0]
        };
        // The three waves in cos phi are 1 at the wall: X is 3 dt friction pi R along their sum.
        let x = 3.0 * 1e-3 * 100.0 * std::f64::consts::PI * 0.035;
        assert!((lost(100.0) / (x * x) - 1.0).abs() < 0.05, "{} for {}", lost(100.0), x * x);
        assert!(lost(1e6) > 0.98, "{}", lost(1e6));
    }

    #[test]
    fn the_wall_knows_the_first_waves_for_what_they_are() {
        let radius = 0.035;
        let mut fluid = Fluid {
            particle: Vec::new(),
            mass: Vec::new(),
            density: Vec::new(),
            viscosity: Vec::new(),
            acceleration: Vec::new(),
            heat: Vec::new(),
        };
        let empty = Columns::new(radius, 1.0, &fluid);
        let (rings, turns) = (200, 64);
        for (m, xi, known) in
            [(1, 1.841_184, 1.0), (0, 3.831_706, 1.0), (2, 3.054_237, 1.0), (1, 11.706_005, 0.0)]
        {
            // Volumes eta dA of a surface that is the mode, one metre high at the wall.
            (fluid.particle, fluid.mass) = (Vec::new(), Vec::new());
            for cell in 0..rings * turns {
                let r = (f64::from(cell / turns) + 0.5) / f64::from(rings);
                let angle = std::f64::consts::TAU * f64::from(cell % turns) / f64::from(turns);
                let area = std::f64::consts::TAU * r * radius * radius / f64::from(rings * turns);
                let shape = bessel_j(m, xi * r) / bessel_j(m, xi) * (f64::from(m) * angle).cos();
                let x = [radius * r * angle.cos(), radius * r * angle.sin(), 0.0];
                fluid.particle.push(Particle { x, v: [0.0; 3], volume: 0.0, p: 0.0 });
                fluid.mass.push(shape * area);
            }
            let mut columns = empty.clone();
            columns.follow(&fluid);
            let seen = Wall::new(radius, &empty.waves).velocity(&columns.height)[0];
            let here = (f64::from(m) * std::f64::consts::PI / 32.0).cos();
            assert!((seen / here - known).abs() < 0.002, "({m},1): {} for {known}", seen / here);
        }
    }
}
