//! Speed of the particles of a liquid at rest.

use super::ring_down::setup;
use crate::{Error, Simulator};
use meniscus_data::liquids::Rheology;

/// Returns the largest root mean square speed of the particles in `seconds` of rest without viscosity, mm/s.
pub(super) fn rest_noise(spacing_m: f64, seconds: f64, mut watch: impl FnMut(f64)) -> Result<f64, Error> {
    let mut simulator = Simulator::new(&setup(Rheology::newtonian(0.0), spacing_m, true))?;
    let mut largest = 0.0_f64;
    while simulator.time_s() < seconds {
        simulator.step(|_| 0.0)?;
        let (mass, energy) = simulator.motion().fold((0.0, 0.0), |(mass, energy), (_, v, m)| {
            (mass + m, energy + m * v.iter().map(|v| v * v).sum::<f64>())
        });
        largest = largest.max((energy / mass).sqrt());
        watch(simulator.time_s() / seconds);
    }
    Ok(1e3 * largest)
}
