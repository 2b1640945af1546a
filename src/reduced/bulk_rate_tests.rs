//! The mean rates of shear in the bulk, by quadrature over the first mode of a deep cylinder.
#![allow(clippy::disallowed_methods, reason = "a test may take the platform's functions")]

extern crate std;

use super::boundary_layer::{BULK_PLACES, EXPONENTS};
use std::assert;
use std::f64::consts::{FRAC_PI_2, PI, SQRT_2};
use std::vec::Vec;

/// First zero of `J1'`: k of the first mode in a cylinder of radius 1.
const K: f64 = 1.841_183_781_340_659;

/// Cells along the radius and around a quarter.
const CELLS: [usize; 2] = [60, 40];

/// Returns `J1(x) = (1/pi) int cos(t - x sin t) dt` over half a turn (Bessel).
fn j1(x: f64) -> f64 {
    let points = 200;
    let at = |i: usize| (i as f64 + 0.5) * PI / f64::from(points);
    (0..points as usize).map(|i| (at(i) - x * at(i).sin()).cos()).sum::<f64>() / f64::from(points)
}

/// Returns the rate of shear `sqrt(2 e:e)` at the surface over `sqrt(2) k v`, and the weight of its place.
///
/// The potential is `f(r) cos(t) e^(kz)/k`, `f = J1(k r)/J1(k)`, so that the wall rises at the rate 1.
fn rates() -> Vec<[f64; 2]> {
    let f = |r: f64| j1(K * r) / j1(K);
    let h = 1e-4;
    let mut out = Vec::new();
    for i in 0..CELLS[0] {
        let r = (i as f64 + 0.5) / CELLS[0] as f64;
        let (low, here, high) = (f(r - h), f(r), f(r + h));
        let (slope, bend) = ((high - low) / (2.0 * h), (high - 2.0 * here + low) / (h * h));
        for j in 0..CELLS[1] {
            let (sin, cos) = ((j as f64 + 0.5) * FRAC_PI_2 / CELLS[1] as f64).sin_cos();
            let straight = [bend * cos, (slope / r - here / (r * r)) * cos, K * K * here * cos];
            let sheared = [(here / (r * r) - slope / r) * sin, K * slope * cos, -K * here * sin / r];
            let square = |values: [f64; 3]| values.iter().map(|e| e * e).sum::<f64>();
            let shear = (2.0 * (square(straight) + 2.0 * square(sheared))).sqrt() / K;
            out.push([shear / (SQRT_2 * K), r]);
        }
    }
    out
}

#[test]
fn a_stress_loses_as_much_at_its_mean_rate_as_over_the_bulk() {
    let rates = rates();
    // Down the glass every rate falls as e^(kz), whose power p + 1 has the mean depth 1/(k (p + 1)).
    let loss =
        |p: f64| rates.iter().map(|[rate, weight]| rate.powf(p + 1.0) * weight).sum::<f64>() / (p + 1.0);
    for (p, wanted) in EXPONENTS.into_iter().zip(BULK_PLACES) {
        // At p = 1 every rate serves; the limit is meant.
        let p = f64::min(p, 1.0 - 1e-4);
        let found = (loss(p) / loss(1.0)).powf(1.0 / (p - 1.0));
        assert!((found / wanted - 1.0).abs() < 0.005, "{found} for {wanted} at {p}");
    }
}
