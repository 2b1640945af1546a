//! Random draws from a generator that the caller seeds.
//!
//! `rand_distr::StandardNormal` draws by the ziggurat method, which is faster and uses another number of uniform draws.
//! Box and Muller's method stays because results that are shipped or stored rest on its stream: the rendered camera noise
//! and the variances calibrated on it, the jitter of the trained model, and the draws of the hidden trials.

use rand::{Rng, RngExt};
use std::f64::consts::TAU;

/// Draws a standard normal number.
///
/// ```text
/// z = sqrt(-2 ln(1 - a)) cos(2 pi b),      a then b uniform on [0, 1)      (Box and Muller 1958)
/// ```
/// `1 - a` is never zero. Each draw takes two uniform numbers; the sine's twin is not kept, so that the stream does not
/// depend on whether the count of draws before was even.
///
/// ```
/// use meniscus_numerics::random::normal;
/// use rand::SeedableRng;
///
/// let mut generator = rand_chacha::ChaCha8Rng::seed_from_u64(7);
/// let first = normal(&mut generator);
/// assert_eq!(first, normal(&mut rand_chacha::ChaCha8Rng::seed_from_u64(7)));
/// assert_ne!(first, normal(&mut generator));
/// ```
pub fn normal<R: Rng + ?Sized>(generator: &mut R) -> f64 {
    let radius = (-2.0 * (1.0 - generator.random::<f64>()).ln()).sqrt();
    radius * (TAU * generator.random::<f64>()).cos()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn moments_and_tails_are_those_of_a_normal_number() {
        const DRAWS: usize = 200_000;
        let mut generator = ChaCha8Rng::seed_from_u64(1);
        let draws: Vec<f64> = (0..DRAWS).map(|_| normal(&mut generator)).collect();
        let moment = |power: i32| draws.iter().map(|z| z.powi(power)).sum::<f64>() / DRAWS as f64;
        // Six standard errors: 1, 2, 15 and 96 over the count are the variances of these means.
        for (power, due, variance) in [(1, 0.0, 1.0), (2, 1.0, 2.0), (3, 0.0, 15.0), (4, 3.0, 96.0)] {
            let slack = 6.0 * f64::sqrt(variance / DRAWS as f64);
            assert!((moment(power) - due).abs() < slack, "moment {power}: {}", moment(power));
        }
        // python3 -c "from scipy.stats import norm; print(norm.cdf(1) - norm.cdf(-1), norm.cdf(3) - norm.cdf(-3))"
        for (limit, due) in [(1.0, 0.682_689_492_137_085_9), (3.0, 0.997_300_203_936_739_8)] {
            let share = draws.iter().filter(|z| z.abs() < limit).count() as f64 / DRAWS as f64;
            let slack = 6.0 * f64::sqrt(due * (1.0 - due) / DRAWS as f64);
            assert!((share - due).abs() < slack, "within {limit}: {share}");
        }
    }

    #[test]
    fn draws_follow_from_the_uniform_numbers_in_their_order() {
        let mut uniform = ChaCha8Rng::seed_from_u64(42);
        let (a, b): (f64, f64) = (uniform.random(), uniform.random());
        let due = (-2.0 * (1.0 - a).ln()).sqrt() * (TAU * b).cos();
        assert_eq!(normal(&mut ChaCha8Rng::seed_from_u64(42)).to_bits(), due.to_bits());
    }
}
