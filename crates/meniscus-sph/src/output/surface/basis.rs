//! The polynomials of the fitted surface, at a place and as a column sees them.
//!
//! A column finds the height at which half of its kernel lies in the liquid. Where the surface `eta` is inclined or bent,
//! that is, to first order, the mean over the part of the kernel's middle plane inside the glass:
//! ```text
//! z(x) = int_A W(|x' - x|) eta(x') dA' / int_A W(|x' - x|) dA'
//! ```
//! At the wall the part inside has its centre 3 mm from it (at a spacing of 5 mm, in a glass of 35 mm radius): heights taken as those of
//! the wall itself would stand 8 to 9 % too low on an inclined surface.

use super::{COEFFICIENTS, Coefficients, DEGREE};
use crate::particles::Kernel;
use std::f64::consts::TAU;

/// The polynomials at `place`: for each azimuthal order m, `(r/R)^(m+2k)` times cosine and sine.
pub(super) fn basis(place: &[f64; 2], radius_m: f64) -> Coefficients {
    let (x, y) = (place[0] / radius_m, place[1] / radius_m);
    let r2 = x * x + y * y;
    let mut out = [0.0; COEFFICIENTS];
    let mut slots = out.iter_mut();
    // (x + i y)^m = r^m (cos m phi + i sin m phi).
    let (mut cosine, mut sine) = (1.0, 0.0);
    for m in 0..=DEGREE {
        let mut ring = 1.0;
        for _ in 0..=(DEGREE - m) / 2 {
            let parts = [ring * cosine, ring * sine];
            // `parts` first: a zip asks its first iterator first, and must not lose a slot.
            for (part, slot) in parts.iter().take(1 + m.min(1)).zip(slots.by_ref()) {
                *slot = *part;
            }
            ring *= r2;
        }
        (cosine, sine) = (cosine * x - sine * y, cosine * y + sine * x);
    }
    out
}

/// The polynomials as a column at `place` sees them: their means over its kernel inside a circle of `radius_m`.
pub(super) fn seen(place: &[f64; 2], radius_m: f64, kernel: &Kernel) -> Coefficients {
    const RINGS: usize = 24;
    const SPOKES: usize = 64;
    let step = kernel.support2.sqrt() / RINGS as f64;
    let mut sum = [0.0; COEFFICIENTS];
    let mut whole = 0.0;
    for ring in 0..RINGS {
        let r = (ring as f64 + 0.5) * step;
        let weight = r * kernel.value(r * r);
        for spoke in 0..SPOKES {
            let (sin, cos) = (TAU * (spoke as f64 + 0.5) / SPOKES as f64).sin_cos();
            let at = [place[0] + r * cos, place[1] + r * sin];
            if at[0] * at[0] + at[1] * at[1] > radius_m * radius_m {
                continue;
            }
            whole += weight;
            sum.iter_mut().zip(basis(&at, radius_m)).for_each(|(sum, value)| *sum += weight * value);
        }
    }
    sum.map(|sum| sum / whole)
}
