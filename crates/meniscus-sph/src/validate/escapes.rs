//! Particles that leave the glass after a violent start.

use super::ring_down::GLASS;
use super::theory::Mode;
use crate::{Error, Setup, Simulator};
use meniscus_data::effects::Effects;
use meniscus_data::liquids::Liquid;

/// Returns the number of particles that leave the glass when the first mode of water starts at `speed_m_s`.
pub(super) fn escapes(
    spacing_m: f64,
    speed_m_s: f64,
    seconds: f64,
    mut watch: impl FnMut(f64),
) -> Result<usize, Error> {
    let liquid = Liquid::load("water").map_err(|error| Error::Setup(format!("{error}")))?;
    let mut simulator = Simulator::new(&Setup {
        glass: GLASS,
        liquid,
        spacing_m,
        seed: 0,
        no_slip: true,
        effects: Effects::default(),
        step_s: None,
    })?;
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
