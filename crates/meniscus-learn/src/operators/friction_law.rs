//! Friction law of a liquid whose viscosity depends on the rate of shear, as the training searches it.
//!
//! Index n and the share y of the yield stress begin as the liquid's own law says at 10 1/s, p1 as the mean of p over the paths. All four
//! numbers are trained with the operators, as
//! ```text
//! ln p1,   ln (e - 0.02),   logit y,   logit n/2
//! ```
//! so that every trial is a law ([`FrictionLaw`]).

use crate::data::trajectory::Path;
use crate::operators::open_loop::validate;
use crate::operators::reference_step::{Dynamics, Square};
use meniscus::latent::generic::{FrictionLaw, LAW_NUMBERS};
use meniscus_data::liquids::Rheology;

/// Rate of shear at which the law of a liquid is read, 1/s: that of a slosh in a glass.
const TYPICAL_RATE: f64 = 10.0;

/// Least floor of the rate.
pub(crate) const LEAST_FLOOR: f64 = 0.02;

/// Floor from which the search starts.
const FIRST_FLOOR: f64 = 0.3;

/// Scales of friction and of p1 that are tried at the start.
const SCALES: [f64; 5] = [0.1, 0.25, 0.5, 1.0, 2.0];

/// Largest change of the typical rate, as a logarithm, and the halvings in which it is found.
const LARGEST_LN: f64 = 5.0;
const HALVINGS: usize = 60;

/// Shares of the range of y and n that the search does not start at: it would not leave them.
const ENDS: f64 = 0.02;

/// Returns `linear`, operators whose friction is linear, under the law of `liquid`; as they are for a Newtonian liquid. Friction and p1 are
/// scaled to the least error of roll-outs along `paths`: D was fitted to an average over rates that the law distinguishes.
#[must_use]
pub(crate) fn under_law(linear: Dynamics, liquid: &Rheology, paths: &[Path], metric: &Square) -> Dynamics {
    let Some(first) = first(&linear, liquid, paths) else { return linear };
    let tried = SCALES.into_iter().flat_map(|friction| SCALES.map(|typical| (friction, typical)));
    let tried = tried.map(|(friction, typical)| Dynamics {
        friction: linear.friction * f64::sqrt(friction),
        law: Some(FrictionLaw { typical: typical * first.typical, ..first }),
        ..linear.clone()
    });
    let judged = tried.map(|d| (validate(|x, u| d.roll_out(x, u), paths, metric), d));
    judged.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(linear, |(_, best)| best)
}

/// Returns the law of `liquid`, its typical rate that of the states of `paths` under `linear`; `None` for a Newtonian liquid.
#[must_use]
pub(super) fn first(linear: &Dynamics, liquid: &Rheology, paths: &[Path]) -> Option<FrictionLaw> {
    if liquid.is_newtonian() {
        return None;
    }
    let thins = liquid.consistency * TYPICAL_RATE.powf(liquid.index);
    let friction = linear.friction * linear.friction.transpose();
    let states = || paths.iter().flat_map(|path| &path.x);
    let heats = states().map(|x| {
        let gradient = linear.discrete_gradient(x, x);
        gradient.dot(&(friction * gradient))
    });
    let typical = heats.sum::<f64>() / states().count().max(1) as f64;
    let yield_share = liquid.yield_stress / (liquid.yield_stress + thins);
    FrictionLaw::new([
        typical.max(f64::MIN_POSITIVE),
        FIRST_FLOOR,
        yield_share.clamp(ENDS, 1.0 - ENDS),
        liquid.index.clamp(2.0 * ENDS, 2.0 * (1.0 - ENDS)),
    ])
}

/// Returns the same motion with D as the friction at the mean rate of shear along `paths`, where its linearisations are taken:
///
/// ```text
/// g = c g',  K = (1 - y) c^(n - 1) + y / c:    phi(g) D = phi'(g') (K D),  p1' = K c^2 p1,  e' = e/c,  y' = y/(c K)
/// ```
/// with the c at which K is the mean of phi, weighted by energy.
#[must_use]
pub(crate) fn at_mean_rate(dynamics: &Dynamics, paths: &[Path]) -> Dynamics {
    let Some(law) = dynamics.law else { return dynamics.clone() };
    let (mut sum, mut weight) = (0.0, f64::MIN_POSITIVE);
    for x in paths.iter().flat_map(|path| &path.x) {
        let rubs = dynamics.friction.tr_mul(&dynamics.discrete_gradient(x, x));
        let energy = dynamics.energy(x);
        sum += energy * law.factor(rubs.norm_squared());
        weight += energy;
    }
    let mean = sum / weight;
    let stress = |c: f64| (1.0 - law.yield_share) * c.powf(law.index - 1.0) + law.yield_share / c;
    // K falls with c where the liquid thins or yields, and rises where it thickens. The motion is the same for any c.
    let (mut low, mut high) = (-LARGEST_LN, LARGEST_LN);
    let falls = stress(high.exp()) < stress(low.exp());
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        let beyond = (stress(middle.exp()) > mean) == falls;
        if beyond { low = middle } else { high = middle }
    }
    // The floor stays one that is searched.
    let c = (0.5 * (low + high)).exp().min(law.floor / (1.01 * LEAST_FLOOR));
    let k = stress(c);
    let changed =
        FrictionLaw::new([k * c * c * law.typical, law.floor / c, law.yield_share / (c * k), law.index]);
    match changed {
        Some(law) => Dynamics { friction: dynamics.friction * k.sqrt(), law: Some(law), ..dynamics.clone() },
        None => dynamics.clone(),
    }
}

/// Returns the numbers by which `law` is searched.
#[must_use]
pub(crate) fn free(law: &FrictionLaw) -> [f64; LAW_NUMBERS] {
    let logit = |share: f64| {
        let share = share.clamp(1e-6, 1.0 - 1e-6);
        (share / (1.0 - share)).ln()
    };
    [
        law.typical.ln(),
        (law.floor - LEAST_FLOOR).max(1e-6).ln(),
        logit(law.yield_share),
        logit(0.5 * law.index),
    ]
}

/// Returns the law of the numbers `free`; `None` where they are not finite.
#[must_use]
pub(crate) fn of_free(free: &[f32]) -> Option<FrictionLaw> {
    let share = |x: f64| 1.0 / (1.0 + (-x).exp());
    let [typical, floor, yields, index] = <[f32; LAW_NUMBERS]>::try_from(free).ok()?.map(f64::from);
    FrictionLaw::new([typical.exp(), LEAST_FLOOR + floor.exp(), share(yields), 2.0 * share(index)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::networks::noise::normal;
    use crate::operators::reference_step::tests::random;
    use meniscus::latent::generic::Latent;

    /// The change of the typical rate is one of names: the steps are the same, and phi is 1 at the mean.
    #[test]
    fn the_motion_is_the_same_at_any_typical_rate() {
        let (base, mut rng) = random(8);
        let law = FrictionLaw::new([3.0, 0.2, 0.3, 0.5]);
        let dynamics = Dynamics { law, ..base };
        let u: Vec<f64> = (0..60).map(|_| normal(&mut rng)).collect();
        let x = dynamics.roll_out(Latent::zeros(), &u);
        let path = Path { energy: vec![0.0; u.len()], heat: vec![0.0; u.len()], x, u: u.clone() };
        let paths = [path];
        let changed = at_mean_rate(&dynamics, &paths);
        let (law, plain) = (changed.law.expect("a law"), dynamics.law.expect("a law"));
        assert!((law.typical / plain.typical - 1.0).abs() > 0.1, "the typical rate was another: {law:?}");
        for (a, b) in paths[0].x.iter().zip(changed.roll_out(Latent::zeros(), &u)) {
            assert!((a - b).norm() < 1e-8 * (1.0 + a.norm()), "{a} for {b}");
        }
        let again = at_mean_rate(&changed, &paths);
        assert!((again.law.expect("a law").typical / law.typical - 1.0).abs() < 1e-6, "phi is 1 at the mean");
    }
}
