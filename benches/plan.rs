//! A plan and its renewal, beside one forecast of the motion by the whole model.
//!
//! `cargo bench -p meniscus-benches --bench plan`. Every plan is verified by at least one forecast, which is the bound. A renewed
//! plan has 20 ms (`solve_ms_p99` of `meniscus plan study`).

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use meniscus::blob::Model;
use meniscus_plan::{LearnedModel, LearnedState, Limits, Receding, Request, SurfaceModel, plan};
use meniscus_platform::files::AlignedBytes;
use std::hint::black_box;

/// A long move below a low limit: as many knots as a program may have.
const REQUEST: Request = Request {
    to_m: 0.45,
    limits: Limits { speed_m_s: 1.5, acceleration_m_s2: 5.0, jerk_m_s3: 60.0 },
    limit_m: 0.005,
    confidence: 0.95,
    residual_m: None,
};

/// Frame of the renewal.
const FRAME: usize = 6;

/// The liquid in that frame under inputs `gain` times those of the motion.
fn measured(learned: &LearnedModel<'_>, motion: &Receding<'_, LearnedModel<'_>>, gain: f64) -> LearnedState {
    let mut state = learned.rest();
    for frame in 1..=FRAME {
        learned.advance(&mut state, gain * motion.input(frame));
    }
    state
}

fn planning(criterion: &mut Criterion) {
    let bytes = AlignedBytes::copy(meniscus_shipped::MODEL);
    let model = Model::load(&bytes).expect("the shipped model");
    let learned = LearnedModel::new(&model);
    let motion = Receding::new(&learned, &learned.rest(), 0.0, &REQUEST).expect("a plan");
    let frames = motion.first().frames.len();
    let inputs: Vec<f64> = (1..=frames).map(|frame| motion.input(frame)).collect();
    let mut group = criterion.benchmark_group("plan");
    group.bench_function("bound: one forecast of the motion", |bencher| {
        bencher.iter(|| learned.forecast(black_box(&learned.rest()), &inputs));
    });
    for (name, gain, programs) in [("renewed, kept", 1.0, 0), ("renewed, changed", 1.5, 1)] {
        let state = measured(&learned, &motion, gain);
        let renewed = motion.clone().renew(FRAME, &state).expect("solved").expect("far from the goal");
        assert!((programs..=2).contains(&renewed.programs), "{name}: {} programs", renewed.programs);
        assert!(programs > 0 || renewed.programs == 0, "{name}: {} programs", renewed.programs);
        group.bench_function(name, |bencher| {
            let again = |mut motion: Receding<'_, _>| motion.renew(FRAME, black_box(&state));
            bencher.iter_batched(|| motion.clone(), again, BatchSize::SmallInput);
        });
    }
    group.sample_size(20);
    group.bench_function("first plan", |bencher| {
        bencher.iter(|| plan(&learned, black_box(&learned.rest()), 0.0, &REQUEST));
    });
    group.finish();
}

criterion_group!(benches, planning);
criterion_main!(benches);
