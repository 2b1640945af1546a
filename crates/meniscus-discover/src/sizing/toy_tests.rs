//! The search on a toy whose sizes are known: a damped oscillator, integrated by other code than any model here.
//!
//! ```text
//! x'' = -w^2 x - c x' - d tanh(x'/s) + f(t)          c: viscosity,   d: dry friction, which is sized
//! ```
//! A packing changes frequency, damping and dry friction a little, as one of particles does, and every measured recording has a packing of
//! its own, white noise, an offset and a lag.

use super::candidate::SizingCandidate;
use super::cautions::refutation;
use super::comparison::Scores;
use super::emulator::Prior;
use super::error::SizingError;
use super::forward::{Forward, Point, Simulated};
use super::interval::{SizeVariance, spacing_error};
use super::projection::{Observed, ObservedChannel, Series};
use super::search::{Level, OtherParameter, SizeRange, SizeSearch, Start};
use meniscus::reduced::effects::{Active, EffectKind, Stated};
use meniscus_numerics::random::normal;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::cell::RefCell;

const FRAMES: usize = 150;
const INTERVAL_S: f64 = 1.0 / 60.0;
const NOISE_M: f64 = 2e-5;
const OTHERS: [OtherParameter; 1] =
    [OtherParameter { prior: Prior { mean: 0.0, deviation: 0.05 }, step: 0.1 }];

/// Law of the oscillator.
#[derive(Clone, Copy)]
struct Law {
    dry: f64,
    viscosity: f64,
    quadratic: f64,
}

/// Deviations of a packing from none: of frequency, damping and dry friction, relative.
fn packing(seed: u64) -> [f64; 3] {
    let mut random = ChaCha8Rng::seed_from_u64(7000 + seed);
    [0.001, 0.02, 0.03].map(|deviation| deviation * normal(&mut random))
}

/// Heights of the oscillator pushed with `strength`, by the classical Runge-Kutta method.
fn oscillate(law: Law, strength: f64, [fast, damped, rough]: [f64; 3], late_s: f64) -> Vec<f64> {
    let w = 22.0 * (1.0 + fast);
    let c = 1.6 * law.viscosity.exp() * (1.0 + damped);
    let rate = |t: f64, x: f64, v: f64| {
        let push = if (0.3..0.6).contains(&t) {
            strength * (std::f64::consts::PI * (t - 0.3) / 0.3).sin()
        } else {
            0.0
        };
        let friction = c * v + law.dry * (1.0 + rough) * (v / 0.004).tanh() + law.quadratic * v * v.abs();
        [v, push - w * w * x - friction]
    };
    let h = INTERVAL_S / 8.0;
    let (mut x, mut v) = (0.0, 0.0);
    let mut out = Vec::new();
    // From before the start, so that a lag finds the rest.
    for n in -80..(8 * FRAMES as i32) {
        let t = f64::from(n) * h - late_s;
        if n >= 0 && n % 8 == 0 {
            out.push(x);
        }
        let a = rate(t, x, v);
        let b = rate(t + 0.5 * h, x + 0.5 * h * a[0], v + 0.5 * h * a[1]);
        let c = rate(t + 0.5 * h, x + 0.5 * h * b[0], v + 0.5 * h * b[1]);
        let d = rate(t + h, x + h * c[0], v + h * c[1]);
        x += h / 6.0 * (a[0] + 2.0 * b[0] + 2.0 * c[0] + d[0]);
        v += h / 6.0 * (a[1] + 2.0 * b[1] + 2.0 * c[1] + d[1]);
    }
    out
}

const STRENGTHS: [f64; 3] = [2.0, 3.0, 4.5];

/// Kind of the effect that a toy carries.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Dry,
    Quadratic,
}

/// The toy as a model that is sized; it fails at sizes above `breaks`.
struct Toy {
    kind: Kind,
    breaks: f64,
    /// Factor on the dry friction, the error of a coarse model.
    rubs: f64,
    /// First packing.
    first: u64,
    asked: RefCell<Vec<Point>>,
}

impl Toy {
    fn new(kind: Kind) -> Self {
        Self { kind, breaks: f64::INFINITY, rubs: 1.0, first: 900, asked: RefCell::new(Vec::new()) }
    }

    fn law(&self, parameters: &[f64]) -> Law {
        let [size, viscosity] = [parameters[0], parameters[1]];
        match self.kind {
            Kind::Dry => Law { viscosity, ..dry(self.rubs * size) },
            Kind::Quadratic => Law { viscosity, quadratic: size, ..dry(0.0) },
        }
    }
}

impl Forward for Toy {
    fn run(&self, points: &[Point]) -> Result<Vec<Result<Simulated, String>>, SizingError> {
        self.asked.borrow_mut().extend(points.iter().cloned());
        let one = |point: &Point| {
            if point.parameters[0] > self.breaks {
                return Err(String::from("particles left the glass"));
            }
            let packing = packing(self.first + point.packing as u64);
            let series = |strength: f64| vec![oscillate(self.law(&point.parameters), strength, packing, 0.0)];
            Ok(Simulated { recordings: STRENGTHS.map(series).to_vec(), control: vec![None; 3] })
        };
        Ok(points.iter().map(one).collect())
    }
}

/// Measured recordings of the hidden `law`.
fn measured(law: Law, seed: u64) -> Vec<Observed> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let hidden = packing(seed);
    let one = |strength: f64| {
        let late_s = 5e-4 * normal(&mut random);
        let offset = 2e-4 * normal(&mut random);
        let heights = oscillate(law, strength, hidden, late_s);
        let value = heights.into_iter().map(|x| Some(x + offset + NOISE_M * normal(&mut random))).collect();
        Observed {
            name: format!("push {strength}"),
            interval_s: INTERVAL_S,
            lag_s: 1e-3,
            channels: vec![ObservedChannel { value, sigma_m: NOISE_M, offset_m: 2.5e-4 }],
        }
    };
    STRENGTHS.map(one).to_vec()
}

const RANGE: SizeRange = SizeRange { bounds: (0.0, 10.0), neutral: 0.0 };

fn sized(toy: &Toy, observed: &[Observed], range: SizeRange, first: f64) -> Result<Level, SizingError> {
    let search = SizeSearch { forward: toy, observed, range, others: &OTHERS, packings: 3, most_sizes: 9 };
    let sizes = vec![range.neutral, first, 2.0 * first];
    search.run(&Start { sizes, others: vec![0.0], slopes: None })
}

fn half(level: &Level) -> f64 {
    let [curvature, packings] = level.variance[0];
    SizeVariance { curvature, packings, ..SizeVariance::default() }.half_width()
}

fn dry(size: f64) -> Law {
    Law { dry: size, viscosity: 0.0, quadratic: 0.0 }
}

#[test]
fn nine_in_ten_intervals_cover_the_truth() {
    let (mut held, mut widths, mut errors) = (0, 0.0, 0.0_f64);
    const TRIALS: u64 = 60;
    for seed in 0..TRIALS {
        let truth = 0.15 + 0.01 * (seed % 20) as f64;
        let hidden = Law { viscosity: 0.03 * ((seed % 7) as f64 - 3.0) / 2.0, ..dry(truth) };
        // The rough size is a third to two thirds of the truth, as the reduced model's is at times.
        let toy = Toy { first: 1000 + 10 * seed, ..Toy::new(Kind::Dry) };
        let level = sized(&toy, &measured(hidden, seed), RANGE, [0.37, 0.5, 0.63][seed as usize % 3] * truth)
            .expect("it is sized");
        assert!(level.stable && level.failures.is_empty(), "{:?}", level.sizes);
        assert!((level.fit.size / truth - 1.0).abs() < 0.25, "{} for {truth}", level.fit.size);
        held += u32::from((level.fit.size - truth).abs() <= half(&level));
        errors += (level.fit.size / truth - 1.0).powi(2) / TRIALS as f64;
        widths += half(&level) / truth / TRIALS as f64;
    }
    println!(
        "{held} of {TRIALS} intervals cover the truth, mean half-width {:.1} % of it, rms error {:.1} %",
        100.0 * widths,
        100.0 * errors.sqrt()
    );
    assert!((48..=59).contains(&held), "{held} of {TRIALS}");
    assert!(widths < 0.3, "{widths}");
}

#[test]
fn a_size_hardly_depends_on_where_the_search_begins() {
    let spread = |seed: u64| {
        let observed = measured(Law { viscosity: 0.08, ..dry(0.25) }, seed);
        let toy = Toy { first: 1000 + 10 * seed, ..Toy::new(Kind::Dry) };
        let found = [0.075, 0.1, 0.125, 0.2].map(|first| {
            let level = sized(&toy, &observed, RANGE, first).expect("it is sized");
            assert!(level.stable, "{:?}", level.sizes);
            level.fit.size / 0.25
        });
        found.into_iter().fold(f64::MIN, f64::max) - found.into_iter().fold(f64::MAX, f64::min)
    };
    let mut spreads: Vec<f64> = (0..12).map(spread).collect();
    spreads.sort_by(f64::total_cmp);
    println!("sizes from four first sizes differ by {spreads:.3?} of the truth");
    // Where a viscosity that moved by a step was not simulated again, and a derivative was that between none and half of the
    // size, half of them differed by more than 0.026.
    assert!(spreads[5] < 0.018 && spreads[11] < 0.055, "{spreads:.3?}");
}

#[test]
fn the_fewer_numbers_count_the_more_the_viscosity_is_that_of_the_prior() {
    let observed = measured(Law { viscosity: 0.08, ..dry(0.25) }, 3);
    let level = sized(&Toy::new(Kind::Dry), &observed, RANGE, 0.125).expect("it is sized");
    let viscosity = |alike: f64| level.weighted(alike).others[0];
    assert!((viscosity(1.0) - level.fit.others[0]).abs() < 1e-12 && level.fit.others[0].abs() > 0.01);
    let (all, some, none) = (viscosity(1.0).abs(), viscosity(1e3).abs(), viscosity(1e9).abs());
    assert!(all > some && some > none, "{all} {some} {none}");
    // The mean over the packings, which it starts from, is not weighted.
    let shift = level.fit.others[0] - level.mapped.emulator.minimum(RANGE.bounds, None).others[0];
    assert!(none < shift.abs() + 1e-3, "{none} {shift}");
}

#[test]
fn a_size_far_beyond_the_rough_one_is_reached_in_a_few_simulations() {
    let toy = Toy::new(Kind::Dry);
    let level = sized(&toy, &measured(dry(0.3), 3), RANGE, 0.06).expect("it is sized");
    assert!((level.fit.size - 0.3).abs() < 0.05 && level.end.is_none(), "{:?}", level.fit);
    // Sizes, one step of the viscosity, two further packings.
    assert!(level.stable && level.sizes.len() <= 8, "{:?}", level.sizes);
    assert_eq!(toy.asked.borrow().len(), level.sizes.len() + 3);
}

#[test]
fn a_size_at_the_end_of_its_range_is_said() {
    let observed = measured(dry(0.3), 4);
    let low = SizeRange { bounds: (0.0, 0.2), neutral: 0.0 };
    let level = sized(&Toy::new(Kind::Dry), &observed, low, 0.09).expect("it is sized");
    assert_eq!(level.end, Some(0.2), "{:?}", level.fit);
    // Nothing is hidden, less than nothing fits best: the size stands at the absent effect.
    let thinner = Law { viscosity: -0.3, ..dry(0.0) };
    let level = sized(&Toy::new(Kind::Dry), &measured(thinner, 5), RANGE, 0.1).expect("it is sized");
    assert!(level.fit.size <= half(&level), "{:?} {}", level.fit, half(&level));
}

#[test]
fn a_simulator_that_fails_bounds_the_search_and_is_said() {
    let toy = Toy { breaks: 0.25, ..Toy::new(Kind::Dry) };
    let level = sized(&toy, &measured(dry(0.2), 6), RANGE, 0.15).expect("it is sized");
    assert_eq!(level.failures.len(), 1, "{:?}", level.failures);
    assert!(level.failures[0].reason.contains("left the glass") && level.failures[0].size > 0.25);
    assert!((level.fit.size - 0.2).abs() < 0.05, "{:?}", level.fit);
    let none = Toy { breaks: 0.05, ..Toy::new(Kind::Dry) };
    let refused = sized(&none, &measured(dry(0.2), 6), RANGE, 0.15).expect_err("only nothing is left");
    assert!(refused.to_string().contains("failed at all sizes but 1"), "{refused}");
}

#[test]
fn the_right_law_beats_its_rival_and_itself_ties() {
    let observed = measured(dry(0.3), 8);
    let names: Vec<String> = observed.iter().map(|observed| observed.name.clone()).collect();
    let scores = |kind: Kind, first: f64| {
        let level = sized(&Toy::new(kind), &observed, RANGE, first).expect("it is sized");
        Scores::left_out(&level.mapped, &names, 0.0)
    };
    let (right, rival) = (scores(Kind::Dry, 0.15), scores(Kind::Quadratic, 2.0));
    println!("{:.0} for {:.0}, decisive {:.2}", right.squares(), rival.squares(), right.decisive_ratio());
    assert!(right.beat(&rival) && !rival.beat(&right));
    assert!(right.beat_absent());
    assert!(!right.beat(&right.clone()));
}

/// Returns why the simulator refutes an effect of the library in the place of the toy's, as `level` found it.
fn refuted(level: &Level, is_controlled: bool) -> Option<String> {
    let entry = EffectKind::YieldStress.effect();
    let candidate = SizingCandidate {
        names: vec![entry.name],
        active: vec![Active { entry, values: entry.neutral() }],
        free: vec![(0, 0)],
        viscosity_deviation: Some(OTHERS[0].prior.deviation),
    };
    let stated = Stated { consistency_pa_sn: 0.2, radius_m: 0.035, fill_m: 0.07 };
    refutation(&candidate, level, &stated, is_controlled)
}

#[test]
fn a_law_at_the_end_of_its_range_or_beside_another_viscosity_is_refuted() {
    let level = |kind: Kind, hidden: Law, range: SizeRange, seed: u64| {
        sized(&Toy::new(kind), &measured(hidden, seed), range, 0.5 * hidden.dry.max(hidden.quadratic))
            .expect("it is sized")
    };
    for seed in 40..48 {
        let right = level(Kind::Dry, Law { viscosity: 0.03, ..dry(0.3) }, RANGE, seed);
        assert_eq!(refuted(&right, true), None, "{:?}", right.fit);
        // Dry friction cannot stand for a drag that rises with the square, nor can it alone stand for two effects.
        let quadratic = Law { quadratic: 6.0, ..dry(0.0) };
        let wrong = refuted(&level(Kind::Dry, quadratic, RANGE, seed), false);
        assert!(wrong.is_some_and(|said| said.contains("the end of its range")), "{seed}");
        assert_eq!(refuted(&level(Kind::Quadratic, quadratic, RANGE, seed), true), None);
        let two = level(Kind::Dry, Law { viscosity: 0.6, ..dry(0.3) }, RANGE, seed);
        let said = refuted(&two, true);
        assert!(
            said.is_some_and(|said| said.contains("beside yield_stress the viscosity has to be 1.")),
            "{:?}",
            two.fit
        );
        assert_eq!(refuted(&two, false), None, "it may be the simulator's own");
        let low = SizeRange { bounds: (0.0, 0.2), neutral: 0.0 };
        let end = refuted(&level(Kind::Dry, dry(0.3), low, seed), false);
        assert!(end.is_some_and(|said| said.contains("the end of its range")), "{seed}");
    }
}

#[test]
fn a_finer_model_corrects_the_size_with_the_derivatives_of_the_coarse_one() {
    let observed = measured(dry(0.25), 11);
    // The coarse model finds a tenth too little, as one that rubs too much by itself does.
    let coarse =
        sized(&Toy { rubs: 1.1, ..Toy::new(Kind::Dry) }, &observed, RANGE, 0.12).expect("it is sized");
    let fine = Toy::new(Kind::Dry);
    let search = SizeSearch {
        forward: &fine,
        observed: &observed,
        range: RANGE,
        others: &OTHERS,
        packings: 3,
        most_sizes: 5,
    };
    let found = coarse.fit.size;
    let slopes = Some(coarse.slopes.clone());
    let start = Start { sizes: vec![found, 1.2 * found], others: coarse.fit.others.clone(), slopes };
    let level = search.run(&start).expect("it is sized");
    println!("{found:.4} by the coarse model, {:.4} by the fine one, of 0.25", level.fit.size);
    // In the same packings, whose own friction is not that of the hidden one, the sizes differ by the error alone.
    assert!((level.fit.size / found - 1.1).abs() < 0.02, "{found} {:?}", level.fit);
    // No further step of the viscosity: sizes and two packings.
    assert_eq!(fine.asked.borrow().len(), level.sizes.len() + 2);
    let spacing = spacing_error((7.0, found), (5.0, level.fit.size)).variance.sqrt();
    assert!(spacing > 0.3 * (level.fit.size - found).abs(), "{spacing}");
}

#[test]
fn a_search_that_is_repeated_gives_the_same_bits() {
    let observed = measured(dry(0.25), 9);
    let run = || sized(&Toy::new(Kind::Dry), &observed, RANGE, 0.1).expect("it is sized");
    let (one, other) = (run(), run());
    assert_eq!((one.fit, one.sizes), (other.fit, other.sizes));
}

#[test]
fn the_toy_rests_before_it_is_pushed() {
    let series: Series = vec![oscillate(dry(0.2), 2.0, [0.0; 3], 0.0)];
    assert!(series[0][..18].iter().all(|x| *x == 0.0) && series[0].iter().any(|x| x.abs() > 1e-3));
}
