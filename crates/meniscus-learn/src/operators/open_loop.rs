//! Open-loop roll-outs from true states, by which every step is validated.

use crate::data::trajectory::Path;
use crate::operators::reference_step::Square;
use meniscus::latent::generic::Latent;

/// Turns of a validation roll-out: two seconds.
pub(crate) const HORIZON: usize = 120;

/// Relative error of roll-outs of up to [`HORIZON`] turns from true states, in `metric`.
#[must_use]
pub(crate) fn validate(
    roll_out: impl Fn(Latent, &[f64]) -> Vec<Latent>,
    paths: &[Path],
    metric: &Square,
) -> f64 {
    let (mut miss, mut size) = (0.0, 0.0);
    for Open { from, ports, truth } in paths.iter().flat_map(open_loop) {
        for (said, x) in roll_out(from, ports).iter().zip(truth) {
            miss += (metric * (said - x)).norm_squared();
            size += (metric * x).norm_squared();
        }
    }
    (miss / size.max(f64::MIN_POSITIVE)).sqrt()
}

/// One roll-out to judge by: a true state, the ports after it, and where they truly led.
pub(crate) struct Open<'p> {
    /// The true state.
    pub(crate) from: Latent,
    /// Ports of the turns from there.
    pub(crate) ports: &'p [f64],
    /// The true state after each.
    pub(crate) truth: &'p [Latent],
}

/// The roll-outs of up to [`HORIZON`] turns along `path`, each beginning in the middle of the one before.
pub(crate) fn open_loop(path: &Path) -> impl Iterator<Item = Open<'_>> {
    (0..path.x.len().saturating_sub(HORIZON / 2)).step_by(HORIZON / 2).map(move |from| {
        let to = (from + 1 + HORIZON).min(path.x.len());
        Open { from: path.x[from], ports: &path.u[from + 1..to], truth: &path.x[from + 1..to] }
    })
}
