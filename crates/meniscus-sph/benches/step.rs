//! A step of the simulator beside the bound of what its pairs have to hand over.
//!
//! `cargo bench -p meniscus-sph --bench step`. The figure to look at is a step over the bound of the same run: times alone say
//! as much about the machine's other guests. A step of 0.8 ms of calm water forms two sums over all pairs of neighbours,
//! so that it cannot be quicker than reading eight numbers of each neighbour and adding eight to its sum, twice, in single precision.

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use meniscus_data::effects::Effects;
use meniscus_data::glass::WallShape;
use meniscus_data::liquids::Liquid;
use meniscus_data::recording::Glass;
use meniscus_sph::validate::Mode;
use meniscus_sph::{Setup, Simulator};
use std::hint::black_box;

/// Spacing of the particles, m.
const SPACING_M: f64 = 0.005;

/// Support of the kernel in spacings.
const SUPPORT: f64 = 2.8;

/// Numbers of a particle or of its sum: half a cache line.
#[derive(Clone, Copy)]
#[repr(align(32))]
struct Line([f32; 8]);

impl Line {
    fn add(&mut self, other: &Self) {
        self.0.iter_mut().zip(other.0).for_each(|(to, x)| *to += x);
    }
}

/// `liquid` whose first mode started with `speed_m_s` and ran for `seconds`.
fn glass(liquid: &str, speed_m_s: f64, seconds: f64) -> Simulator {
    let setup = Setup {
        glass: Glass { radius_m: 0.035, fill_m: 0.07, rim_m: 0.11, wall: WallShape::UPRIGHT },
        liquid: Liquid::load(liquid).expect("a known liquid"),
        spacing_m: SPACING_M,
        seed: 0,
        no_slip: true,
        effects: Effects::default(),
        step_s: None,
    };
    let mut simulator = Simulator::new(&setup).expect("the glass settles");
    let mode = Mode::first(setup.glass);
    simulator.set_velocity(|x| mode.velocity(x).map(|v| speed_m_s * v));
    while simulator.time_s() < seconds {
        simulator.step(|_| 0.0).expect("it stays in the glass");
    }
    simulator
}

/// The neighbours of each particle within the support that come after it.
fn neighbours(simulator: &Simulator) -> Vec<Vec<u32>> {
    let places: Vec<[f64; 3]> = simulator.motion().map(|(x, ..)| x).collect();
    let reach = SUPPORT * SPACING_M;
    let near = |a: &[f64; 3], b: &[f64; 3]| {
        a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>() < reach * reach
    };
    let after = |i: usize| -> Vec<u32> {
        (i + 1..places.len()).filter(|j| near(&places[i], &places[*j])).map(|j| j as u32).collect()
    };
    (0..places.len()).map(after).collect()
}

fn step(criterion: &mut Criterion) {
    meniscus_platform::cpu_features::widen();
    let calm = glass("water", 0.05, 0.02);
    let lists = neighbours(&calm);
    let lines: Vec<Line> = calm
        .motion()
        .map(|(x, v, m)| Line([x[0], x[1], x[2], v[0], v[1], v[2], m, 0.0].map(|x| x as f32)))
        .collect();
    let mut sums = vec![Line([0.0; 8]); lines.len()];
    let mut group = criterion.benchmark_group("step");
    group.sample_size(20);
    group.bench_function("bound: hand eight numbers over in every pair, twice", |bencher| {
        bencher.iter(|| {
            for _ in 0..2 {
                for (i, list) in black_box(&lists).iter().enumerate() {
                    let mut own = Line([0.0; 8]);
                    for j in list {
                        own.add(&lines[*j as usize]);
                        sums[*j as usize].add(&lines[i]);
                    }
                    sums[i].add(&own);
                }
            }
            sums[0].0[0]
        });
    });
    let splash = glass("water", 0.6, 0.15);
    let thick = glass("ketchup", 0.2, 0.05);
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start");
        for (name, simulator) in [("calm water", &calm), ("breaking water", &splash), ("ketchup", &thick)] {
            group.bench_function(format!("0.8 ms of {name}, {threads} threads"), |bencher| {
                let next = |mut simulator: Simulator| {
                    pool.install(|| simulator.step(|_| 0.0).expect("it stays in the glass"));
                    simulator
                };
                bencher.iter_batched(|| simulator.clone(), next, BatchSize::PerIteration);
            });
        }
    }
    group.finish();
}

criterion_group!(benches, step);
criterion_main!(benches);
