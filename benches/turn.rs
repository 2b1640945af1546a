//! The turn behind the profile, stage by stage, beside the bound of reading the weights once.
//!
//! `cargo bench -p meniscus-benches --bench turn`. The figure to look at is a stage over the bound of the same run: times
//! alone say as much about the machine's other guests.

use criterion::{Criterion, criterion_group, criterion_main};
use meniscus::blob::Model;
use meniscus::latent::generic::{LATENTS, LatentState};
use meniscus::latent::window::{FEATURES, WINDOW};
use meniscus::runtime::{Estimator, LinearModel, Memory, ModalState, TurnInput};
use meniscus::surface::{POINTS, SurfaceProfile};
use meniscus::units::Micros;
use meniscus_platform::clock::Monotonic;
use meniscus_platform::files::AlignedBytes;
use meniscus_service::controller::{HORIZON_MAX, SpillRisk};
use std::hint::black_box;

/// A profile that sloshes.
fn profile(frame: u32) -> SurfaceProfile {
    let phase = 0.36 * frame as f32;
    SurfaceProfile {
        height_m: std::array::from_fn(|k| 0.07 + 5e-4 * (k as f32 - 10.0) * phase.sin()),
        variance_m2: [1e-8; POINTS],
        valid: [true; POINTS],
        glass_x_m: Some(0.01 * phase.cos()),
        sequence: frame,
        captured: Micros(u64::from(frame) * 16_667),
    }
}

fn turn(criterion: &mut Criterion) {
    let bytes = AlignedBytes::copy(meniscus_shipped::MODEL);
    let model = Model::load(&bytes).expect("the shipped model");
    let mut field = vec![0.0; model.field_len()];
    let mut group = criterion.benchmark_group("turn");

    group.bench_function("bound: read every weight once", |bencher| {
        bencher.iter(|| {
            let words = black_box(&*bytes).as_chunks::<8>().0;
            words.iter().fold(0, |sum: u64, word| sum.wrapping_add(u64::from_le_bytes(*word)))
        });
    });
    group.bench_function("encode: window to latent", |bencher| {
        let rows = [[0.1_f32; FEATURES]; WINDOW];
        bencher.iter(|| model.encoder.encode(black_box(&rows).iter()));
    });
    group.bench_function("predict: one GENERIC step", |bencher| {
        let mut state = LatentState::default();
        let mut frame = 0.0;
        bencher.iter(|| {
            frame += 1.0;
            model.generic.step(&mut state, f64::sin(0.36 * frame))
        });
    });
    group.bench_function("field: latent to 27742 numbers", |bencher| {
        let latent = [0.3; LATENTS];
        bencher.iter(|| {
            let coefficients = model.decoder.coefficients(black_box(&latent), 0.5);
            model.decoder.field(&coefficients, 0.01, &mut field);
        });
    });
    group.bench_function("profile to field, whole", |bencher| {
        let estimator = Estimator::new(&model);
        let (mut memory, mut clock, mut frame) = (Memory::default(), Monotonic::start(), 0);
        bencher.iter(|| {
            frame += 1;
            estimator.turn(&mut memory, TurnInput::tracked(&profile(frame)), &mut clock, &mut field)
        });
    });
    group.finish();
}

/// Parts of a controller's record with the longest plan, beside the turn of which it is (`docs/robots.md`).
fn controller(criterion: &mut Criterion) {
    let bytes = AlignedBytes::copy(meniscus_shipped::MODEL);
    let model = Model::load(&bytes).expect("the shipped model");
    let mut field = vec![0.0; model.field_len()];
    let (estimator, mut memory, mut clock) = (Estimator::new(&model), Memory::default(), Monotonic::start());
    for frame in 0..60 {
        estimator.turn(&mut memory, TurnInput::tracked(&profile(frame)), &mut clock, &mut field);
    }
    let plan = [0.5; HORIZON_MAX];
    let mut group = criterion.benchmark_group("controller");
    group.bench_function("bound: profile to field, whole", |bencher| {
        let (mut memory, mut frame) = (memory.clone(), 60);
        bencher.iter(|| {
            frame += 1;
            estimator.turn(&mut memory, TurnInput::tracked(&profile(frame)), &mut clock, &mut field)
        });
    });
    group
        .bench_function("modal state", |bencher| bencher.iter(|| ModalState::of(&model, black_box(&memory))));
    group.bench_function("linearised model", |bencher| {
        bencher.iter(|| LinearModel::at(&model, black_box(&memory)));
    });
    group.bench_function("forecast of 120 turns with its risk", |bencher| {
        bencher.iter(|| SpillRisk::within(&model, black_box(&memory), HORIZON_MAX, &plan, |_, _| ()));
    });
    group.finish();
}

criterion_group!(benches, turn, controller);
criterion_main!(benches);
