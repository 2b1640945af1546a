//! Closure of the energy balance of a shaken glass.

use crate::{Error, Setup, Simulator, relative_closure};
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_data::motion::Motion;
use meniscus_data::recording::EnergyBook;

/// Returns the largest error of the energy balance over `seconds` under the motion `strokes:7`, per cent of the largest
/// slosh energy; the balance is drawn at 60 Hz.
pub(super) fn energy_closure(setup: &Setup, seconds: f64, mut watch: impl FnMut(f64)) -> Result<f64, Error> {
    let motion = Motion::parse("strokes:7", seconds).map_err(|error| Error::Setup(format!("{error}")))?;
    let mut simulator = Simulator::new(setup)?;
    let steps = simulator.divide(FRAME_INTERVAL_S);
    let mut books: Vec<EnergyBook> = Vec::new();
    while simulator.time_s() < seconds {
        for _ in 0..steps {
            simulator.step(|t| motion.acceleration(t))?;
        }
        books.push(simulator.energy());
        watch(simulator.time_s() / seconds);
    }
    Ok(100.0 * relative_closure(&books))
}
