//! The simulator against theory: frequency and decay of the first slosh mode, energy, rest.
#![cfg(feature = "offline")]

use meniscus::offline::liquids::{Liquid, Rheology};
use meniscus::offline::recording::Glass;
use meniscus::offline::sph::{Setup, Simulator, relative_closure};
use std::f64::consts::TAU;

const GLASS: Glass = Glass { radius_m: 0.035, fill_m: 0.07, rim_m: 0.11 };

/// First zero of J1'.
const XI: f64 = 1.841_183_781;

fn setup(viscosity: f64, no_slip: bool) -> Setup {
    let liquid =
        Liquid { name: "test".into(), density_kg_m3: 1261.0, rheology: Rheology::newtonian(viscosity) };
    Setup { glass: GLASS, liquid, spacing_m: 0.005, seed: 0, no_slip }
}

/// Gradient of the first mode's potential `J1(kr) cos(phi) cosh(kz)`, scaled to 1 at the wall's top.
fn mode([x, y, z]: [f64; 3]) -> [f64; 3] {
    let k = XI / GLASS.radius_m;
    let r = x.hypot(y).max(1e-9);
    let (cos, sin) = (x / r, y / r);
    let over = libm::j1(k * r) / (k * r);
    let slope = libm::j0(k * r) - over;
    let scale = 1.0 / (libm::j1(XI) * (k * GLASS.fill_m).cosh());
    let (radial, around) = (slope * cos * (k * z).cosh(), -over * sin * (k * z).cosh());
    let up = libm::j1(k * r) * cos * (k * z).sinh();
    [scale * (radial * cos - around * sin), scale * (radial * sin + around * cos), scale * up]
}

/// Lets the first mode ring from 0.05 m/s; returns times and modal momentum.
fn ring(setup: &Setup, seconds: f64) -> Vec<(f64, f64)> {
    let mut simulator = Simulator::new(setup).expect("the glass settles");
    simulator.set_velocity(|x| mode(x).map(|v| 0.05 * v));
    let mut series = Vec::new();
    let mut books = Vec::new();
    while simulator.time_s() < seconds {
        let momentum = |([x, y, z], v, m): ([f64; 3], [f64; 3], f64)| {
            let e = mode([x, y, z]);
            m * (v[0] * e[0] + v[1] * e[1] + v[2] * e[2])
        };
        series.push((simulator.time_s(), simulator.motion().map(momentum).sum()));
        books.push(simulator.energy());
        simulator.step(|_| 0.0).expect("the mode rings inside the glass");
    }
    let last = books.last().unwrap();
    println!("closure {} last {last:?}", relative_closure(&books));
    series
}

/// Frequency (Hz) and decay (1/s) of `A e^(-decay t) cos(2 pi f t + phase)` fitted to `series`.
fn fit(series: &[(f64, f64)], guess_hz: f64) -> (f64, f64) {
    let misfit = |hz: f64, decay: f64| -> f64 {
        let (mut cc, mut cs, mut ss, mut yc, mut ys, mut yy) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
        for &(t, y) in series {
            let envelope = (-decay * t).exp();
            let (s, c) = (TAU * hz * t).sin_cos();
            let (s, c) = (s * envelope, c * envelope);
            (cc, cs, ss) = (cc + c * c, cs + c * s, ss + s * s);
            (yc, ys, yy) = (yc + y * c, ys + y * s, yy + y * y);
        }
        let det = cc * ss - cs * cs;
        yy - (yc * (ss * yc - cs * ys) + ys * (cc * ys - cs * yc)) / det
    };
    let (mut hz, mut decay, mut best) = (guess_hz, 3.0, misfit(guess_hz, 3.0));
    let (mut dh, mut dd) = (0.2, 2.0);
    while dh > 1e-5 {
        let tries = [(hz + dh, decay), (hz - dh, decay), (hz, decay + dd), (hz, decay - dd)];
        let better = tries.into_iter().map(|(h, d)| (misfit(h, d), h, d)).min_by(|a, b| a.0.total_cmp(&b.0));
        match better {
            Some((m, h, d)) if m < best => (best, hz, decay) = (m, h, d),
            _ => (dh, dd) = (0.5 * dh, 0.5 * dd),
        }
    }
    (hz, decay)
}

#[test]
fn probe() {
    for (mu, slip) in [(0.0, true), (0.95, true), (0.95, false)] {
        let start = std::time::Instant::now();
        let series = ring(&setup(mu, slip), 1.0);
        let wall = start.elapsed().as_secs_f64();
        for (t, a) in series.iter().step_by(100) {
            print!("{t:.3}:{a:.5} ");
        }
        println!("\nmu {mu} no_slip {slip}: {:?}, {wall} s wall", fit(&series, 3.5));
        println!("{:?}", fit(&series[series.len() / 20..series.len() * 7 / 10], 3.5));
    }
    let mut simulator = Simulator::new(&setup(0.95, true)).unwrap();
    for _ in 0..600 {
        simulator.step(|_| 0.0).unwrap();
    }
    let mut n = 0.0;
    let sum: f64 = simulator
        .motion()
        .map(|(_, v, _)| {
            n += 1.0;
            v[0] * v[0] + v[1] * v[1] + v[2] * v[2]
        })
        .sum();
    println!("rest noise {} mm/s {:?}", 1e3 * (sum / n).sqrt(), simulator.energy());
}
