//! Identification against liquids whose frequency and damping come from elsewhere: the formula of Case and Parkinson for thin
//! boundary layers, and the eigenvalues of the linearised Navier-Stokes equations (a Ritz solver). Neither shares code with the
//! reduced model that is fitted.
//!
//! ```text
//! A'' + 2 g A' + (w^2 + g^2) A = -a(t) k tanh(kh) 2R/(xi^2 - 1),   slope of A J1(xi s)/J1(xi) over the profile
//! ```
//! (x = sum of 2R/(xi_n^2 - 1) J1(k_n r)/J1(xi_n) cos(azimuth): the share of a sideways acceleration in each mode.) The second
//! mode is added, whose damping hardly matters.

use super::{Law, fit_viscosity};
use crate::identify::fit::identify_records;
use meniscus::surface::{POINTS, profile_abscissa};
use meniscus::units::{FRAME_INTERVAL_S, GRAVITY_M_S2};
use meniscus_data::motion::Motion;
use meniscus_data::recording::Glass;
use meniscus_data::scene_file::GLASS;
use meniscus_discover::recordings::record::{Channel, Quantity, Record, parts};
use meniscus_discover::recordings::stated::{CALLIPERS_M, Known};
use meniscus_discover::recordings::tables::drive_of;
use meniscus_sph::validate::{Linear, linear_mode};

/// The first two zeros of J1'.
const XI: [f64; 2] = [1.841_183_781, 5.331_442_774];

/// Length of a recording, s.
const SECONDS: f64 = 4.0;

/// Damped oscillation: angular frequency and decay, 1/s.
#[derive(Clone, Copy, Debug)]
struct Oscillation {
    frequency: f64,
    decay: f64,
}

/// J1 by its power series, which is exact to rounding for arguments below six.
fn j1(x: f64) -> f64 {
    let (mut term, mut sum) = (0.5 * x, 0.5 * x);
    for k in 1..40 {
        term *= -0.25 * x * x / (f64::from(k) * f64::from(k + 1));
        sum += term;
    }
    sum
}

/// Frequency without viscosity of mode `n`, 1/s (Lamb 1932, article 257).
fn inviscid(glass: &Glass, n: usize) -> f64 {
    let k = XI[n] / glass.radius_m;
    (GRAVITY_M_S2 * k * (k * glass.fill_m).tanh()).sqrt()
}

/// Decay by the boundary layers of wall and bottom and by the bulk (Case and Parkinson 1957); the layers lower the frequency by as
/// much as they damp.
fn case_and_parkinson(glass: &Glass, nu: f64) -> Oscillation {
    let (r, h, xi, w) = (glass.radius_m, glass.fill_m, XI[0], inviscid(glass, 0));
    let k = xi / r;
    let side = (1.0 + xi.powi(-2)) / (1.0 - xi.powi(-2));
    let bottom = 2.0 * k * r * (1.0 - h / r) / (2.0 * k * h).sinh();
    let layers = (nu * w / 2.0).sqrt() / (2.0 * r) * (side + bottom);
    Oscillation { frequency: w - layers, decay: layers + 2.0 * nu * k * k }
}

/// The first mode by the Ritz solver of the linearised equations.
fn ritz(glass: &Glass, nu: f64) -> Oscillation {
    let tone = linear_mode(glass, &Linear { nu, slip_m: 0.0, memory: None }).expect("it oscillates");
    Oscillation { frequency: std::f64::consts::TAU * tone.hz, decay: tone.decay }
}

/// Slope of a liquid whose first mode is `first` under `motion`, with 0.05 mm of noise.
fn record(name: &str, motion: &str, first: Oscillation) -> Record {
    let motion = Motion::parse(motion, SECONDS).expect("a motion");
    let modes = [first, Oscillation { frequency: inviscid(&GLASS, 1), decay: 2.0 * first.decay }];
    let slope_of = |n: usize| {
        let shape = |i: usize| (i, j1(XI[n] * profile_abscissa(i)) / j1(XI[n]));
        parts((0..POINTS).map(shape)).expect("all points")[1]
    };
    let drive_gain = |n: usize| {
        let k = XI[n] / GLASS.radius_m;
        k * (k * GLASS.fill_m).tanh() * 2.0 * GLASS.radius_m / (XI[n] * XI[n] - 1.0)
    };
    let steps = 40;
    let dt = FRAME_INTERVAL_S / f64::from(steps);
    let mut state = [[0.0_f64; 2]; 2];
    let mut noise = 0x2545_f491_4f6c_dd1d_u64;
    let frames = (SECONDS / FRAME_INTERVAL_S).round() as usize;
    let mut slope = Vec::with_capacity(frames);
    for frame in 0..frames {
        let mut draw = || {
            noise ^= noise << 13;
            noise ^= noise >> 7;
            noise ^= noise << 17;
            (noise >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let white = 5e-5 * (12.0_f64 / 4.0).sqrt() * (0..4).map(|_| draw()).sum::<f64>();
        slope.push(Some((0..2).map(|n| slope_of(n) * state[n][0]).sum::<f64>() + white));
        for step in 0..steps {
            let time = frame as f64 * FRAME_INTERVAL_S + f64::from(step) * dt;
            for (n, mode) in modes.iter().enumerate() {
                // The classical Runge-Kutta step.
                let rate = |[height, velocity]: [f64; 2], time: f64| {
                    let stiffness = mode.frequency * mode.frequency + mode.decay * mode.decay;
                    let push = -drive_gain(n) * motion.acceleration(time);
                    [velocity, push - 2.0 * mode.decay * velocity - stiffness * height]
                };
                let moved = |by: [f64; 2], dt: f64| [state[n][0] + dt * by[0], state[n][1] + dt * by[1]];
                let a = rate(state[n], time);
                let b = rate(moved(a, 0.5 * dt), time + 0.5 * dt);
                let c = rate(moved(b, 0.5 * dt), time + 0.5 * dt);
                let d = rate(moved(c, dt), time + dt);
                for i in 0..2 {
                    state[n][i] += dt / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]);
                }
            }
        }
    }
    Record {
        name: name.into(),
        interval_s: FRAME_INTERVAL_S,
        channels: vec![Channel { quantity: Quantity::Slope, value: slope }],
        drive: drive_of(&motion, SECONDS),
        rest_frames: 18,
    }
}

fn known(density_kg_m3: f64) -> Known {
    Known {
        radius_m: GLASS.radius_m,
        radius_error_m: CALLIPERS_M,
        fill_m: GLASS.fill_m,
        density_kg_m3,
        viscosity_pa_s: 1.0,
        motion_share: [1.0; 2],
    }
}

#[test]
fn j1_is_that_of_the_tables() {
    assert!((j1(1.0) - 0.440_050_585_744_93).abs() < 1e-14 && (j1(5.0) + 0.327_579_137_591_47).abs() < 1e-12);
}

/// Two motions each; the true viscosity lies in the interval and within 15 % of the best value.
#[test]
fn viscosity_of_liquids_whose_damping_comes_from_elsewhere() {
    for (name, density, nu, first) in [
        ("equations, 50 mPa s", 1000.0, 5e-5, ritz(&GLASS, 5e-5)),
        ("equations, 0.1 Pa s", 1000.0, 1e-4, ritz(&GLASS, 1e-4)),
        ("equations, 0.3 Pa s", 1261.0, 0.3 / 1261.0, ritz(&GLASS, 0.3 / 1261.0)),
    ] {
        let records = [record("one", "strokes:1x0.15", first), record("two", "strokes:2x0.15", first)];
        let fit = fit_viscosity(&records, &known(density)).expect("a fit");
        let (value, truth) = (fit.viscosity_pa_s, nu * density);
        println!("{name}: {value:?} for {truth}, misfit {:.2}", fit.misfit);
        assert!(value.interval[0] <= truth && truth <= value.interval[1], "{name}: {value:?} for {truth}");
        assert!((value.best / truth - 1.0).abs() < 0.15, "{name}: {value:?} for {truth}");
        assert!(value.interval[1] < 3.0 * truth, "{name}: an interval that says something: {value:?}");
    }
}

/// The formula is of a contact line that slides freely, and the reduced model of one that sticks to the wall, as the simulator's
/// does. The sticking line damps more, so that a free one looks like a viscosity that is a quarter lower.
#[test]
fn a_free_contact_line_looks_like_a_lower_viscosity() {
    let first = case_and_parkinson(&GLASS, 1e-5);
    let records = [record("one", "strokes:1x0.15", first), record("two", "strokes:2x0.15", first)];
    let share = fit_viscosity(&records, &known(1000.0)).expect("a fit").viscosity_pa_s.best / 1e-2;
    println!("{share} of the true viscosity");
    assert!((0.6..0.95).contains(&share), "{share}");
}

/// Of water neither the reduced model nor the simulator can tell the viscosity; the bound holds it.
#[test]
fn water_is_undetermined_below_a_bound_that_holds() {
    let first = case_and_parkinson(&GLASS, 1.0e-6);
    let records = [record("one", "strokes:1x0.15", first), record("two", "strokes:2x0.15", first)];
    let found = identify_records(&records, &known(998.0), Law::Newtonian).expect("a fit");
    println!("{found:?}");
    assert_eq!(found.law, Law::Newtonian);
    let below = found.undetermined_below_pa_s.expect("below the simulator's own viscosity");
    assert!((1.0e-3..5e-3).contains(&below), "{below}");
    assert!(found.sentence().contains("undetermined, below"), "{}", found.sentence());
}
