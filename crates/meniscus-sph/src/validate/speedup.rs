//! Gain of a second thread, beside the gain that this machine's second core has at all.

use super::cost::Stopwatch;
use super::ring_down::setup;
use super::theory::Mode;
use crate::{Error, Simulator};
use meniscus_data::liquids::Rheology;

/// Times that each way is measured. The shortest counts: other programs only add to it.
const ROUNDS: usize = 3;

/// Gains of two cores over one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Speedup {
    /// Time of a run on one thread, to that of the same run on two.
    pub(super) threads: f64,
    /// Twice the time of a run on one thread, to that of two such runs side by side: the most that two threads can gain.
    pub(super) bound: f64,
}

/// Simulates `seconds` of the first mode without viscosity on one thread, on two, and twice side by side, by turns.
pub(super) fn speedup(spacing_m: f64, seconds: f64, mut watch: impl FnMut(f64)) -> Result<Speedup, Error> {
    let mode = Mode::first(super::ring_down::GLASS);
    let mut settled = Simulator::new(&setup(Rheology::newtonian(0.0), spacing_m, true))?;
    settled.set_velocity(|x| mode.velocity(x).map(|v| 0.05 * v));
    let pools = [pool(1)?, pool(1)?, pool(2)?];
    let on = |pool: &rayon::ThreadPool| {
        let mut simulator = settled.clone();
        pool.install(|| {
            while simulator.time_s() < seconds {
                simulator.step(|_| 0.0)?;
            }
            Ok::<_, Error>(())
        })
    };
    let [one, other, two] = &pools;
    let [mut alone_s, mut together_s, mut beside_s] = [f64::INFINITY; 3];
    for round in 0..ROUNDS {
        let timed = |shortest_s: &mut f64, run: &dyn Fn() -> Result<(), Error>| {
            let stopwatch = Stopwatch::start();
            run()?;
            *shortest_s = shortest_s.min(stopwatch.wall_s());
            Ok::<_, Error>(())
        };
        timed(&mut alone_s, &|| on(one))?;
        timed(&mut together_s, &|| on(two))?;
        timed(&mut beside_s, &|| {
            std::thread::scope(|scope| {
                let first = scope.spawn(|| on(one));
                on(other)?;
                first.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
            })
        })?;
        watch((round + 1) as f64 / ROUNDS as f64);
    }
    Ok(Speedup { threads: alone_s / together_s, bound: 2.0 * alone_s / beside_s })
}

/// Returns a pool of `threads`.
fn pool(threads: usize) -> Result<rayon::ThreadPool, Error> {
    let built = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    built.map_err(|error| Error::Setup(format!("threads cannot be started: {error}")))
}
