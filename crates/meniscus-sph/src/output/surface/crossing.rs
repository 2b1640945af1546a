//! The height of the surface over one place: where the colour function falls through its threshold.

use super::Nearby;
use crate::Simulator;

/// The part of the kernel around `place`, far from bottom and rim, that lies inside the glass.
pub(super) fn inside(simulator: &Simulator, place: &[f64; 2]) -> f64 {
    const HEIGHTS: usize = 8;
    let kernel = &simulator.forces.kernel;
    let glass = &simulator.glass;
    let middle = if glass.is_cylinder() { 0.5 * glass.rim_m } else { glass.fill_m };
    let mut outside = 0.0;
    for k in 0..HEIGHTS {
        let z = middle + simulator.spacing_m * k as f64 / HEIGHTS as f64;
        for (x, volume) in simulator.shell.position.iter().zip(&simulator.shell.volume) {
            let (dx, dy, dz) = (x[0] - place[0], x[1] - place[1], x[2] - z);
            outside += volume * kernel.value(dx * dx + dy * dy + dz * dz);
        }
    }
    1.0 - outside / HEIGHTS as f64
}

/// Height at which the colour function first reaches `threshold`, coming down from above; 0 if never.
pub(super) fn crossing(simulator: &Simulator, nearby: &Nearby, threshold: f64) -> f64 {
    let kernel = &simulator.forces.kernel;
    let particle = &simulator.fluid.particle;
    let colour = |z: f64| -> f64 {
        let part = |(i, d2): &(u32, f64)| {
            let p = &particle[*i as usize];
            let r2 = d2 + (p.x[2] - z) * (p.x[2] - z);
            if r2 < kernel.support2 { p.volume * kernel.value(r2) } else { 0.0 }
        };
        nearby.iter().map(part).sum::<f64>() - threshold
    };
    let top = nearby.iter().map(|(i, _)| particle[*i as usize].x[2]).fold(0.0, f64::max);
    let (mut high, step) = (top + kernel.h, 0.5 * kernel.h);
    let mut above = colour(high);
    while high > 0.0 {
        let low = high - step;
        let below = colour(low);
        if below >= 0.0 {
            return root(colour, low, below, high, above);
        }
        (high, above) = (low, below);
    }
    0.0
}

/// Root of `f` between `low` (where it is `below >= 0`) and `high` (`above < 0`), by bracketed secants.
fn root(f: impl Fn(f64) -> f64, mut low: f64, mut below: f64, mut high: f64, mut above: f64) -> f64 {
    let mut z = low;
    for _ in 0..4 {
        z = low + (high - low) * below / (below - above);
        let value = f(z);
        if value >= 0.0 {
            (low, below) = (z, value);
        } else {
            (high, above) = (z, value);
        }
    }
    z
}
