//! The books of energy, in the frame of the glass.
//!
//! ```text
//! kinetic   = sum 1/2 m v^2
//! potential = sum m ( -g0.x + c0^2 [ ln(rho/rho0) + rho0/rho - 1 ] )  minus its value at rest,
//!             and what the effects store
//! internal  = sum m heat            (viscosity, the diffusion of density, friction of effects)
//! work      = integral of sum m (f - g0).v dt
//! spilled   = what left with liquid over the rim (see `spill`)
//! closure   = kinetic + potential + internal + spilled - work    -> 0
//! ```
//! with `f` the body force of `frame` and `g0` its value while the glass rests.

use crate::Simulator;
use meniscus_data::recording::EnergyBook;

impl Simulator {
    /// Potential energy of gravity and of weak compression, J, from the bottom and the rest density.
    pub(crate) fn potential(&self) -> f64 {
        let (c2, rest) = (self.forces.sound * self.forces.sound, self.forces.rest_density);
        let parts = self.fluid.particle.iter().zip(&self.fluid.mass).zip(&self.fluid.density);
        let [g_x, _, g_z] = self.gravity;
        parts
            .map(|((p, m), rho)| {
                m * (-g_z * p.x[2] - g_x * p.x[0] + c2 * ((rho / rest).ln() + rest / rho - 1.0))
            })
            .sum()
    }

    /// The books at the present time.
    #[must_use]
    pub fn energy(&self) -> EnergyBook {
        let parts = || self.fluid.particle.iter().zip(&self.fluid.mass);
        EnergyBook {
            kinetic: parts()
                .map(|(p, m)| 0.5 * m * (p.v[0] * p.v[0] + p.v[1] * p.v[1] + p.v[2] * p.v[2]))
                .sum(),
            potential: self.potential() - self.rest_energy + self.acting.stored(&self.fluid),
            internal: self.fluid.heat.iter().zip(&self.fluid.mass).map(|(e, m)| e * m).sum(),
            work: self.work,
            spilled: self.spilled.energy_j,
        }
    }
}

/// Returns the closure error of the energy balance, J.
#[must_use]
pub fn closure(book: &EnergyBook) -> f64 {
    book.kinetic + book.potential + book.internal + book.spilled - book.work
}

/// Largest closure error over the largest energy of the slosh (kinetic + potential); 0 at rest.
#[must_use]
pub fn relative_closure(books: &[EnergyBook]) -> f64 {
    let largest = |f: fn(&EnergyBook) -> f64| books.iter().map(|b| f(b).abs()).fold(0.0, f64::max);
    let slosh = largest(|b| b.kinetic + b.potential);
    if slosh > 0.0 { largest(closure) / slosh } else { 0.0 }
}
