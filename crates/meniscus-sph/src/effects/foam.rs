//! Foam on the surface: its films rub along the wall (Bretherton 1961 for one film, force ~ Ca^(2/3);
//! Sauret et al. 2015 and Viola et al. 2016, Foam on troubled water, for foam on a slosh).
//!
//! ```text
//! force per length  f = beta v (v^2 + e^2)^(-1/6)  ->  beta |v|^(2/3),       heat  f v >= 0
//! ```
//! `v` is the velocity of the surface at the wall, `e` = 1 mm/s keeps the slope finite at rest. The
//! coefficient gathers surface tension, viscosity and the number of films,
//! `beta ~ sigma (mu/sigma)^(2/3) films`. An envelope under it obeys `A' = -gamma A - f A^(2/3)` and ends
//! in finite time. The foam's weight and its damping of the free surface away from the wall are left out.

use super::contact_line::SECTORS;

/// Velocity below which the law is linear, m/s.
const LINEAR_M_S: f64 = 1e-3;

/// Foam along the wall.
#[derive(Clone, Copy, Debug)]
pub(super) struct Foam {
    /// Coefficient beta, N/m (s/m)^(2/3).
    pub(super) beta: f64,
}

impl Foam {
    /// Force per length over velocity at velocities `v`, N s/m2; the force is this times `v`.
    pub(super) fn slope(self, v: &[f64; SECTORS]) -> [f64; SECTORS] {
        v.map(|v| self.beta * (v * v + LINEAR_M_S * LINEAR_M_S).powf(-1.0 / 6.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_force_grows_with_the_power_two_thirds() {
        let force = |v: f64| v * Foam { beta: 0.2 }.slope(&[v; SECTORS])[0];
        assert!((force(0.8) / force(0.1) - 4.0).abs() < 1e-3);
        assert!((force(-0.1) / -0.2 - 0.1_f64.powf(2.0 / 3.0)).abs() < 1e-4);
        assert_eq!(force(0.0), 0.0);
    }
}
