//! State of the liquid. Its images in the walls are of the same type (see `walls`).

/// Particle as its neighbours need it: one cache line.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub(crate) struct Particle {
    /// Position in the frame of the glass, metres.
    pub(crate) x: [f64; 3],
    /// Velocity in the frame of the glass, m/s.
    pub(crate) v: [f64; 3],
    /// Volume m / rho, m3.
    pub(crate) volume: f64,
    /// Pressure, Pa.
    pub(crate) p: f64,
}

/// The liquid: particles and what only they themselves need.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Fluid {
    /// Position, velocity, volume, pressure.
    pub(crate) particle: Vec<Particle>,
    /// Mass, kg.
    pub(crate) mass: Vec<f64>,
    /// Density, kg/m3.
    pub(crate) density: Vec<f64>,
    /// Viscosity, Pa s.
    pub(crate) viscosity: Vec<f64>,
    /// Acceleration at the last full step, m/s2.
    pub(crate) acceleration: Vec<[f64; 3]>,
    /// Specific heat gained since the start, J/kg.
    pub(crate) heat: Vec<f64>,
}

impl Fluid {
    /// Keeps the particles that are in `keep`.
    pub(crate) fn retain(&mut self, keep: &[bool]) {
        let Self { particle, mass, density, viscosity, acceleration, heat } = self;
        retain(particle, keep);
        [mass, density, viscosity, heat].into_iter().for_each(|all| retain(all, keep));
        retain(acceleration, keep);
    }
}

/// Keeps the elements of `all` that are in `keep`, in their order.
pub(crate) fn retain<T>(all: &mut Vec<T>, keep: &[bool]) {
    let mut kept = keep.iter();
    all.retain(|_| *kept.next().unwrap_or(&true));
}
