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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particles::lanes::MOST;
    use crate::setup::small_glass;
    use crate::validate::Mode;
    use meniscus::reduced::effects::EffectKind;
    use meniscus_data::effects::Effects;
    use std::sync::atomic::Ordering;

    /// A liquid that jitters, one whose friction is done in stages, and one with effects on wall and surface: all sums over pairs.
    #[test]
    fn vectors_of_any_width_give_the_same_bits() {
        meniscus_platform::cpu_features::widen();
        let plastic = Rheology { consistency: 0.2, index: 1.0, yield_stress: 3.0, largest: 20.0 };
        let foam = Effects::default().with(EffectKind::Foam, 0.3);
        let cases = [
            (Rheology::newtonian(1e-3), Effects::default()),
            (plastic, Effects::default()),
            (Rheology::newtonian(0.1), foam),
        ];
        for (rheology, effects) in cases {
            let simulator = Simulator::new(&crate::Setup { effects, ..small_glass(1000.0, rheology) });
            let simulator = simulator.expect("the glass settles");
            let mode = Mode::first(simulator.glass);
            let [narrow, half, full] = [128, 256, 512].map(|bits| {
                MOST.store(bits, Ordering::Relaxed);
                let mut simulator = simulator.clone();
                simulator.set_velocity(|x| mode.velocity(x).map(|v| 0.3 * v));
                while simulator.time_s() < 0.03 {
                    simulator.step(|_| 0.0).expect("it stays in the glass");
                }
                let numbers = simulator.motion().flat_map(|(x, v, _)| x.into_iter().chain(v));
                numbers.map(f64::to_bits).collect::<Vec<_>>()
            });
            assert!(narrow == half && half == full, "{rheology:?}: other bits");
        }
    }
}
