//! Particles that leave the glass after a violent start.

use super::ring_down::{GLASS, setup};
use super::theory::Mode;
use crate::{Error, Setup, Simulator};
use meniscus_data::liquids::{Liquid, Rheology};
use meniscus_data::recording::Glass;

/// Returns the number of particles that leave the glass when the first mode of water starts at `speed_m_s`.
pub(super) fn escapes(
    spacing_m: f64,
    speed_m_s: f64,
    seconds: f64,
    mut watch: impl FnMut(f64),
) -> Result<usize, Error> {
    let mut simulator = Simulator::new(&water(GLASS, spacing_m)?)?;
    let mode = Mode::first(GLASS);
    simulator.set_velocity(|x| mode.velocity(x).map(|v| speed_m_s * v));
    while simulator.time_s() < seconds {
        match simulator.step(|_| 0.0) {
            Err(Error::Escaped { count, .. }) => return Ok(count),
            other => other?,
        }
        watch(simulator.time_s() / seconds);
    }
    match simulator.check_inside() {
        Err(Error::Escaped { count, .. }) => Ok(count),
        other => other.map(|()| 0),
    }
}

/// Water that sticks to `glass`.
///
/// # Errors
/// When the liquid's file cannot be read.
pub(super) fn water(glass: Glass, spacing_m: f64) -> Result<Setup, Error> {
    let liquid = Liquid::load("water").map_err(|error| Error::Setup(format!("{error}")))?;
    Ok(Setup { glass, liquid, ..setup(Rheology::newtonian(0.0), spacing_m, true) })
}
