//! Equality of a run on one thread and on two, bit by bit.

use super::ring_down::setup;
use crate::{Error, Simulator};
use meniscus_data::liquids::Rheology;

/// Returns whether one thread and two give the same bits of every position and velocity after a shaken 0.1 s.
pub(super) fn same_bits(spacing_m: f64) -> Result<bool, Error> {
    let bits = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .map_err(|error| Error::Setup(format!("threads cannot be started: {error}")))?;
        pool.install(|| {
            let mut simulator = Simulator::new(&setup(Rheology::newtonian(0.95), spacing_m, true))?;
            while simulator.time_s() < 0.1 {
                simulator.step(|t| 3.0 * (20.0 * t).sin())?;
            }
            let bits: Vec<_> =
                simulator.motion().map(|(x, v, _)| (x.map(f64::to_bits), v.map(f64::to_bits))).collect();
            Ok::<_, Error>(bits)
        })
    };
    Ok(bits(1)? == bits(2)?)
}
